"""The annotator camera_params: where a camera is and what its lens is like, keys and conventions as in Replicator."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.transforms import inverse_rigid
from sensors.annotators.types import Reading

from .config import CameraConfig
from .lens import FisheyeLens, FthetaLens, ParallelLens
from .prism_lens import PrismFisheyeLens


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
