"""Sampled chirps: the cells that linear frequency sweeps measure in, and where they see what moves.

A chirp sweeps a bandwidth B from the carrier f up in its duration T and is sampled N times, as complex numbers; chirps
follow each other after the repetition time P, each with its carrier a step d higher (stepped frequency). From the phase
of what comes back, 4 pi f R / c (Skolnik, Radar Handbook, 3rd edition, chapter 4; Stove, IEE Proc. F 139 (1992)
343-350): range cells of c / 2B up to N c / 2B, velocities up to c / 4fP; a receding target of velocity v seems
v f T / B farther, and one at the range R seems R d / fP faster.
"""

from __future__ import annotations

from collections.abc import Iterator

from graph.base.records import dataclass

from .cells import Cells

LIGHT = 299_792_458.0
"""Speed of light [m/s]."""


@dataclass(frozen=True, slots=True)
class Chirps:
    """carrier, bandwidth, step [Hz]; duration, repetition [s]; samples: of a chirp, padding: zeros after them.

    A duration or step of 0 is one whose effect is not looked at; 0 samples are as many as the farthest range takes.
    """

    carrier: float
    bandwidth: float
    repetition: float
    duration: float = 0.0
    step: float = 0.0
    samples: int = 0
    padding: int = 0

    @property
    def unambiguous(self) -> float:
        """Largest velocity [m/s] that the phase from chirp to chirp tells."""
        return LIGHT / (4.0 * self.carrier * self.repetition)

    @property
    def finer(self) -> float:
        """How many cells the padding makes of one."""
        return 1.0 + self.padding / self.samples if self.samples else 1.0

    def ranges(self, farthest: float) -> Cells:
        """Range cells [m]: all that the samples tell apart, or as far as a range [m]."""
        resolution = LIGHT / (2.0 * self.bandwidth)
        if not self.samples:
            return Cells.of_resolution(0.0, farthest, resolution)
        return Cells(0.0, self.samples * resolution, self.samples + self.padding)

    @property
    def coupling(self) -> tuple[float, float]:
        """What a range grows by for each m/s [s], and a velocity for each metre [1/s]."""
        return self.carrier * self.duration / self.bandwidth, self.step / (self.carrier * self.repetition)

    def problems(self) -> Iterator[str]:
        """What no chirp can have, one line each."""
        if self.duration > self.repetition:
            yield f"chirpDuration = {self.duration:g} s is longer than from chirp to chirp, {self.repetition:.3g} s"
        if self.padding and not self.samples:
            yield "fastTimePaddingSamples needs fastTimeSamples"
        if not 3e8 <= self.carrier <= 3e13:
            yield f"carrierFrequency = {self.carrier:g}; give 3e8 to 3e13 Hz"
        elif not 1.0 <= self.bandwidth <= self.carrier:
            yield f"chirpBandwidth = {self.bandwidth:g}; give 1 Hz up to the carrier's {self.carrier:g}"
        elif abs(self.step) > self.carrier:
            yield f"frequencyStepBetweenChirps = {self.step:g} is more than the carrier, {self.carrier:g} Hz"
