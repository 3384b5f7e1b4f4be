"""The range-velocity-azimuth-elevation cube: arrivals put into cells. It is sparse: a dense one takes a gigabyte."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .cells import Cells, folded
from .config import ScanConfig
from .scattering import Arrivals

DENSE = 4_000_000
"""Cells up to which sums are made in arrays of all of them, which spares sorting."""

ZONES = 8.0
"""Fresnel zones across which fields of one face add up at least."""

FLAT_TOP = 0.35
"""Share of a cell's size from its middle within which fields belong to it alone."""

LOBE = 2
"""Cells to each side over which a return spreads: the main lobe."""

_MIX = np.uint64(0xC2B2AE3D27D4EB4F)


@dataclass(frozen=True, slots=True)
class Grid:
    """The cells of one cycle of a scan: range [m], velocity [m/s] up to the unambiguous one, sines of the angles."""

    range_m: Cells
    velocity: Cells
    azimuth: Cells
    height: Cells
    wraps_angles: bool = False
    flat: bool = False
    """Whether no elevation is measured."""

    @classmethod
    def of(cls, scan: ScanConfig, cycle: int) -> Grid:
        """The grid of a cycle, counted from 0: the unambiguous velocities take turns."""
        sequence = scan.max_vel_mps_sequence
        velocities = scan.velocities(sequence[cycle % len(sequence)])
        return cls(
            *(scan.ranges(), velocities, scan.azimuths(), scan.heights()),
            *(scan.en_ang_aliasing, scan.elev_mode == "NO_EL"),
        )

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Counts of range, velocity, azimuth and elevation cells."""
        return self.range_m.count, self.velocity.count, self.azimuth.count, self.height.count

    @property
    def axes(self) -> tuple[Cells, Cells, Cells, Cells]:
        """Range, velocity, azimuth and elevation."""
        return self.range_m, self.velocity, self.azimuth, self.height

    def place(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where values (4, k) lie: rows of those in the grid (m,), their cells (m,) int64, they themselves, folded."""
        values = values.copy()
        if values[1].any():
            values[1] = folded(values[1], self.velocity.high)
        if self.wraps_angles:
            for row, cells in ((2, self.azimuth), (3, self.height)):
                values[row] = np.mod(values[row] - cells.low, cells.high - cells.low) + cells.low
        index = [cells.index(row) for cells, row in zip(self.axes, values, strict=True)]
        index[1] = np.clip(index[1], 0, self.velocity.count - 1)
        inside = np.ones(values.shape[1], bool)
        for at, cells in zip(index, self.axes, strict=True):
            inside &= (at >= 0) & (at < cells.count)
        rows = np.flatnonzero(inside)
        if len(rows) < len(inside):
            index, values = [at[rows] for at in index], values[:, rows]
        return rows, self.number(index), values

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


def fill(grid: Grid, found: Iterable[Arrivals]) -> Cube:
    """Puts arrivals into cells. Fields of one group add up within a cell; then powers do."""
    parts = [_summed(grid, one) for one in found]
    parts = [part for part in parts if len(part[0])]
    if not parts:
        return Cube(grid, np.zeros(0, np.int64), np.zeros(0), np.zeros((4, 0)), np.zeros(0, np.uint8))
    cell = np.concatenate([part[0] for part in parts])
    power = np.concatenate([part[1] for part in parts])
    values = np.concatenate([part[2] for part in parts], axis=1)
    bounces = np.concatenate([np.full(len(part[0]), part[3], np.uint8) for part in parts])
    cells, which = np.unique(cell, return_inverse=True)
    total, centred = _weighed(which, len(cells), power, values)
    strongest = np.zeros(len(cells), np.uint8)
    order = np.argsort(power, kind="stable")
    strongest[which[order]] = bounces[order]  # the last written is the strongest
    return Cube(grid, cells, total, centred, strongest)


def as_chirps_give(cube: Cube) -> Cube:
    """The cube that the Fourier transforms of sampled chirps give: returns spread over cells of range and velocity.

    Both are taken of samples under a Hann window, whose response at x cells from a return is sinc(x) / (1 - x^2) in
    amplitude (Harris, Proc. IEEE 66 (1978) 51-83): 1 at the return, 1.4 dB less at half a cell, side lobes of -31 dB,
    which are left out beyond `LOBE` cells. Different returns add up as powers. Velocities wrap.
    """
    grid = cube.grid
    index = cube.index
    offsets = [values - cells.centre(at) for values, cells, at in zip(cube.values[:2], grid.axes, index, strict=False)]
    parts = []
    for step in range(-LOBE, LOBE + 1):
        ranges = index[0] + step
        inside = np.flatnonzero((ranges >= 0) & (ranges < grid.range_m.count))
        along = _hann(offsets[0][inside] / grid.range_m.width - step)
        for turn in range(-LOBE, LOBE + 1):
            velocities = (index[1][inside] + turn) % grid.velocity.count
            across = _hann(offsets[1][inside] / grid.velocity.width - turn)
            cell = grid.number((ranges[inside], velocities, index[2][inside], index[3][inside]))
            parts.append((cell, cube.power[inside] * along * across, inside))
    cell = np.concatenate([part[0] for part in parts])
    power, row = (np.concatenate([part[place] for part in parts]) for place in (1, 2))
    cells, which = np.unique(cell, return_inverse=True)
    total, values = _weighed(which, len(cells), power, cube.values[:, row])
    bounces = np.zeros(len(cells), np.uint8)
    order = np.argsort(power, kind="stable")
    bounces[which[order]] = cube.bounces[row[order]]
    return Cube(grid, cells, total, values, bounces)


