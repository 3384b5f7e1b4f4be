"""The annotators of cameras, named and shaped as in Replicator."""

from __future__ import annotations

import colorsys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.transforms import inverse_rigid
from sensors.annotators.types import AnnotatorType, Reading
from sensors.channels import CHANNELS

from .channels import (
    AROUND,
    BOX,
    CROSS,
    FIRST,
    FLAT_BOX,
    HDR,
    INSTANCE,
    LABELLED,
    LOOSE,
    RGB,
    SEMANTIC,
    SOLID_BOX,
    TIGHT,
)
from .config import CameraConfig
from .label_filter import OPTIONS, check_filter, kept_labels
from .lens import FisheyeLens, FthetaLens, ParallelLens, PrismFisheyeLens
from .names import MODALITY
from .stereo_depth import STEREO_ANNOTATORS

if TYPE_CHECKING:
    from .entities import Entities


HIDDEN = np.dtype([("instanceId", "<u4"), ("semanticId", "<u4"), ("occlusionRatio", "<f4")])


def _classes(reading: Reading) -> tuple[dict[int, int], dict[int, dict[str, str]]]:
    """Number of a labelled prim -> number of its labels, from 0; number of labels -> what they are.

    Only labels that the options let through, and prims with any of them.
    """
    from .entities import entities_of  # which needs USD

    labels = entities_of(reading.world, LABELLED).labels
    kept = {number: kept_labels(found, reading.options) for number, found in labels.items()}
    texts = {number: tuple(sorted(found.items())) for number, found in kept.items() if found}
    place = {text: number for number, text in enumerate(sorted(set(texts.values())))}
    classes = {number: place[text] for number, text in texts.items()}
    return classes, {number: dict(text) for text, number in place.items()}


def _boxes(kind: str) -> Callable[[Reading], dict[str, Any]]:
    fields = SOLID_BOX if kind in (BOX, AROUND) else FLAT_BOX

    def read(reading: Reading) -> dict[str, Any]:
        given = np.dtype([("semanticId", "<u4"), *fields])
        if reading.frame is None:
            empty = {"idToLabels": {}, "bboxIds": np.empty(0, np.uint32), "primPaths": []}
            return {"data": np.empty(0, given), "info": empty}
        from .entities import entities_of

        classes, labels = _classes(reading)
        boxes = reading.frame.channel(kind)
        boxes = boxes[np.isin(boxes["instance"], list(classes))]
        numbers = boxes["instance"].tolist()
        data = np.empty(len(boxes), given)
        data["semanticId"] = [classes[number] for number in numbers]
        for name, *_ in fields:
            data[name] = boxes[name]
        paths = entities_of(reading.world, LABELLED).paths
        info = {
            "idToLabels": {number: labels[number] for number in sorted(set(data["semanticId"].tolist()))},
            "bboxIds": boxes["instance"] - np.uint32(FIRST),
            "primPaths": [paths[number] for number in numbers],
        }
        return {"data": data, "info": info}

    return read


def _occlusion(reading: Reading) -> np.ndarray:
    found = _boxes(LOOSE)(reading)
    data = np.empty(len(found["data"]), HIDDEN)
    data["instanceId"], data["semanticId"] = found["info"]["bboxIds"] + np.uint32(FIRST), found["data"]["semanticId"]
    data["occlusionRatio"] = found["data"]["occlusionRatio"]
    return data


def _annotator(kind: str, name: str) -> AnnotatorType:
    return AnnotatorType(
        name, _boxes(kind), lambda reading: (kind,), options=OPTIONS, modality=MODALITY, check=check_filter
    )


BOX_ANNOTATORS = (
    *(_annotator(kind, f"{kind}{fast}") for kind in (TIGHT, LOOSE, BOX) for fast in ("", "_fast")),
    _annotator(AROUND, AROUND),
    AnnotatorType(
        "occlusion", _occlusion, lambda reading: (LOOSE,), options=OPTIONS, modality=MODALITY, check=check_filter
    ),
)


