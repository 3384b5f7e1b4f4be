"""The antenna: how much it sends to, and receives from, each direction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Antenna:
    """One-way power gain by direction. wavelength [m]; power: that it sends [W].

    falls: gain falls with the cosine of the angle off boresight (COSINEFALLOFF), so two ways with its square;
    otherwise it is 1 all around. The law of the original is not public.
    """

    wavelength: float
    power: float = 1.0
    falls: bool = True

    def gain(self, forward: np.ndarray) -> np.ndarray:
        """Gain (k,) of unit directions by their components along boresight (k,)."""
        return np.maximum(forward, 0.0) if self.falls else np.ones_like(forward)

    @property
    def receives(self) -> float:
        """Power received of 1 m^2 at 1 m at gain 1: P lambda^2 / (4 pi)^3 [W m^2], the radar equation."""
        return self.power * self.wavelength**2 / (4.0 * math.pi) ** 3

    def cross_section(self, received: np.ndarray, range_m: np.ndarray, forward: np.ndarray) -> np.ndarray:
        """Radar cross section [m^2] that gives the power (k,) [W] at a range [m], by the radar equation."""
        gain = np.maximum(self.gain(forward), 1e-6)
        return np.asarray(received * range_m**4 / (self.receives * gain**2))
