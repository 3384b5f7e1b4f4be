"""Replicator's BasicWriter: the images, labels, boxes and clouds of a camera as files of one folder."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import outputs
from graph.base.errors import RunError
from graph.base.suggest import did_you_mean
from sensors.annotators.annotator import Annotator
from sensors.annotators.registry import find_annotator

from .annotated import AnnotatedWriter

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct

IMAGES = ("rgb", "normals")
SEGMENTATIONS = ("semantic_segmentation", "instance_id_segmentation", "instance_segmentation")
ARRAYS = ("distance_to_camera", "distance_to_image_plane", "motion_vectors")
BOXES = ("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "occlusion")
KINDS = (*IMAGES, *SEGMENTATIONS, *ARRAYS, *BOXES, "pointcloud", "camera_params")
FORMATS = {"png": "PNG", "jpeg": "JPEG", "jpg": "JPEG"}


class BasicWriter(AnnotatedWriter):
    """Writes `<output_dir>/<annotator>_<frame>.<ending>` for each frame and each annotator that is switched on.

    rgb, normals and coloured segmentations are images (`image_output_format`: png or jpeg, of rgb), depths, motion,
    boxes and clouds .npy, labels and camera parameters .json. Frames count from 0, with `frame_padding` digits.
    semantic_types: a list of taxonomies, semantic_filter_predicate: a filter, of what labels count. Nothing is written
    through a link in the folder. Raises ValueError for unknown options, RunError for a folder that cannot be written.
    """

    def __init__(
        self,
        output_dir: str | Path,
        *,
        semantic_types: list[str] | None = None,
        semantic_filter_predicate: str | None = None,
        image_output_format: str = "png",
        frame_padding: int = 4,
        include_unlabelled: bool = False,
        **options: Any,
    ) -> None:
        colours = {f"colorize_{name}": True for name in SEGMENTATIONS}
        known = {**dict.fromkeys(KINDS, False), **colours}
        for name in options:
            if name not in known:
                hint = did_you_mean(name, known, f"it has {', '.join(known)}")
                raise ValueError(f"it has no option {name!r}{hint}")
        if image_output_format not in FORMATS:
            raise ValueError(f"image_output_format {image_output_format!r} is not one of {', '.join(FORMATS)}")
        if not 0 <= frame_padding <= 20:
            raise ValueError(f"frame_padding is {frame_padding}; give 0 to 20 digits")
        self.folder, self._count = Path(output_dir), 0
        self._ending, self._digits = image_output_format, int(frame_padding)
        chosen = {**known, **options}
        self._wanted = [name for name in KINDS if chosen[name]]
        filters = {"semanticTypes": semantic_types, "semanticFilter": semantic_filter_predicate}
        self._filters = {name: value for name, value in filters.items() if value}
        self._options = {name: {"colorize": bool(chosen[f"colorize_{name}"])} for name in SEGMENTATIONS}
        self._options["pointcloud"] = {"includeUnlabelled": bool(include_unlabelled)}

    def attach_to(self, product: RenderProduct) -> None:
        """Attaches the annotators to a camera's product. Raises SensorValueError for another sensor."""
        made = []
        for name in self._wanted:
            kind = find_annotator(name)
            options = {**self._options.get(name, {}), **self._filters}
            mine = {option: value for option, value in options.items() if option in kind.options}
            made.append(Annotator(kind, copies=False).initialize(**mine))
        self.annotators = made
        super().attach_to(product)

    def write(self, data: Mapping[str, Any]) -> None:
        """Writes the files of a frame."""
        number = f"{self._count:0{self._digits}d}"
        self._count += 1
        try:
            outputs.make_folder(self.folder)
            for name, found in data.items():
                for file, content in _files(name, found, self._ending):
                    stem, _, ending = file.rpartition(".")
                    outputs.write(self.folder / f"{stem}_{number}.{ending}", content)
        except OSError as error:
            raise RunError(f"BasicWriter: {self.folder}: {error.strerror or error}; give another output_dir") from error


def _files(name: str, found: Any, ending: str) -> list[tuple[str, bytes | str]]:
    """(file name without the number of the frame, content) of an annotator's data."""
    if name == "camera_params":
        return [(f"{name}.json", _json({key: _plain(value) for key, value in found.items()}))]
    data, info = (found["data"], found["info"]) if isinstance(found, Mapping) else (found, {})
    if name in BOXES:
        labels = [(f"{name}_labels.json", _json(info.get("idToLabels", {})))]
        return [(f"{name}.npy", _npy(data)), *labels, (f"{name}_prim_paths.json", _json(info.get("primPaths", [])))]
    if name == "pointcloud":
        parts = {"": data, "_rgb": info.get("pointRgb"), "_normals": info.get("pointNormals")}
        parts |= {"_semantic": info.get("pointSemantic"), "_instance": info.get("pointInstance")}
        return [(f"{name}{part}.npy", _npy(values)) for part, values in parts.items() if values is not None]
    if name in ARRAYS:
        return [(f"{name}.npy", _npy(data))]
    if name == "rgb":
        return [(f"{name}.{ending}", _picture(data[..., :3] if FORMATS[ending] == "JPEG" else data, FORMATS[ending]))]
    if name == "normals":
        shades = np.rint((np.asarray(data)[..., :3] * 0.5 + 0.5) * 255).astype(np.uint8)
        return [(f"{name}.png", _picture(shades))]
    files = [(f"{name}.png", _picture(data))]
    if name == "semantic_segmentation":
        return [*files, (f"{name}_labels.json", _json(info["idToLabels"]))]
    semantics = _json(info["idToSemantics"])
    mapping = _json(info["idToLabels"])
    return [*files, (f"{name}_mapping.json", mapping), (f"{name}_semantics_mapping.json", semantics)]


def _picture(data: np.ndarray, form: str = "PNG") -> bytes:
    """An image file of (height, width, 3 or 4) uint8; numbers (height, width) uint32 become 16 bit."""
    from PIL import Image

    image = np.asarray(data)
    if image.dtype != np.uint8:
        image = image.astype(np.uint16)
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(stream, format=form)
    return stream.getvalue()


def _npy(data: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.asarray(data), allow_pickle=False)
    return stream.getvalue()


def _json(data: Any) -> str:
    return json.dumps(data, indent=None, default=str)


def _plain(value: Any) -> Any:
    return np.asarray(value).tolist() if isinstance(value, np.ndarray | np.generic) else value
