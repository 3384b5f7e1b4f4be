"""From the cube to detections: noise, constant false alarm rate, values, radar cross sections."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from sensors.compiled import compiled, inlined

from .antenna import Antenna
from .aperture import Aperture
from .cfar import Axis, detect, noise_level_at, sparse_noise_level
from .config import ScanConfig
from .cube import Cube, Grid, as_arrays_give
from .noise import Noise

MOST_DETECTIONS = 2500
"""The strongest are kept, as many as the original's frames hold."""

SAMPLES = Aperture(1 << 16, window="HANN")
"""The samples of chirps: their transform is that of so many elements under a Hann window."""


@dataclass(frozen=True, slots=True)
class Detections:
    """What a frame holds, by rising range; n of them.

    range_m [m], velocity [m/s] (positive: receding), azimuth and elevation [rad], rcs [dBsm], all (n,) float64.
    bounces: (n,) uint8.
    """

    range_m: np.ndarray
    velocity: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray
    rcs: np.ndarray
    bounces: np.ndarray

    def at(self, rows: np.ndarray) -> Detections:
        """Some of them."""
        return Detections(*(getattr(self, one.name)[rows] for one in fields(Detections)))


def detections(
    cube: Cube, scan: ScanConfig, antenna: Antenna, noise: Noise, *, four: bool, peaks: bool = False
) -> Detections:
    """The detections of a cube; four: by CFAR over all four axes, else over range and velocity, one angle a cell.

    peaks: only where a cell has more power than those beside it in range and velocity.
    """
    cells = (_of_cube if four else _of_map)(cube, scan, noise, peaks)
    grid = cube.grid
    if scan.det_val_from_bin_idx:
        values = np.stack([axis.centre(at) for axis, at in zip(grid.axes, cells.index, strict=True)])
        for axis in _beams(grid):  # an array's first beam looks to both ends
            end = grid.ends[axis - 2][1]
            values[axis] = np.where(np.abs(values[axis]) >= end, np.copysign(end, cells.values[axis]), values[axis])
    else:
        values = cells.values
    range_m, velocity = values[:2]
    azimuth = np.arcsin(np.clip(values[2], -1, 1))
    elevation = np.zeros(len(range_m)) if grid.flat else np.arcsin(np.clip(values[3], -1, 1))
    true_range, _, sine, height = cells.values
    level = np.sqrt(np.maximum(1 - height**2, 0))
    directions = np.stack((np.sqrt(np.maximum(1 - sine**2, 0)) * level, sine * level, height))
    least, factor, scale = scan.rcs_tuning_coefficients
    power = cells.power / _share(cells) if scan.waveform and not scan.det_val_from_bin_idx else cells.power
    sigma = antenna.cross_section(power, true_range, directions) * factor
    rcs = 10 * np.log10(np.maximum(sigma, 1e-30)) + scale * noise.normal("rcs", len(sigma), 0.0, 1.0)
    found = Detections(
        np.maximum(range_m + noise.normal("range", len(rcs), scan.range_noise_mean, scan.range_noise_sdev), 0.0),
        velocity + noise.normal("velocity", len(rcs), scan.velocity_noise_mean, scan.velocity_noise_sdev),
        azimuth + noise.normal("azimuth", len(rcs), scan.azimuth_rad_noise_mean, scan.azimuth_rad_noise_sdev),
        elevation
        + (0.0 if grid.flat else 1.0)
        * noise.normal("elevation", len(rcs), scan.elevation_rad_noise_mean, scan.elevation_rad_noise_sdev),
        rcs,
        cells.bounces,
    )
    kept = np.flatnonzero(rcs >= least)
    if len(kept) > MOST_DETECTIONS:
        kept = np.sort(kept[np.argsort(-cells.power[kept], kind="stable")[:MOST_DETECTIONS]])
    found = found.at(kept)
    return found.at(np.lexsort((found.azimuth, found.velocity, found.range_m)))


def _beams(grid: Grid) -> list[int]:
    """The axes of angles over which arrays spread what returns."""
    return [axis for axis, array in ((2, grid.arrays[0]), (3, grid.arrays[1])) if array and grid.shape[axis] > 1]


def _share(cells: Cube) -> np.ndarray:
    """Share (k,) of the power of a return that a cell of sampled chirps and arrays holds: less beside its middle."""
    grid, share = cells.grid, np.ones(len(cells.power))
    windows = SAMPLES, SAMPLES, *grid.arrays
    for axis, values, at, window, more in zip(grid.axes, cells.values, cells.index, windows, grid.padding, strict=True):
        if window is not None and axis.count > 1:
            away = (values - axis.centre(at)) / axis.width
            away -= axis.count * np.rint(away / axis.count)  # ends that meet
            share *= window.response(np.clip(away, -0.5, 0.5) / more)
    return share