def camera_params(reading: Reading) -> dict[str, Any]:
    """The parameters of the newest frame; nothing before the first.

    cameraViewTransform: world to camera, 16 numbers of a matrix for row vectors [stage units]. cameraProjection: to
    clip space, for row vectors, depth reversed and without a far end: m00 = 2 f / aperture, m11 = m00 W / H,
    m23 = -1, m32 = near. Focal length, aperture and offsets are in tenths of a stage unit, as on the prim.
    """
    frame = reading.frame
    if frame is None:
        return {}
    config: CameraConfig = frame.config
    pose = frame.end.world_sensor.copy()
    pose[:3, 3] /= reading.scene.meters_per_unit
    return {
        "cameraAperture": np.array(config.film, np.float32),
        "cameraApertureOffset": np.array(config.offsets, np.float32),
        "cameraFocalLength": config.focal_length,
        "cameraFocusDistance": config.focus_distance,
        "cameraFStop": config.f_stop,
        "cameraModel": _model(config),
        "cameraNearFar": np.array(config.clipping, np.float32),
        "cameraProjection": projection(config).reshape(-1),
        "cameraViewTransform": inverse_rigid(pose).T.reshape(-1),
        "metersPerSceneUnit": reading.scene.meters_per_unit,
        "renderProductResolution": np.array(config.size, np.int32),
        **_fisheye(config),
    }


def projection(config: CameraConfig) -> np.ndarray:
    """(4, 4) float64, camera to clip space, row vectors; of a lens that distorts, that of its straight pinhole."""
    out = np.zeros((4, 4))
    for side, (film, offset) in enumerate(zip(config.film, config.offsets, strict=True)):
        out[side, side], out[2, side] = 2 * config.focal_length / film, 2 * offset / film
    out[2, 3], out[3, 2] = -1.0, config.clipping[0]
    return out


def _model(config: CameraConfig) -> str:
    lens = config.lens
    if isinstance(lens, ParallelLens):
        return "orthographic"
    if isinstance(lens, FthetaLens):
        return "ftheta"
    return "pinhole" if lens.is_pinhole else "fisheye" if isinstance(lens, FisheyeLens) else "opencvPinhole"


def _fisheye(config: CameraConfig) -> dict[str, Any]:
    """The numbers of an f-theta lens, and the tangential and prism terms of a fisheye; 0 for every other."""
    lens = config.lens
    ftheta = lens if isinstance(lens, FthetaLens) else None
    prism = lens if isinstance(lens, PrismFisheyeLens) else None
    polynomial = np.zeros(6, np.float32)
    if ftheta is not None:
        polynomial[: len(ftheta.coefficients)] = ftheta.coefficients
    centre = (lens.cx / lens.fx, lens.cy / lens.fy) if ftheta else (0.0, 0.0)
    return {
        "cameraFisheyeLensP": np.array(prism.p if prism else (0.0,) * 2, np.float32),
        "cameraFisheyeLensS": np.array(prism.s if prism else (0.0,) * 4, np.float32),
        "cameraFisheyeMaxFOV": float(np.rad2deg(2 * ftheta.most)) if ftheta else 0.0,
        "cameraFisheyeNominalHeight": round(lens.height / lens.fy) if ftheta else 0,
        "cameraFisheyeNominalWidth": round(lens.width / lens.fx) if ftheta else 0,
        "cameraFisheyeOpticalCentre": np.array(centre, np.float32),
        "cameraFisheyePolynomial": polynomial,
    }


COLORIZE = {"colorize": False}
GOLDEN_TURN = 0.61803398875


def _image(name: str, width: int = 1) -> Callable[[Reading], np.ndarray]:
    """Reads an image; width: numbers a pixel that Replicator gives, those beyond the channel's 0."""

    def read(reading: Reading) -> np.ndarray:
        frame = reading.frame
        array = CHANNELS[name].empty() if frame is None else frame.channel(name)
        if width <= CHANNELS[name].width:
            return array
        padded = np.zeros((*array.shape[:2], width), array.dtype)
        padded[..., : array.shape[2]] = array
        return padded

    return read


