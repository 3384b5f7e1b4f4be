"""The receiver: from reflected light to a return and its intensity, by the range equation."""

from __future__ import annotations

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import COMMON, Hits
from sensors.surfaces.optics import RETRO_GAIN, Optics

from .config import LidarConfig

FULL_SCALE = 255.0
"""The `intensityScalePercent` that does not change the intensity."""


class Receiver:
    """A lidar's receiver: turns returned light into detections and intensities.

    The range equation of a beam that hits a diffuse surface with its whole cross-section: the received energy is
    proportional to reflectance x cos(incidence) / range^2 (Wagner et al., "Gaussian decomposition and calibration of a
    novel small- footprint full-waveform digitising airborne laser scanner", ISPRS Journal 60, 2006). The threshold is a
    surface of reflectance `minReflectance` at `minReflectionRangeM`, hit along its normal: it is just detected, and
    weaker returns are dropped. Beam power, aperture and atmosphere are part of that threshold and equal for all
    emitters.

    near, normalised, tables and scale are what the chain below needs.

    The chain of the intensity: processing (NORMALIZATION removes the range: reflectance x cos(incidence); any other
    keeps it, relative to a white surface at `nearRangeM`), limited to 1 (retro-reflectors saturate the receiver), then
    mapping (LINEAR, or by tables at equal steps of the input from 0 to 1), then `intensityScalePercent` / 255. The
    exact formula of the original is not public.
    """

    def __init__(self, config: LidarConfig) -> None:
        self.near = np.float32(max(config.near_range_m, 1e-3))
        self.normalised = config.intensity_processing == "NORMALIZATION"
        self.tables = [np.asarray(table, np.float32) for table in _mapping(config) if len(table) > 1]
        self.scale = np.float32(config.intensity_scale_percent / FULL_SCALE)
        reach = config.min_reflection_range_m
        self._least = np.float32(config.min_reflectance / reach**2) if reach > 0 else np.float32(0)

    @property
    def least(self) -> float:
        """The least detectable energy, in units of reflectance / range^2 [1/m^2]."""
        return float(self._least)

    def intensity(self, reflected: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """The scalar of returns, (n,) float32 from 0 to 1; `reflected` as `returned` gives it."""
        out = reflected if self.normalised else reflected * (self.near / np.maximum(distance, self.near)) ** 2
        out = np.minimum(out, np.float32(1.0))
        for table in self.tables:
            out = np.interp(out, np.linspace(0.0, 1.0, len(table)), table).astype(np.float32)
        if self.scale != 1.0:
            out *= self.scale
        return np.asarray(out)


def returned(
    table: np.ndarray,
    hits: Hits,
    ranges: np.ndarray,
    gates: tuple[np.ndarray, np.ndarray],
    optics: Optics | None,
    least: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Which rays have a return: their rows (k,), and its light, (k,) float32, 1 from a white diffuse surface along its
    normal.

    table: (n, 6) float32, its columns 3 to 5 the directions of the rays; ranges: (n,) float32 [m], as reported, which
    lie between the gates (n,) or (); least: the least energy that is detected. Without optics there is no light and no
    threshold.
    """
    reflectance, retro = (_NONE, _NONE > 0) if optics is None else (optics.reflectance, optics.retro)
    rays = len(table)
    rows, light = np.empty(rays, np.intp), np.empty(rays, np.float32)
    near, far = map(np.atleast_1d, gates)
    normals = COMMON if hits.normals is None else hits.normals
    seen = table, normals, hits.distance, ranges, hits.number, hits.surface_of
    count = _returned(*seen, reflectance, retro, np.float32(RETRO_GAIN), near, far, np.float32(least), rows, light)
    return rows[:count], light[:count]


_NONE = np.zeros(0, np.float32)


@compiled
def _returned(
    table: np.ndarray,
    normals: np.ndarray,
    distance: np.ndarray,
    ranges: np.ndarray,
    number: np.ndarray,
    surface_of: np.ndarray,
    reflectance: np.ndarray,
    retro: np.ndarray,
    retro_gain: np.float32,
    near: np.ndarray,
    far: np.ndarray,
    least: np.float32,
    rows: np.ndarray,
    light: np.ndarray,
) -> int:
    """How many `rows`, each with its `light`, it has written; see `returned`."""
    count = 0
    for ray in range(len(table)):
        there = near[min(ray, len(near) - 1)] <= ranges[ray] <= far[min(ray, len(far) - 1)]
        back = np.float32(0)
        if there and len(reflectance):
            cosine = table[ray, 3] * normals[ray, 0] + table[ray, 4] * normals[ray, 1] + table[ray, 5] * normals[ray, 2]
            surface = surface_of[min(number[ray], len(surface_of) - 1)]
            back = retro_gain if retro[surface] else abs(cosine) * reflectance[surface]
            there = not back < distance[ray] * distance[ray] * least
        if there:
            rows[count], light[count] = ray, back
            count += 1
    return count


def _mapping(config: LidarConfig) -> list[tuple[float, ...]]:
    """The tables of the intensity mapping, in the order in which they apply."""
    encoding, decoding = config.intensity_mapping_encoding, config.intensity_mapping_decoding
    return {
        "NONLINEAR": [encoding, decoding],
        "NONLINEAR_ENCODING_ONLY": [encoding],
        "NONLINEAR_DECODING_ONLY": [decoding],
    }.get(config.intensity_mapping_type, [])