def range_velocity(cube: Cube, noise: np.ndarray | None = None) -> np.ndarray:
    """Power over all angles [W], (range cells, velocity cells) float64; noise: of the same shape, added."""
    ranges, velocities, azimuths, heights = cube.grid.shape
    pair = cube.cell // (azimuths * heights)
    total = np.ascontiguousarray(np.bincount(pair, cube.power, ranges * velocities).reshape(velocities, ranges).T)
    return total if noise is None else total + noise


def _of_map(cube: Cube, scan: ScanConfig, noise: Noise, peaks: bool) -> Cube:
    """The strongest angle of each range and velocity cell that is detected; false alarms at angles of chance."""
    shape = cube.grid.shape
    added = noise.power("cells", shape[:2], scan.cfar_noise_mean, scan.cfar_noise_sdev)
    power = range_velocity(cube, added)
    axes = (Axis(scan.cfar_rn_t, scan.cfar_rn_g), Axis(scan.cfar_vn_t, scan.cfar_vn_g, wraps=True))
    cube = as_arrays_give(cube)
    strongest = _strongest(cube.cell // (shape[2] * shape[3]), cube.power)
    at = tuple(axis[strongest] for axis in cube.index[:2])
    if added is None:  # without power nothing is detected
        found, level = np.zeros(power.shape, bool), noise_level_at(power, np.stack(at, axis=1), axes)
        found[at] = (power[at] > scan.cfar_offset * level) & (power[at] >= scan.cfar_min_val)
    else:
        found = detect(power, axes, factor=scan.cfar_offset, least=scan.cfar_min_val)
    if peaks:
        found &= _is_peak(power, (0, False), (1, True))
    cells = (_some if any(cube.grid.arrays) else _whole)(cube, strongest[found[at]])
    if added is None:
        return cells
    found[at] = False
    pair_of_noise = np.nonzero(found)
    angle = noise.uniform("angles", len(pair_of_noise[0])) * shape[2] * shape[3]
    angles = np.divmod(np.minimum(angle.astype(np.int64), shape[2] * shape[3] - 1), shape[3])
    return _with_alarms(cells, cube.grid.number((*pair_of_noise, *angles)), power[pair_of_noise])


@compiled(makes_arrays=True)
def _strongest(pair: np.ndarray, power: np.ndarray) -> np.ndarray:
    """The row of the most power of each pair (k,), which rise; of equal powers the first."""
    rows = np.empty(len(pair), np.int64)
    count = 0
    for row in range(len(pair)):
        if row == 0 or pair[row] != pair[row - 1]:
            rows[count] = row
            count += 1
        elif power[row] > power[rows[count - 1]]:
            rows[count - 1] = row
    return rows[:count]


def _whole(cube: Cube, rows: np.ndarray) -> Cube:
    """Some cells, with what lies beside them in angle and nearer than half a cell: a target on their border is one."""
    grid, power, values = cube.grid, cube.power[rows], np.empty((4, len(rows)))
    angles, widths = grid.shape[2:], (grid.azimuth.width, grid.height.width)
    _join(cube.cell, cube.power, cube.values, rows, angles, widths, power, values)
    return Cube(grid, cube.cell[rows], power, values, cube.bounces[rows])


@inlined
def _found_at(cell: Any, cells: np.ndarray) -> Any:
    """The row of a cell among rising ones (k,), -1 if it is not there."""
    low, high = 0, len(cells)
    while low < high:
        middle = (low + high) // 2
        if cells[middle] < cell:
            low = middle + 1
        else:
            high = middle
    return low if low < len(cells) and cells[low] == cell else -1


@compiled
def _join(
    cells: np.ndarray,
    powers: np.ndarray,
    values: np.ndarray,
    rows: np.ndarray,
    angles: tuple[int, int],
    widths: tuple[float, float],
    total: np.ndarray,
    means: np.ndarray,
) -> None:
    """Adds to the powers (n,) of some rows of a cube's cells those of near neighbours; writes the means (4, n) of their
    values. angles: how many cells of azimuth and elevation there are, widths: of these.
    """
    for at in range(len(rows)):
        row = rows[at]
        azimuth, height = cells[row] // angles[1] % angles[0], cells[row] % angles[1]
        for axis in range(4):
            means[axis, at] = powers[row] * values[axis, row]
        for side in range(max(azimuth - 1, 0), min(azimuth + 2, angles[0])):
            for level in range(max(height - 1, 0), min(height + 2, angles[1])):
                beside = _found_at(cells[row] + (side - azimuth) * angles[1] + level - height, cells)
                if beside in (row, -1):
                    continue
                across, up = values[2, beside] - values[2, row], values[3, beside] - values[3, row]
                if abs(across) < widths[0] / 2 and abs(up) < widths[1] / 2:
                    total[at] += powers[beside]
                    for axis in range(4):
                        means[axis, at] += powers[beside] * values[axis, beside]
        for axis in range(4):
            means[axis, at] /= max(total[at], 1e-300)


def _with_alarms(cells: Cube, number: np.ndarray, power: np.ndarray) -> Cube:
    """Adds cells that hold noise alone, by their numbers (k,) in the grid."""
    grid = cells.grid
    values = np.stack([axis.centre(at) for axis, at in zip(grid.axes, grid.index(number), strict=True)])
    return Cube(
        grid,
        np.concatenate((cells.cell, number)),
        np.concatenate((cells.power, power)),
        np.concatenate((cells.values, values), axis=1),
        np.concatenate((cells.bounces, np.zeros(len(number), np.uint8))),
    )


def _of_cube(cube: Cube, scan: ScanConfig, noise: Noise, peaks: bool) -> Cube:
    """The cells that are detected among their neighbours in all four axes; with noise every cell of the cube counts."""
    axes = (
        Axis(scan.cfar_vn_t, scan.cfar_vn_g, wraps=True),
        Axis(scan.cfar_rn_t, scan.cfar_rn_g),
        Axis(scan.cfar_azn_t, scan.cfar_azn_g, wraps=cube.grid.wraps_angles or bool(cube.grid.arrays[0])),
        Axis(scan.cfar_eln_t, scan.cfar_eln_g, wraps=bool(cube.grid.arrays[1])),
    )
    cube = as_arrays_give(cube)
    ranges, velocities, *angles = cube.grid.shape
    shape = velocities, ranges, *angles
    dense = noise.power("cells", shape, scan.cfar_noise_mean, scan.cfar_noise_sdev)
    if dense is None:
        level = sparse_noise_level(cube.cell, cube.power, shape, axes)
        found = (cube.power > scan.cfar_offset * level) & (cube.power >= scan.cfar_min_val)
        if peaks:
            found &= _is_sparse_peak(cube)
        return _some(cube, np.flatnonzero(found))
    dense.reshape(-1)[cube.cell] += cube.power
    found = detect(dense, axes, factor=scan.cfar_offset, least=scan.cfar_min_val)
    if peaks:
        found &= _is_peak(dense, (1, False), (0, True), *((axis, True) for axis in _beams(cube.grid)))
    found = found.reshape(-1)
    cells = _some(cube, np.flatnonzero(found[cube.cell]))
    found[cube.cell] = False
    number = np.flatnonzero(found)
    return _with_alarms(cells, number, dense.reshape(-1)[number])


def _is_peak(power: np.ndarray, *axes: tuple[int, bool]) -> np.ndarray:
    """Which cells have more power than those beside them, bool; axes: (number, whether its ends meet)."""
    found = np.ones(power.shape, bool)
    for axis, wraps in axes:
        ahead, behind = np.roll(power, -1, axis=axis), np.roll(power, 1, axis=axis)
        if not wraps:
            np.moveaxis(ahead, axis, 0)[-1] = 0.0
            np.moveaxis(behind, axis, 0)[0] = 0.0
        found &= (power > ahead) & (power >= behind)
    return found


def _is_sparse_peak(cube: Cube) -> np.ndarray:
    """As `_is_peak`, of the cells (k,) of a cube, in range and velocity, and in the angles of arrays."""
    shape, index, power = cube.grid.shape, cube.index, cube.power
    found = np.ones(len(power), bool)
    for axis, step in itertools.product((0, 1, *_beams(cube.grid)), (1, -1)):
        beside = list(index)
        beside[axis] = (index[axis] + step) % shape[axis]
        number = cube.grid.number(beside)
        place = np.minimum(np.searchsorted(cube.cell, number), max(len(power) - 1, 0))
        inside = axis > 0 or ((index[0] + step >= 0) & (index[0] + step < shape[0]))
        other = np.where(inside & (cube.cell[place] == number), power[place], 0.0) if len(power) else power
        found &= power > other if step > 0 else power >= other
    return found


def _some(cube: Cube, rows: np.ndarray) -> Cube:
    return Cube(cube.grid, cube.cell[rows], cube.power[rows], cube.values[:, rows], cube.bounces[rows])


def limits(grid: Grid) -> dict[str, float]:
    """The unambiguous limits of a cycle as GenericModelOutput names them: m, m/s, rad."""
    azimuth, elevation = np.arcsin(np.clip(grid.ends, -1.0, 1.0)).tolist()
    return {
        "maxRangeM": grid.range_m.high,
        "minVelMps": grid.velocity.low,
        "maxVelMps": grid.velocity.high,
        "minAzRad": azimuth[0],
        "maxAzRad": azimuth[1],
        "minElRad": elevation[0],
        "maxElRad": elevation[1],
    }
