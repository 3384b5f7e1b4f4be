"""Depth as a stereo camera measures it: by disparity, with its steps, its noise and what only one imager sees.

d = f b / Z with the focal length f [px] and the baseline b; a step or an error of d is Z^2 / (f b) times as much of Z.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import apply
from sensors.annotators.types import AnnotatorType, Reading
from sensors.errors import SensorValueError
from sensors.prim import path_number

from .channels import RGB
from .lens import Lens
from .names import MODALITY

STEREO_API = "OmniSensorDepthSensorSingleViewAPI"
PREFIX = "omni:rtx:post:depthSensor:"
DEPTH = "distance_to_image_plane"
ABOVE_ZERO = ("sensor_size_pixel", "focal_length_pixel", "baseline_mm")
"""Fields of `StereoDepth` that cannot be 0."""


@dataclass(frozen=True)
class StereoDepth:
    """The attributes of OmniSensorDepthSensorSingleViewAPI on a render product, with the schema's names and defaults.

    focal_length_pixel and sensor_size_pixel: of the imager, whose width `sensor_size_pixel` the image stands for.
    noise_mean: the step of disparity [px], 0 switches step and noise off; noise_sigma: its standard error [px], the
    same in squares of noise_downscale_factor_pixel. Distances [m] outside min and max, and disparities above
    max_disparity_pixel, are not measured. enabled: if not, depth is exact.
    """

    baseline_mm: float = 55.0
    focal_length_pixel: float = 897.0
    sensor_size_pixel: float = 1280.0
    max_disparity_pixel: float = 110.0
    min_distance: float = 0.5
    max_distance: float = 1e7
    noise_mean: float = 0.25
    noise_sigma: float = 0.25
    noise_downscale_factor_pixel: float = 1.0
    enabled: bool = True

    def disparity_meter(self, width: int) -> float:
        """f b for an image of this width [px m]: the disparity of what is 1 m away."""
        return self.focal_length_pixel * self.baseline_mm / 1000 * width / self.sensor_size_pixel


NAMES = {
    "baseline_mm": "baselineMM",
    "focal_length_pixel": "focalLengthPixel",
    "sensor_size_pixel": "sensorSizePixel",
    "max_disparity_pixel": "maxDisparityPixel",
    "min_distance": "minDistance",
    "max_distance": "maxDistance",
    "noise_mean": "noiseMean",
    "noise_sigma": "noiseSigma",
    "noise_downscale_factor_pixel": "noiseDownscaleFactorPixel",
    "enabled": "enabled",
}
"""Field -> attribute of the render product, after `PREFIX`."""


def read_stereo(stage: Any, product: str, camera: str) -> StereoDepth:
    """The settings of a render product's prim, else those beside its camera, else of the camera, else the defaults.

    Raises SensorValueError for a number that is not finite or too small.
    """
    found: dict[str, Any] = {}
    for path in (camera, template_path(camera), product):
        prim = stage.GetPrimAtPath(path)
        for field, name in NAMES.items() if prim else ():
            attribute = prim.GetAttribute(PREFIX + name)
            if attribute and attribute.HasAuthoredValue():
                found[field] = checked(f"{path}.{PREFIX}{name}", field, attribute.Get())
    return StereoDepth(**found)


def template_path(camera: str) -> str:
    """Where the settings of the render product of a depth camera are kept beside it."""
    return f"{camera}_render_product"


def checked(where: str, field: str, value: Any) -> float | bool:
    """A value for a field of `StereoDepth`. Raises SensorValueError if it does not fit."""
    if field == "enabled":
        return bool(value)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise SensorValueError(f"{where} {value!r}: give a finite number")
    if number < 0 or (field in ABOVE_ZERO and number <= 0):
        raise SensorValueError(f"{where} {number:g}: give a number above 0")
    return number


def measured(depth: np.ndarray, stereo: StereoDepth, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Depth [m] as measured, in the pixels of the first imager and of the second, (height, width) float32; 0: invalid.

    depth: (height, width) float32 [m] along the view axis, infinite where nothing is. The second imager is to the
    right; what it does not see, beside a near edge or beyond its image, is not measured.
    """
    if not stereo.enabled:
        exact = np.where(np.isfinite(depth), depth, np.float32(0))
        return exact, exact
    height, width = depth.shape
    scale = stereo.disparity_meter(width)
    with np.errstate(divide="ignore"):
        disparity = scale / depth.astype(np.float64)
    column = np.floor(np.arange(width) + 0.5 - disparity).astype(np.int64)
    seen = (disparity > 0) & (column >= 0)
    flat = (np.arange(height)[:, None] * width + np.clip(column, 0, width - 1))[seen]
    nearest = np.zeros(height * width)
    np.maximum.at(nearest, flat, disparity[seen])
    seen[seen] = disparity[seen] > nearest[flat] - 1.0  # less than a pixel of disparity is the same surface
    noisy = _stepped(disparity, stereo, generator)
    second = _stepped(nearest.reshape(height, width), stereo, generator)
    return _distance(noisy, seen, scale, stereo), _distance(second, second > 0, scale, stereo)


