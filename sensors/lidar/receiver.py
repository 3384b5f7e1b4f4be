"""The receiver: from reflected light to a return and its intensity, by the range equation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sensors.surfaces.optics import RETRO_GAIN, Optics

from .config import LidarConfig

SurfacesOf = Callable[[np.ndarray], np.ndarray]
"""Rows of hits (k,) -> the numbers (k,) of the surfaces that were hit."""

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

    The chain of the intensity: processing (NORMALIZATION removes the range: reflectance x cos(incidence); any other
    keeps it, relative to a white surface at `nearRangeM`), limited to 1 (retro-reflectors saturate the receiver), then
    mapping (LINEAR, or by tables at equal steps of the input from 0 to 1), then `intensityScalePercent` / 255. The
    exact formula of the original is not public.
    """

    def __init__(self, config: LidarConfig) -> None:
        self._near = np.float32(max(config.near_range_m, 1e-3))
        self._normalised = config.intensity_processing == "NORMALIZATION"
        self._tables = [np.asarray(table, np.float32) for table in _mapping(config) if len(table) > 1]
        self._scale = np.float32(config.intensity_scale_percent / FULL_SCALE)
        reach = config.min_reflection_range_m
        self._least = np.float32(config.min_reflectance / reach**2) if reach > 0 else np.float32(0)

    @property
    def detects(self) -> bool:
        """Whether there is a threshold."""
        return bool(self._least > 0)

    @property
    def least(self) -> float:
        """The least detectable energy, in units of reflectance / range^2 [1/m^2]."""
        return float(self._least)

    def detect(
        self, cosine: np.ndarray, distance: np.ndarray, valid: np.ndarray, surfaces: SurfacesOf, optics: Optics
    ) -> None:
        """Removes returns that are too weak from `valid` (n,).

        cosine: (n,) float32 of the incidence; distance: (n,) float32 [m]. The surfaces are looked up only if the least
        reflective of all would be too weak.
        """
        if self._least > 0:
            least = distance * distance
            least *= self._least
            weak = cosine * (optics.dullest * np.float32(0.999999)) < least
            weak &= valid
            rows = np.flatnonzero(weak)
            reflected = reflected_light(cosine[rows], lambda: surfaces(rows), optics)
            valid[rows[reflected < least[rows]]] = False

    def intensity(self, reflected: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """The scalar of returns, (n,) float32 from 0 to 1; `reflected` as `reflected_light` gives it."""
        out = reflected if self._normalised else reflected * (self._near / np.maximum(distance, self._near)) ** 2
        out = np.minimum(out, np.float32(1.0))
        for table in self._tables:
            out = np.interp(out, np.linspace(0.0, 1.0, len(table)), table).astype(np.float32)
        if self._scale != 1.0:
            out *= self._scale
        return np.asarray(out)


def reflected_light(cosine: np.ndarray, surfaces: Callable[[], np.ndarray], optics: Optics) -> np.ndarray:
    """The light that surfaces return to the sensor, (n,) float32, relative to a white diffuse surface along its normal.

    cosine: (n,) float32 of the incidence, 0 to 1; surfaces: gives the numbers (n,) of the surfaces that were hit.
    """
    if optics.uniform is not None:
        return np.asarray(cosine * optics.uniform)
    surface = surfaces()
    reflected = np.take(optics.reflectance, surface, mode="clip")
    reflected *= cosine
    if optics.has_retro:
        reflected[np.take(optics.retro, surface, mode="clip")] = RETRO_GAIN
    return np.asarray(reflected)


def _mapping(config: LidarConfig) -> list[tuple[float, ...]]:
    """The tables of the intensity mapping, in the order in which they apply."""
    encoding, decoding = config.intensity_mapping_encoding, config.intensity_mapping_decoding
    return {
        "NONLINEAR": [encoding, decoding],
        "NONLINEAR_ENCODING_ONLY": [encoding],
        "NONLINEAR_DECODING_ONLY": [decoding],
    }.get(config.intensity_mapping_type, [])