def _hann(away: np.ndarray) -> np.ndarray:
    """Power response of a Hann window, `away` cells from a return."""
    rest = 1.0 - away**2
    near = np.abs(rest) < 1e-6
    return np.asarray(np.where(near, 0.25, (np.sinc(away) / np.where(near, 1.0, rest)) ** 2))


def _summed(grid: Grid, found: Arrivals) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Cells (m,), powers (m,) and values (4, m) of arrivals of one kind; a cell may come several times."""
    values, power = np.stack((found.range_m, found.velocity, found.azimuth, found.height)), found.power
    if found.field is not None and found.group is not None:
        power, values = _added(grid, found, values)
        rows, cell, values = grid.place(values)
        return cell, power[rows], values, found.bounces
    rows, cell, values = grid.place(values)
    cells, which = _numbered(grid, cell)
    return cells, *_weighed(which, len(cells), power[rows], values), found.bounces


def _added(grid: Grid, found: Arrivals, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Powers (m,) and values (4, m) of fields that add up: in each group all that lie within a cell's size.

    Sizes are counted from the middle of the group, not from the edges of cells: a target that the radar does not
    resolve is one, wherever it is. In angle they are at least `ZONES` Fresnel zones, which a mirror reflection needs to
    form, and neighbours share what lies between them, so that no edge is made where none is.
    """
    assert found.field is not None
    assert found.group is not None
    assert found.zone is not None
    field, power = found.field, found.power
    _, which = np.unique(found.group, return_inverse=True)
    _, middle = _weighed(which, int(which.max(initial=-1)) + 1, power, values)
    away = values - middle[:, which]
    key = which.astype(np.uint64)
    for cells, row in zip(grid.axes[:2], away[:2], strict=True):
        key = _joined(key, np.rint(row / cells.width))
    row = np.arange(len(field))
    for cells, offset in zip(grid.axes[2:], away[2:], strict=True):
        size = np.maximum(cells.width, ZONES * found.zone[row])
        key, row, field = _shared(key, row, field, offset[row] / size)
    _, which = np.unique(key, return_inverse=True)
    count = int(which.max(initial=-1)) + 1
    values = values[:, row]
    _, means = _weighed(which, count, np.abs(field) ** 2, values)
    total = np.bincount(which, field.real, count) + 1j * np.bincount(which, field.imag, count)
    squared = np.abs(total) ** 2
    # Where a face reflects as a mirror, the fields that do not cancel tell the place; else the strongest do.
    share = (field * np.conj(total[which])).real / np.maximum(squared, 1e-300)[which]
    for cells, one, mean in zip(grid.axes, values, means, strict=True):
        place = np.bincount(which, share * (one - mean[which]), count)
        mean += np.where(np.abs(place) < cells.width / 2, place, 0.0)
    return squared, means


def _shared(
    key: np.ndarray, row: np.ndarray, field: np.ndarray, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fields by whole places; what lies far from one goes to both neighbours, with weights that add up to 1."""
    whole = np.rint(place)
    off = place - whole
    beside = np.clip((np.abs(off) - FLAT_TOP) / (1.0 - 2.0 * FLAT_TOP), 0.0, 0.5)
    weight = np.sin(np.pi / 2 * beside) ** 2
    some = np.flatnonzero(weight > 0)
    return (
        np.concatenate((_joined(key, whole), _joined(key[some], whole[some] + np.sign(off[some])))),
        np.concatenate((row, row[some])),
        np.concatenate((field * (1.0 - weight), field[some] * weight[some])),
    )


def _joined(key: np.ndarray, number: np.ndarray) -> np.ndarray:
    key = (key ^ number.astype(np.int64).astype(np.uint64)) * _MIX
    return np.asarray(key ^ (key >> np.uint64(29)))


def _numbered(grid: Grid, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cells that occur, rising, and which of them each of (k,) is."""
    total = int(np.prod(grid.shape))
    low = int(cell.min(initial=total))
    span = int(cell.max(initial=0)) - low + 1
    if not len(cell) or span > DENSE:
        return np.unique(cell, return_inverse=True)
    occurs = np.zeros(span, bool)
    occurs[cell - low] = True
    cells = np.flatnonzero(occurs)
    number = np.empty(span, np.int32)
    number[cells] = np.arange(len(cells), dtype=np.int32)
    return cells + low, number[cell - low]


def _weighed(which: np.ndarray, count: int, power: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sums of power (count,), and the means of the values (4, count) by power."""
    total = np.bincount(which, power, count)
    weight = np.maximum(total, 1e-300)
    return total, np.stack([np.bincount(which, power * row, count) / weight for row in values])
