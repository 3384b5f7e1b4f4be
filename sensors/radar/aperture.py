"""A uniform array of antennas along one axis, real or virtual: the beams that a Fourier transform over it makes.

Elements lie `spacing` wavelengths apart, so that the phase from one to the next, 2 pi spacing u, tells the sine u of an
angle up to 1 / spacing: beams are equal in the sine, and angles beyond |u| = 1 / (2 spacing) come in again on the other
side. Without a window a beam is 0.886 / (elements x spacing) wide in u at half its power (Balanis, Antenna Theory,
chapter 6; Harris, Proc. IEEE 66 (1978) 51-83).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graph.base.records import dataclass

from .cells import Cells

WINDOWS = {"": 0.0, "NONE": 0.0, "RECTANGULAR": 0.0, "HANN": 0.5, "HAMMING": 0.46 / (2 * 0.54)}
"""Window -> share of the neighbouring beams that it adds to each: a raised cosine is that in the transform."""

HALF = 0.5
"""Spacing [wavelengths] of arrays that give none."""

SPACINGS = 0.1, 100.0
"""Spacings [wavelengths] that are believed: a spacing in metres is below these."""


@dataclass(frozen=True, slots=True)
class Aperture:
    """elements: how many; spacing: [wavelengths]; padding: zeros after them; window: one of `WINDOWS`."""

    elements: int
    spacing: float = HALF
    padding: int = 0
    window: str = ""

    @property
    def limit(self) -> float:
        """Sine of the angle up to which it is unambiguous."""
        return 0.5 / self.spacing

    @property
    def cells(self) -> Cells:
        """One cell around each beam, of which one looks ahead; the first is also that of the other end."""
        count = self.elements + self.padding
        width = 1.0 / self.spacing / count
        low = -(count // 2 + 0.5) * width
        return Cells(low, low + count * width, count)

    @property
    def finer(self) -> float:
        """How many cells the padding makes of one."""
        return 1.0 + self.padding / self.elements

    @property
    def reach(self) -> int:
        """Elements' beams from the middle of the main lobe to its end."""
        return 2 if WINDOWS[self.window] else 1

    def response(self, away: np.ndarray) -> np.ndarray:
        """Power response (k,), 1 ahead, to what is so many beams of the elements away, (k,): multiples of
        1 / (elements x spacing) in u.
        """
        share = WINDOWS[self.window]
        amplitude = self._transform(away)
        if share:
            amplitude = amplitude + share * (self._transform(away - 1.0) + self._transform(away + 1.0))
        return np.asarray(amplitude**2)

    def _transform(self, away: np.ndarray) -> np.ndarray:
        """sin(pi x) / (n sin(pi x / n)), the sum over elements around their middle."""
        below = self.elements * np.sin(np.pi * away / self.elements)
        whole = np.abs(below) < 1e-9
        turns = np.rint(away / self.elements)
        ends = np.cos(np.pi * turns * (self.elements - 1))  # where the sum comes in again
        return np.asarray(np.where(whole, ends, np.sin(np.pi * away) / np.where(whole, 1.0, below)))

    def problems(self, axis: str) -> Iterator[str]:
        """What no array can have, one line each; axis: azimuth or elevation."""
        if not SPACINGS[0] <= self.spacing <= SPACINGS[1]:
            yield (
                f"{axis}ElementSpacing = {self.spacing:g}; it is in wavelengths, such as 0.5: give "
                f"{SPACINGS[0]:g} to {SPACINGS[1]:g}"
            )
        if self.window not in WINDOWS:
            names = ", ".join(name for name in WINDOWS if name)
            yield f"apertureWindow{axis.capitalize()} = {self.window!r} is not one of {names}"
