"""The antennas: how much they send to, and receive from, each direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graph.base.records import dataclass


@dataclass(frozen=True, slots=True)
class Pattern:
    """A measured gain. azimuth (a,), elevation (e,): rising, (a, e) gain [dB] on their grid; angles in degrees.

    Between the angles the decibels are interpolated; beyond them the nearest counts.
    """

    azimuth: np.ndarray
    elevation: np.ndarray
    gain: np.ndarray

    @classmethod
    def of_table(cls, azimuth: Sequence[float], elevation: Sequence[float], gain: Sequence[float]) -> Pattern | None:
        """The pattern of three lists; None if they are empty.

        Gains are those of the whole grid, all elevations of the first azimuth first; or all lists have the same length,
        a gain for each pair, and the pairs make up a grid. Raises ValueError for anything else.
        """
        if not len(azimuth) and not len(elevation) and not len(gain):
            return None
        a, across = np.unique(np.asarray(azimuth, np.float64), return_inverse=True)
        e, up = np.unique(np.asarray(elevation, np.float64), return_inverse=True)
        decibels = np.asarray(gain, np.float64)
        if len(a) and len(e) and len(decibels) == len(azimuth) * len(elevation) == len(a) * len(e):
            across, up = np.repeat(across, len(elevation)), np.tile(up, len(azimuth))
        elif not len(decibels) == len(azimuth) == len(elevation) == len(a) * len(e):
            raise ValueError(
                f"{len(decibels)} gains at {len(azimuth)} azimuths and {len(elevation)} elevations: give one for each "
                "pair of different angles, or three lists of one length that make up a grid"
            )
        table = np.full((len(a), len(e)), np.nan)
        table[across, up] = decibels
        if np.isnan(table).any():
            raise ValueError("a pair of angles comes twice and another is missing")
        return cls(a, e, table)

    def at(self, directions: np.ndarray) -> np.ndarray:
        """Power gain (k,) of unit directions (3, k) in the sensor frame."""
        x, y, z = directions
        across = np.interp(np.rad2deg(np.arctan2(y, x)), self.azimuth, np.arange(len(self.azimuth)))
        up = np.interp(np.rad2deg(np.arcsin(np.clip(z, -1.0, 1.0))), self.elevation, np.arange(len(self.elevation)))
        i, j = across.astype(np.intp), up.astype(np.intp)
        s, t = across - i, up - j
        k, m = np.minimum(i + 1, len(self.azimuth) - 1), np.minimum(j + 1, len(self.elevation) - 1)
        low = self.gain[i, j] * (1 - t) + self.gain[i, m] * t
        high = self.gain[k, j] * (1 - t) + self.gain[k, m] * t
        return np.asarray(10.0 ** ((low * (1 - s) + high * s) / 10.0))


RIM = 0.01
"""Cosine of the angle off boresight, 89.4 deg, beyond which the gain of COSINEFALLOFF is too near 0."""


@dataclass(frozen=True, slots=True)
class Antenna:
    """One-way power gains by direction. wavelength [m]; power: that it sends [W].

    falls: gain falls with the cosine of the angle off boresight (COSINEFALLOFF), so two ways with its square;
    otherwise it is 1 all around. The law of the original is not public. tx, rx: measured patterns, which count instead.
    """

    wavelength: float
    power: float = 1.0
    falls: bool = True
    tx: Pattern | None = None
    rx: Pattern | None = None

    def sends(self, directions: np.ndarray) -> np.ndarray:
        """Gain (k,) of the sending antenna to unit directions (3, k) in the sensor frame."""
        return self._gain(self.tx, directions)

    def hears(self, directions: np.ndarray) -> np.ndarray:
        """Gain (k,) of the receiving antenna from unit directions (3, k) in the sensor frame."""
        return self._gain(self.rx, directions)

    def gains(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gains (k,) of both."""
        sends = self.sends(directions)
        return sends, sends if self.rx is self.tx else self.hears(directions)

    def _gain(self, pattern: Pattern | None, directions: np.ndarray, least: float = 0.0) -> np.ndarray:
        if pattern is not None:
            return pattern.at(directions)
        return np.maximum(directions[0], least) if self.falls else np.ones_like(directions[0])

    @property
    def receives(self) -> float:
        """Power received of 1 m^2 at 1 m at gain 1: P lambda^2 / (4 pi)^3 [W m^2], the radar equation."""
        return self.power * self.wavelength**2 / (4.0 * math.pi) ** 3

    def cross_section(self, received: np.ndarray, range_m: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Radar cross section [m^2] that gives the power (k,) [W] from a range [m] and directions (3, k).

        From beyond `RIM` the gain there counts: a false alarm at 90 deg, where it is 0, would be a target of any size.
        """
        gain = np.maximum(self._gain(self.tx, directions, RIM) * self._gain(self.rx, directions, RIM), 1e-12)
        return np.asarray(received * range_m**4 / (self.receives * gain))
