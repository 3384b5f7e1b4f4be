"""`lidar.noise` on: the errors of a real lidar, drawn for every scan and the same in every run."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from sensors.prim import path_number

from .config import LidarConfig
from .pattern import Pattern

Floats = float | np.ndarray
_STREAMS = ("range", "azimuth", "elevation", "origin")


@dataclass(frozen=True, slots=True)
class Errors:
    """The errors of one turn, one row per firing of the pattern; None for an error that is off.

    range_m: (N,) float32, added to the range. angles_deg: (2, N) float32, true less reported azimuth and elevation of a
    beam. origin_m: (N, 3) float32, sensor frame, true less nominal origin.
    """

    range_m: np.ndarray | None
    angles_deg: np.ndarray | None
    origin_m: np.ndarray | None


class Noise:
    """The errors of one lidar.

    The angles and origins of beams have normal errors (azimuthErrorMean/Std, elevationErrorMean/Std,
    originErrorMean/Std); the nominal values are reported. The error of a range is the sum of rangeOffsetM, the
    emitter's distanceCorrectionM and a normal error of standard deviation rangeAccuracyM; the range is then rounded to
    whole steps of rangeResolutionM. Errors depend only on the App's seed, the sensor's path and the turn, and each kind
    has its own random stream: other sensors, threads and the slices of a turn do not change them.
    """

    def __init__(self, config: LidarConfig, pattern: Pattern, seed: int, path: str) -> None:
        self._config, self._pattern, self._seed = config, pattern, seed
        self._path = path_number(path)
        self._known: tuple[int, Errors] | None = None
        self._bias = _bias(config, pattern)

    @property
    def margin(self) -> float:
        """The most by which a reported range is off the true one [m]; normal errors: 8 standard deviations."""
        bias = 0.0 if self._bias is None else float(np.abs(self._bias).max(initial=0.0))
        return bias + 8.0 * abs(self._config.range_accuracy_m) + abs(self._config.range_resolution_m)

    def errors(self, turn: int) -> Errors:
        """The errors of the firings of a turn."""
        if self._known is None or self._known[0] != turn:
            self._known = turn, self._drawn(turn)
        return self._known[1]

    def measured(self, distance: np.ndarray, rows: slice | np.ndarray, turn: int) -> np.ndarray:
        """The reported ranges for true ranges (n,) float32 [m] of the firings `rows`; infinite ones stay infinite."""
        error = self.errors(turn).range_m
        out = distance if error is None else distance + error[rows]
        step = np.float32(self._config.range_resolution_m)
        if step > 0:
            out = np.rint(out / step) * step
        return np.asarray(np.maximum(out, np.float32(0.0)))

    def directions(self, rows: slice, turn: int) -> tuple[np.ndarray, float] | None:
        """(3, n) float32 unit directions of beams, sensor frame, and the largest angular error [rad].

        None if all are exact.
        """
        angles = self.errors(turn).angles_deg
        if angles is None:
            return None
        pattern = self._pattern
        azimuth = np.deg2rad(pattern.azimuth_deg[rows] + angles[0, rows])
        elevation = np.deg2rad(pattern.elevation_deg[rows] + angles[1, rows])
        level = np.cos(elevation)
        out = np.empty((3, len(azimuth)), np.float32)
        np.multiply(level, np.cos(azimuth), out=out[0])
        np.multiply(level, np.sin(azimuth), out=out[1])
        np.sin(elevation, out=out[2])
        swing = np.deg2rad(np.abs(angles[:, rows]).sum(axis=0).max(initial=0.0))
        return out, float(swing)

    def origins(self, rows: slice, turn: int) -> np.ndarray | None:
        """(n, 3) float32 [m], sensor frame, origins of beams; None if all start at the sensor's origin."""
        error, exact = self.errors(turn).origin_m, self._pattern.origins
        if error is None:
            return None if exact is None else exact[rows]
        return error[rows] if exact is None else exact[rows] + error[rows]

    def _drawn(self, turn: int) -> Errors:
        config, count = self._config, len(self._pattern)
        ranges = self._normal("range", turn, count, 0.0, config.range_accuracy_m)
        if self._bias is not None:
            ranges = self._bias if ranges is None else ranges + self._bias
        azimuth = self._normal("azimuth", turn, count, config.azimuth_error_mean, config.azimuth_error_std)
        elevation = self._normal("elevation", turn, count, config.elevation_error_mean, config.elevation_error_std)
        angles = None
        if azimuth is not None or elevation is not None:
            zero = np.zeros(count, np.float32)
            angles = np.stack([zero if azimuth is None else azimuth, zero if elevation is None else elevation])
        mean, deviation = map(np.array, (config.origin_error_mean, config.origin_error_std))
        return Errors(ranges, angles, self._normal("origin", turn, (count, 3), mean, deviation))

    def _normal(
        self,
        stream: str,
        turn: int,
        size: int | tuple[int, int],
        mean: float | np.ndarray,
        deviation: float | np.ndarray,
    ) -> np.ndarray | None:
        """Normal float32 errors; None where all are 0."""
        if not np.any(mean) and not np.any(deviation):
            return None
        entropy = [self._seed & (2**64 - 1), self._path, turn, _STREAMS.index(stream)]
        generator = np.random.Generator(np.random.SFC64(np.random.SeedSequence(entropy)))
        draws = generator.standard_normal(size, np.float32)
        draws *= np.float32(deviation)
        draws += np.float32(mean)
        return draws


def _bias(config: LidarConfig, pattern: Pattern) -> np.ndarray | None:
    """The constant range error of every firing, (N,) float32 [m], or None."""
    bias = np.full(len(pattern), config.range_offset_m, np.float32)
    for number, state in enumerate(config.emitter_states):
        if len(state.distance_correction_m):
            fired = pattern.tick_state == number
            bias[fired] += state.distance_correction_m[pattern.emitter_id[fired]]
    return bias if bias.any() else None
