"""The range-velocity-azimuth-elevation cube: arrivals put into cells. It is sparse: a dense one takes a gigabyte."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sensors.compiled import compiled

from .aperture import Aperture
from .bins import Bins, angle_cells, put_all
from .cells import Cells
from .config import ScanConfig
from .grouping import Groups, Sums
from .interference import added, gathered
from .scattering import Arrivals

LOBE = 2
"""Cells to each side over which a return spreads: the main lobe."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The cells of one cycle of a scan: range [m], velocity [m/s] up to the unambiguous one, sines of the angles.

    wraps_angles, wraps_range: whether what lies beyond them comes in again on the other side. flat: whether no
    elevation is measured. coupling, finer: those of chirps (`Chirps`). arrays: along azimuth and elevation.
    """

    range_m: Cells
    velocity: Cells
    azimuth: Cells
    height: Cells
    wraps_angles: bool = False
    flat: bool = False
    wraps_range: bool = False
    coupling: tuple[float, float] = (0.0, 0.0)
    finer: float = 1.0
    arrays: tuple[Aperture | None, Aperture | None] = (None, None)

    @classmethod
    def of(cls, scan: ScanConfig, cycle: int) -> Grid:
        """The grid of a cycle, counted from 0: the unambiguous velocities take turns."""
        limit = scan.cycles[cycle % len(scan.cycles)]
        cells = scan.ranges(), scan.velocities(limit), scan.azimuths(), scan.heights()
        modes = scan.en_ang_aliasing, scan.elev_mode == "NO_EL"
        if not scan.waveform:
            return cls(*cells, *modes)
        chirps = scan.chirps(limit)
        arrays = scan.aperture("azimuth"), None if modes[1] else scan.aperture("elevation")
        return cls(*cells, *modes, scan.enable_range_aliasing, chirps.coupling, chirps.finer, arrays)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Counts of range, velocity, azimuth and elevation cells."""
        return self.range_m.count, self.velocity.count, self.azimuth.count, self.height.count

    @property
    def axes(self) -> tuple[Cells, Cells, Cells, Cells]:
        """Range, velocity, azimuth and elevation."""
        return self.range_m, self.velocity, self.azimuth, self.height

    @property
    def padding(self) -> tuple[float, ...]:
        """How many cells padding makes of one, along each axis."""
        return self.finer, 1.0, *(each.finer if each else 1.0 for each in self.arrays)

    @property
    def resolved(self) -> tuple[float, ...]:
        """What it resolves along each axis, in the unit of that: a cell, or the cells that padding makes of one."""
        return tuple(cells.width * more for cells, more in zip(self.axes, self.padding, strict=True))

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Lowest and highest unambiguous sines of azimuth and elevation."""
        azimuth, elevation = (
            (-array.limit, array.limit) if array else (cells.low, cells.high)
            for array, cells in zip(self.arrays, self.axes[2:], strict=True)
        )
        return azimuth, elevation

    @property
    def bins(self) -> Bins:
        """Its cells, for loops over arrivals."""
        ranges, velocities, azimuths, heights = (axis.along for axis in self.axes)
        meet = bool(self.arrays[0]), bool(self.arrays[1])
        ends, modes = self.ends, (self.wraps_angles, self.wraps_range)
        return Bins(ranges, velocities, azimuths, heights, *ends, meet, *modes, self.coupling)

    def angles(self, azimuth: np.ndarray, height: np.ndarray) -> np.ndarray:
        """Numbers (k,) int32 of the angle cells of sines (k,), -1 outside the grid."""
        cells = np.empty(len(azimuth), np.int32)
        angle_cells(self.bins, azimuth, height, cells)
        return cells

    def number(self, index: Sequence[np.ndarray]) -> np.ndarray:
        """Numbers (k,) of cells by their places on the axes; those of one velocity lie together."""
        ranges, _, azimuths, heights = self.shape
        return np.asarray(((index[1] * ranges + index[0]) * azimuths + index[2]) * heights + index[3])

    def index(self, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Places on the axes of cells by their numbers."""
        ranges, velocities, azimuths, heights = self.shape
        at = np.unravel_index(cell, (velocities, ranges, azimuths, heights))
        return at[1], at[0], at[2], at[3]


@dataclass(frozen=True, slots=True)
class Cube:
    """Cells that hold power; k of them, in rising order.

    cell: (k,) int64, their numbers in the grid. power: (k,) [W]. values: (4, k), where in its cell each has its power:
    range [m], velocity [m/s], sines of azimuth and elevation. bounces: (k,) faces on the way of its strongest part.
    """

    grid: Grid
    cell: np.ndarray
    power: np.ndarray
    values: np.ndarray
    bounces: np.ndarray

    @property
    def index(self) -> tuple[np.ndarray, ...]:
        """Place of each cell on the axes, (k,) each."""
        return self.grid.index(self.cell)


class Part(NamedTuple):
    """Cells (m,) int64 that arrivals of one kind fill: their powers (m,), values (4, m), bounces."""

    cell: np.ndarray
    power: np.ndarray
    values: np.ndarray
    bounces: int