def _one(kind: str, name: str, width: int = 1) -> AnnotatorType:
    return AnnotatorType(name, _image(kind, width), lambda reading: (kind,), modality=MODALITY)


def _seen(numbers: np.ndarray) -> list[int]:
    """The numbers that are in an image, rising."""
    if not numbers.size:
        return []
    there = np.zeros(int(numbers.max()) + 1, bool)
    there[numbers.reshape(-1)] = True
    return [int(number) for number in np.flatnonzero(there)]


def _entities(reading: Reading, kind: str) -> Entities:
    from .entities import entities_of  # which needs USD

    return entities_of(reading.world, kind)


def _semantic(reading: Reading) -> dict[str, Any]:
    numbers = _image(SEMANTIC)(reading)
    if reading.frame is None:
        return {"data": numbers, "info": {"idToLabels": {}}}
    labels = _entities(reading, SEMANTIC).labels
    if any(reading.options[name] for name in OPTIONS):
        numbers, labels = _renumbered(numbers, labels, reading.options)
    shown = {number: dict(labels[number]) for number in _seen(numbers)}
    if reading.options["colorize"]:
        return _coloured(numbers, shown, {})
    return {"data": numbers, "info": {"idToLabels": {str(number): found for number, found in shown.items()}}}


def _renumbered(
    numbers: np.ndarray, labels: Mapping[int, dict[str, str]], options: Mapping[str, Any]
) -> tuple[np.ndarray, dict[int, dict[str, str]]]:
    """The numbers and labels that are left by a filter; what has no label any more is 1."""
    kept = {number: kept_labels(found, options) for number, found in labels.items() if number >= FIRST}
    texts = sorted({tuple(sorted(found.items())) for found in kept.values() if found})
    place = {key: number for number, key in enumerate(texts, start=FIRST)}
    table = np.arange(max(labels) + 1, dtype=np.uint32)
    for number, found in kept.items():
        table[number] = place[tuple(sorted(found.items()))] if found else 1
    return table[numbers], {0: labels[0], 1: labels[1]} | {number: dict(key) for key, number in place.items()}


def _check_pair(reading: Reading) -> None:
    from .correspondence import reference_of

    reference_of(reading.scene, reading.product.camera_path)


def _instances(kind: str) -> Callable[[Reading], dict[str, Any]]:
    nothing = "INVALID" if kind == INSTANCE else "BACKGROUND"

    def read(reading: Reading) -> dict[str, Any]:
        numbers = _image(kind)(reading)
        if reading.frame is None:
            return {"data": numbers, "info": {"idToLabels": {}, "idToSemantics": {}}}
        entities = _entities(reading, kind)
        numbers = _labelled_only(numbers, entities, reading.options) if kind == LABELLED else numbers
        shown = {number: entities.paths.get(number, ("UNLABELLED", nothing)[number == 0]) for number in _seen(numbers)}
        labels = {number: _semantics_of(number, entities, nothing) for number in shown}
        if reading.options["colorize"]:
            return _coloured(numbers, shown, labels)
        return {"data": numbers, "info": {"idToLabels": shown, "idToSemantics": labels}}

    return read


def _labelled_only(numbers: np.ndarray, entities: Entities, options: Mapping[str, Any]) -> np.ndarray:
    """Entities whose labels a filter takes away count as unlabelled."""
    gone = [number for number, found in entities.labels.items() if not kept_labels(found, options)]
    return np.where(np.isin(numbers, gone), np.uint32(1), numbers) if gone else numbers


def _semantics_of(number: int, entities: Entities, nothing: str) -> dict[str, str]:
    if number == 0:
        return {"class": nothing}
    return dict(entities.labels.get(number) or {"class": "UNLABELLED"})