def _stepped(disparity: np.ndarray, stereo: StereoDepth, generator: np.random.Generator) -> np.ndarray:
    """Disparities with noise, on the grid of steps."""
    if stereo.noise_mean <= 0:
        return disparity
    square = max(1, round(stereo.noise_downscale_factor_pixel))
    height, width = disparity.shape
    coarse = generator.standard_normal((-(-height // square), -(-width // square)))
    noise = np.repeat(np.repeat(coarse, square, axis=0), square, axis=1)[:height, :width]
    step = stereo.noise_mean
    return np.where(disparity > 0, np.round((disparity + stereo.noise_sigma * noise) / step) * step, 0.0)


def _distance(disparity: np.ndarray, seen: np.ndarray, scale: float, stereo: StereoDepth) -> np.ndarray:
    good = seen & (disparity > 0) & (disparity <= stereo.max_disparity_pixel)
    distance = np.divide(scale, disparity, out=np.zeros_like(disparity), where=good)
    good &= (distance >= stereo.min_distance) & (distance <= stereo.max_distance)
    return np.where(good, distance, 0.0).astype(np.float32)


def _read(reading: Reading) -> tuple[np.ndarray, np.ndarray]:
    frame = reading.frame
    if frame is None:
        return np.empty((0, 0), np.float32), np.empty((0, 0), np.float32)
    generator = np.random.default_rng((reading.scene.seed, path_number(frame.sensor_path), frame.frame_id))
    stereo = read_stereo(reading.scene.stage, reading.product.path, reading.product.camera_path)
    return measured(frame.channel(DEPTH), stereo, generator)


def _positions(reading: Reading) -> np.ndarray:
    """(height, width, 3) float32 [m], world; 0 where nothing is measured."""
    distance, _ = _read(reading)
    if reading.frame is None:
        return np.empty((0, 0, 3), np.float32)
    from .rays import TO_USD

    pose = reading.frame.end.world_sensor
    along = _directions(reading.frame.config.lens).reshape(*distance.shape, 3) * distance[..., None]
    placed = apply(pose[:3, :3] @ TO_USD, along) + pose[:3, 3]
    return np.asarray(np.where(distance[..., None] > 0, placed, 0.0), np.float32)


@lru_cache(maxsize=8)
def _directions(lens: Lens) -> np.ndarray:
    """(n, 3) float64 of all pixels, optical frame, of length 1 along the view axis."""
    found = lens.unproject(lens.centres())
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(found[2] > 0, found / found[2], 0.0).T)


def _colors(reading: Reading) -> np.ndarray:
    """(height, width, 4) uint8; 0 where nothing is measured."""
    distance, _ = _read(reading)
    out = np.zeros((*distance.shape, 4), np.uint8)
    if reading.frame is not None:
        out[..., :3], out[..., 3] = reading.frame.channel(RGB), 255
        out[distance == 0] = 0
    return out


STEREO_ANNOTATORS = (
    AnnotatorType(
        "depth_sensor_distance", lambda reading: _read(reading)[0], lambda reading: (DEPTH,), modality=MODALITY
    ),
    AnnotatorType(
        "depth_sensor_imager", lambda reading: _read(reading)[1], lambda reading: (DEPTH,), modality=MODALITY
    ),
    AnnotatorType("depth_sensor_point_cloud_position", _positions, lambda reading: (DEPTH,), modality=MODALITY),
    AnnotatorType("depth_sensor_point_cloud_color", _colors, lambda reading: (DEPTH, RGB), modality=MODALITY),
)
