"""What a face sends back along which its surface is straight, as along a cylinder: a line in the near and far field.

A line of length L, whose ways there and back are 2 R, sends |1/L integral exp(-j k (z^2 / R - 2 z s)) dz|^2 of what it
would with all of it in phase (Born and Wolf, Principles of Optics, 8.7); s: sine of the way's angle off its normal, at
its middle. With q = L^2 / (R wavelength) and u = 2 L s / wavelength that is sinc^2 u far away, where q is 0.
"""

from __future__ import annotations

import math

import numpy as np

from sensors.compiled import compiled

from .grouping import Groups

MOST_ZONES = 25.0
"""q up to which the ends of a line count; of a longer one they change less than 1 dB, and each place is for itself."""

PIECES = 48
"""Over one of so many pieces of a line the phase is linear to 0.02 rad."""

FAINT = 1e-3
"""Least weight of a place on a line, of its best one."""


def line(zones: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """What lines send, (n,), of what they would in phase; zones: (n,) q, turns: (n,) u."""
    found = np.empty(len(zones))
    # A single line's arrays would be contiguous, several lines' not: one form of the loop serves both.
    _line(np.ascontiguousarray(zones), np.ascontiguousarray(turns), found)
    return found


@compiled
def _line(zones: np.ndarray, turns: np.ndarray, found: np.ndarray) -> None:
    for row in range(len(zones)):
        real = imaginary = 0.0
        for piece in range(PIECES):
            middle = (piece + 0.5) / PIECES - 0.5
            half = math.pi / PIECES * (turns[row] - 2.0 * zones[row] * middle) + 1e-20
            phase = 2.0 * math.pi * (turns[row] - zones[row] * middle) * middle
            share = math.sin(half) / half
            real, imaginary = real + share * math.cos(phase), imaginary + share * math.sin(phase)
        found[row] = (real * real + imaginary * imaginary) / PIECES**2


def along_lines(
    face: np.ndarray, zones: np.ndarray, turns: np.ndarray, place: np.ndarray, coarse: np.ndarray, area: np.ndarray
) -> np.ndarray:
    """What tubes (k,) get of lines, of what these would send in phase: over their area as much as `line`, and more of
    it from where the line reflects as a mirror.

    face: (k,) int64, equal for tubes of one line. zones: (k,) q. turns: (k,) u as the tubes meet it, at places (k,)
    from the middle, over the length. coarse: (k,) squared turns across a tube; area: (k,) that tubes cover.
    """
    spread = (1.0 + zones) / (2.0 * np.pi) + coarse / 4.0
    share = np.exp(-0.5 * turns**2 / spread)
    found = share / np.sqrt(2.0 * np.pi * spread)
    short = np.flatnonzero(zones < MOST_ZONES)
    if len(short):
        groups, share = Groups(face[short]), share[short] + FAINT
        at_middle = turns[short] + 2.0 * zones[short] * place[short]
        _, (q, u, mean, _) = groups.means([zones[short], at_middle, share, share], area[short])
        found[short] = share * (line(q, u) / mean)[groups.which]
    return np.asarray(found)