def _coloured(numbers: np.ndarray, shown: Mapping[int, Any], labels: Mapping[int, Any]) -> dict[str, Any]:
    """Numbers as colours, (height, width, 4) uint8; the tables have colours, as text, for numbers."""
    table = np.array([colour_of(number) for number in range(max(shown, default=0) + 1)], np.uint8)
    info = {"idToLabels": {str(tuple(table[number].tolist())): found for number, found in shown.items()}}
    if labels:
        info["idToSemantics"] = {str(tuple(table[number].tolist())): found for number, found in labels.items()}
    return {"data": table[numbers], "info": info}


def colour_of(number: int) -> tuple[int, int, int, int]:
    """The colour of an entity, r, g, b, a: transparent for nothing, black for what has no label."""
    if number < FIRST:
        return 0, 0, 0, 255 * number
    red, green, blue = colorsys.hsv_to_rgb(number * GOLDEN_TURN % 1.0, 0.65 + 0.35 * (number % 2), 0.9)
    return round(red * 255), round(green * 255), round(blue * 255), 255


def _segmentation(kind: str, name: str) -> AnnotatorType:
    read = _semantic if kind == SEMANTIC else _instances(kind)
    options = COLORIZE if kind == INSTANCE else {**COLORIZE, **OPTIONS}
    return AnnotatorType(name, read, lambda reading: (kind,), options=options, modality=MODALITY, check=check_filter)


CLOUD = ("points", "normals", RGB, SEMANTIC, LABELLED)


def _point_cloud(reading: Reading) -> dict[str, Any]:
    """What pixels show, as points in the world [stage units]; of what has labels, unless includeUnlabelled."""
    frame = reading.frame
    if frame is None:
        return {"data": np.empty((0, 3), np.float32), "info": {}}
    least = 1 if reading.options["includeUnlabelled"] else FIRST
    shown = frame.channel(SEMANTIC) >= least
    normals = np.zeros((int(shown.sum()), 4), np.float32)
    normals[:, :3] = frame.channel("normals")[shown]
    return {
        "data": frame.channel("points")[shown] / np.float32(reading.scene.meters_per_unit),
        "info": {
            "pointRgb": _rgba(reading)[shown].reshape(-1),
            "pointNormals": normals.reshape(-1),
            "pointSemantic": frame.channel(SEMANTIC)[shown],
            "pointInstance": frame.channel(LABELLED)[shown],
        },
    }


def _rgba(reading: Reading) -> np.ndarray:
    """Colours with an alpha of 255."""
    found = _image(RGB, 4)(reading)
    found[..., 3] = 255
    return found


def _hdr(reading: Reading) -> np.ndarray:
    found = _image(HDR, 4)(reading)
    found[..., 3] = 1
    return found


ANNOTATORS = (
    *(AnnotatorType(name, _rgba, lambda reading: (RGB,), modality=MODALITY) for name in ("rgb", "LdrColor")),
    AnnotatorType("HdrColor", _hdr, lambda reading: (HDR,), modality=MODALITY),
    _one("distance_to_camera", "distance_to_camera"),
    _one("distance_to_image_plane", "distance_to_image_plane"),
    _one("normals", "normals", 4),
    _segmentation(SEMANTIC, SEMANTIC),
    _one("motion_vectors", "motion_vectors", 4),
    *(
        AnnotatorType(name, _image(CROSS), lambda reading: (CROSS,), modality=MODALITY, check=_check_pair)
        for name in (CROSS, "CrossCorrespondence")
    ),
    *BOX_ANNOTATORS,
    *STEREO_ANNOTATORS,
    AnnotatorType(
        "pointcloud", _point_cloud, lambda reading: CLOUD, options={"includeUnlabelled": False}, modality=MODALITY
    ),
    AnnotatorType("camera_params", camera_params, lambda reading: (), modality=MODALITY),
    *(_segmentation(kind, f"{kind}{fast}") for kind in (LABELLED, INSTANCE) for fast in ("", "_fast")),
)
