"""From the cube to detections: noise, constant false alarm rate, values, radar cross sections."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .antenna import Antenna
from .cfar import Axis, detect, sparse_noise_level
from .config import ScanConfig
from .cube import Cube, Grid
from .noise import Noise

MOST_DETECTIONS = 2500
"""The strongest are kept, as many as the original's frames hold."""


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
    else:
        values = cells.values
    range_m, velocity = values[:2]
    azimuth = np.arcsin(np.clip(values[2], -1, 1))
    elevation = np.zeros(len(range_m)) if grid.flat else np.arcsin(np.clip(values[3], -1, 1))
    true_range, _, sine, height = cells.values
    level = np.sqrt(np.maximum(1 - height**2, 0))
    directions = np.stack((np.sqrt(np.maximum(1 - sine**2, 0)) * level, sine * level, height))
    least, factor, scale = scan.rcs_tuning_coefficients
    sigma = antenna.cross_section(cells.power, true_range, directions) * factor
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
    found = detect(power, axes, factor=scan.cfar_offset, least=scan.cfar_min_val)
    if peaks:
        found &= _is_peak(power)
    pair = cube.cell // (shape[2] * shape[3])
    order = np.lexsort((-cube.power, pair))
    first = order[np.flatnonzero(np.diff(pair[order], prepend=-1))]
    at = tuple(axis[first] for axis in cube.index[:2])
    cells = _some(cube, first[found[at]])
    if added is None:
        return cells
    found[at] = False
    return _with_alarms(cells, found, power, noise)


def _with_alarms(cells: Cube, found: np.ndarray, power: np.ndarray, noise: Noise) -> Cube:
    """Adds cells that hold noise alone."""
    grid, pair = cells.grid, np.nonzero(found)
    azimuths, heights = grid.shape[2:]
    angle = noise.uniform("angles", len(pair[0])) * azimuths * heights
    index = (*pair, *np.divmod(np.minimum(angle.astype(np.int64), azimuths * heights - 1), heights))
    values = np.stack([axis.centre(at) for axis, at in zip(grid.axes, index, strict=True)])
    return Cube(
        grid,
        np.concatenate((cells.cell, grid.number(index))),
        np.concatenate((cells.power, power[pair])),
        np.concatenate((cells.values, values), axis=1),
        np.concatenate((cells.bounces, np.zeros(len(pair[0]), np.uint8))),
    )


def _of_cube(cube: Cube, scan: ScanConfig, noise: Noise, peaks: bool) -> Cube:
    """The cells of the sparse cube that are detected among their neighbours in all four axes.

    Noise is a mean level in every cell, and a random part in those that hold power: cells without are not drawn.
    """
    axes = (
        Axis(scan.cfar_vn_t, scan.cfar_vn_g, wraps=True),
        Axis(scan.cfar_rn_t, scan.cfar_rn_g),
        Axis(scan.cfar_azn_t, scan.cfar_azn_g, wraps=cube.grid.wraps_angles),
        Axis(scan.cfar_eln_t, scan.cfar_eln_g),
    )
    added = noise.power("cells", (len(cube.cell),), scan.cfar_noise_mean, scan.cfar_noise_sdev)
    power = cube.power if added is None else cube.power + added
    ranges, velocities, *angles = cube.grid.shape
    level = sparse_noise_level(cube.cell, cube.power, (velocities, ranges, *angles), axes) + scan.cfar_noise_mean
    found = (power > scan.cfar_offset * level) & (power >= scan.cfar_min_val)
    if peaks:
        found &= _is_sparse_peak(cube, power)
    return _some(cube, np.flatnonzero(found))


def _is_peak(power: np.ndarray) -> np.ndarray:
    """Which cells of (range, velocity) have more power than those beside them, bool; velocities wrap."""
    edge = np.zeros((1, power.shape[1]))
    ahead, behind = np.concatenate((power[1:], edge)), np.concatenate((edge, power[:-1]))
    return np.asarray(
        (power > ahead)
        & (power >= behind)
        & (power > np.roll(power, -1, axis=1))
        & (power >= np.roll(power, 1, axis=1))
    )


def _is_sparse_peak(cube: Cube, power: np.ndarray) -> np.ndarray:
    """The same of the cells of a sparse cube, each among those of its angles."""
    ranges, velocities, *_ = cube.grid.shape
    at, speed, *angles = cube.index
    found = np.ones(len(power), bool)
    for step, turn in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        inside = (at + step >= 0) & (at + step < ranges)
        number = cube.grid.number((np.clip(at + step, 0, ranges - 1), (speed + turn) % velocities, *angles))
        place = np.minimum(np.searchsorted(cube.cell, number), max(len(power) - 1, 0))
        beside = np.where(inside & (cube.cell[place] == number), power[place], 0.0) if len(power) else power
        found &= power > beside if step + turn > 0 else power >= beside
    return found


def _some(cube: Cube, rows: np.ndarray) -> Cube:
    return Cube(cube.grid, cube.cell[rows], cube.power[rows], cube.values[:, rows], cube.bounces[rows])


def limits(grid: Grid) -> dict[str, float]:
    """The unambiguous limits of a cycle as GenericModelOutput names them: m, m/s, rad."""
    return {
        "maxRangeM": grid.range_m.high,
        "minVelMps": grid.velocity.low,
        "maxVelMps": grid.velocity.high,
        "minAzRad": float(np.arcsin(max(grid.azimuth.low, -1.0))),
        "maxAzRad": float(np.arcsin(min(grid.azimuth.high, 1.0))),
        "minElRad": float(np.arcsin(max(grid.height.low, -1.0))),
        "maxElRad": float(np.arcsin(min(grid.height.high, 1.0))),
    }