def summed(grid: Grid, scattered: Sequence[Sums], grouped: Sequence[Arrivals], bounces: int) -> Part:
    """What comes back after as many faces: what is in cells already, and arrivals that add up in groups before."""
    found = [(added if each.field is not None else gathered)(each, grid.resolved) for each in grouped]
    sums = Sums.merged(scattered, sum(len(power) for power, _ in found))
    for power, values in found:
        put_all(grid.bins, sums, values, power)
    return Part(*sums.found, bounces)


def merged(grid: Grid, parts: Iterable[Part]) -> Cube:
    """The cube of all parts."""
    parts = [Part(np.zeros(0, np.int64), np.zeros(0), np.zeros((4, 0)), 0), *parts]
    return _cube_of(
        grid,
        np.concatenate([part.cell for part in parts]),
        np.concatenate([part.power for part in parts]),
        np.concatenate([part.values for part in parts], axis=1),
        np.repeat(np.array([part.bounces for part in parts], np.uint8), [len(part.cell) for part in parts]),
    )


def as_chirps_give(cube: Cube) -> Cube:
    """The cube that the Fourier transforms of sampled chirps give: returns spread over cells of range and velocity.

    Both are taken of samples under a Hann window, whose response at x cells from a return is sinc(x) / (1 - x^2) in
    amplitude (Harris, Proc. IEEE 66 (1978) 51-83): 1 at the return, 1.4 dB less at half a cell, side lobes of -31 dB,
    which are left out beyond `LOBE` cells; padding makes several cells of one in range. Different returns add up as
    powers. Velocities wrap.
    """
    grid, index = cube.grid, cube.index
    offsets = [values - cells.centre(at) for values, cells, at in zip(cube.values[:2], grid.axes, index, strict=False)]
    parts, wide = [], math.ceil(LOBE * grid.finer)
    for step in range(-wide, wide + 1):
        ranges = index[0] + step
        if grid.wraps_range:
            ranges = ranges % grid.range_m.count
        inside = np.flatnonzero((ranges >= 0) & (ranges < grid.range_m.count))
        along = _hann((offsets[0][inside] / grid.range_m.width - step) / grid.finer)
        for turn in range(-LOBE, LOBE + 1):
            velocities = (index[1][inside] + turn) % grid.velocity.count
            across = _hann(offsets[1][inside] / grid.velocity.width - turn)
            cell = grid.number((ranges[inside], velocities, index[2][inside], index[3][inside]))
            parts.append((cell, cube.power[inside] * along * across, inside))
    cell = np.concatenate([part[0] for part in parts])
    power, row = (np.concatenate([part[place] for part in parts]) for place in (1, 2))
    return _cube_of(grid, cell, power, cube.values[:, row], cube.bounces[row])


def as_arrays_give(cube: Cube) -> Cube:
    """The cube that the Fourier transforms over the elements of arrays give: returns spread over the beams of their
    main lobe, in azimuth and elevation. Side lobes are left out; different returns add up as powers.
    """
    grid = cube.grid
    for axis, array in zip((2, 3), grid.arrays, strict=True):
        cells = grid.axes[axis]
        if array is None or cells.count == 1 or not len(cube.cell):
            continue
        index = list(cube.index)
        middle = index[axis]
        offset = (cube.values[axis] - cells.centre(middle)) / cells.width
        wide = min(math.ceil(array.reach * array.finer), cells.count // 2)
        numbers, powers = [], []
        for step in range(-wide, min(wide, cells.count - 1 - wide) + 1):
            index[axis] = (middle + step) % cells.count
            away = (offset - step) / array.finer
            away -= array.elements * np.rint(away / array.elements)
            numbers.append(grid.number(index))
            powers.append(cube.power * np.where(np.abs(away) < array.reach, array.response(away), 0.0))
        row = np.tile(np.arange(len(cube.cell)), len(numbers))
        cell, power = np.concatenate(numbers), np.concatenate(powers)
        kept = np.flatnonzero(power > 0)
        cube = _cube_of(grid, cell[kept], power[kept], cube.values[:, row[kept]], cube.bounces[row[kept]])
    return cube


def _hann(away: np.ndarray) -> np.ndarray:
    """Power response of a Hann window, `away` cells from a return."""
    rest = 1.0 - away**2
    near = np.abs(rest) < 1e-6
    return np.asarray(np.where(near, 0.25, (np.sinc(away) / np.where(near, 1.0, rest)) ** 2))


def _cube_of(grid: Grid, cell: np.ndarray, power: np.ndarray, values: np.ndarray, bounces: np.ndarray) -> Cube:
    """The cube of powers (k,) in cells (k,), which may repeat, with their values (4, k) and bounces (k,)."""
    groups = Groups(cell)
    total, means = groups.means(values, power)
    strongest = np.zeros(len(groups), np.int64)
    _strongest(groups.which, power, strongest)
    order = np.argsort(groups.keys)
    return Cube(grid, groups.keys[order], total[order], means[:, order], bounces[strongest[order]])


@compiled
def _strongest(which: np.ndarray, power: np.ndarray, rows: np.ndarray) -> None:
    """Writes the row of the most power in each group (n,), of equal powers the last; rows: 0 before."""
    for row in range(len(which)):
        best = rows[which[row]]
        if which[best] != which[row] or power[row] >= power[best]:
            rows[which[row]] = row
