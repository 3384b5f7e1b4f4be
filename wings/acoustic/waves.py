"""Sound in air: how fast, how far, in which directions, and the shape of a pulse."""

from __future__ import annotations

import math

import numpy as np

SPEED_OF_SOUND = 343.0
"""In air of 20 degC [m/s]."""


def absorption(frequency: float, celsius: float = 20.0, humidity: float = 0.5) -> float:
    """Attenuation of sound in air at 101.325 kPa [1/m]: an amplitude falls by exp(-absorption * distance).

    frequency: Hz; humidity: relative, 0 to 1. ISO 9613-1:1993, equations (3) to (5) and the saturation pressure of its
    annex B; to 10 % in its range, of which 51 kHz at 20 degC is a part.
    """
    kelvin = celsius + 273.15
    warm = kelvin / 293.15
    saturation = 10 ** (-6.8346 * (273.16 / kelvin) ** 1.261 + 4.6151)
    water = 100 * humidity * saturation  # molar concentration of water vapour [%]
    oxygen = 24 + 4.04e4 * water * (0.02 + water) / (0.391 + water)
    nitrogen = warm**-0.5 * (9 + 280 * water * math.exp(-4.170 * (warm ** (-1 / 3) - 1)))
    relaxed = 0.01275 * math.exp(-2239.1 / kelvin) / (oxygen + frequency**2 / oxygen)
    relaxed += 0.1068 * math.exp(-3352.0 / kelvin) / (nitrogen + frequency**2 / nitrogen)
    return float(frequency**2 * (1.84e-11 * warm**0.5 + warm**-2.5 * relaxed))


class Membrane:
    """The directivity of a round membrane in a wall: 2 J1(k a sin t) / (k a sin t), t off its axis (piston).

    diameter: m; 0 sends alike in all directions. wave_number: 2 pi / wavelength [rad/m]. Behind the wall it is that of
    the mirrored direction.
    """

    def __init__(self, diameter: float, wave_number: float) -> None:
        self._size = wave_number * diameter / 2
        if self._size:
            # J1(x) = 1/pi * integral of cos(t - x sin t) over 0..pi (Bessel), by the trapezoidal rule, which converges
            # faster than any power; the table is fine enough for 1e-6.
            self._sines = np.linspace(0.0, 1.0, 2001)
            angles = (np.arange(256) + 0.5) * (math.pi / 256)
            x = self._size * self._sines[:, None]
            bessel = np.cos(angles - x * np.sin(angles)).mean(axis=1)
            with np.errstate(invalid="ignore", divide="ignore"):
                self._gains = np.where(x[:, 0] > 0, 2 * bessel / x[:, 0], 1.0)

    def gain(self, cosines: np.ndarray) -> np.ndarray:
        """Amplitude, 1 on the axis, for cosines of the angle off the axis."""
        if not self._size:
            return np.ones_like(cosines)
        return np.asarray(np.interp(np.sqrt(np.maximum(0.0, 1 - cosines**2)), self._sines, self._gains))


FINE = 8
"""Parts of a sample in which the waves that arrive are added up."""


def envelope(delays: np.ndarray, waves: np.ndarray, count: int, sample: float, pulse: float) -> np.ndarray:
    """What a receiver records, (count,) float64: the envelope of all waves together.

    delays: (n,) [s] when each wave begins to arrive; waves: (n,) complex128, amplitude and phase. A pulse lasts `pulse`
    [s] and swells and fades as sin^2; sample k is taken at k * `sample` [s].
    """
    step = sample / FINE
    bins = np.floor(delays / step)
    kept = bins < count * FINE
    bins, waves = bins[kept].astype(np.int64), waves[kept]
    size = count * FINE
    arrived = np.bincount(bins, waves.real, size) + 1j * np.bincount(bins, waves.imag, size)
    longest = math.ceil(min(pulse / step, size))  # what comes after the record is not in it
    ages = (np.arange(longest + 1) - 0.5) * step  # from the middle of a bin to the end of a later one
    shape = np.where((ages > 0) & (ages < pulse), np.sin(np.pi * ages / pulse) ** 2, 0.0)
    return np.asarray(np.abs(np.convolve(arrived, shape)[: count * FINE : FINE]))
