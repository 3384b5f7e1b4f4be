"""The ideal lidar: poses, geometry and a firing pattern in, channel arrays out. It knows no clock and no stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from sensors.optics import Optics, optics_of
from sensors.raycast.rays import Hits, RayBundle, RayCaster
from sensors.raycast.windows import RayGrid

from .aim import Aim, moving_aim, turned_back
from .noise import Noise
from .pattern import Pattern
from .receiver import Receiver, reflected_light
from .returns import Returns, Shot, SurfaceTable, Velocities


class Scanner:
    """Measures with one pattern. Its arrays are allocated once; results are the caller's.

    frame: SENSOR gives points, angles, normals and velocities in the sensor frame of each shot, WORLD in world axes
    about the world's origin. Firings without a return between the near and far gates are left out, unless
    `keep_invalid`: then they stay with distance 0, scalar 0 and without the VALID flag. Ranges and angles are exact
    unless `noise` says otherwise; the gates are for the ranges that are reported.
    Returns that `receiver` cannot detect count as none; without one there is no threshold, and no intensity.
    optics: what the surfaces do to light.
    """

    def __init__(
        self,
        pattern: Pattern,
        caster: Callable[[], RayCaster],
        *,
        frame: str = "SENSOR",
        exclude: frozenset[str] = frozenset(),
        keep_invalid: bool = False,
        velocities: Velocities | None = None,
        tables: Mapping[str, SurfaceTable] | None = None,
        receiver: Receiver | None = None,
        noise: Noise | None = None,
        optics: Callable[[], Optics] = lambda: optics_of(np.zeros(0)),
    ) -> None:
        self.pattern = pattern
        self._caster = caster
        self._in_world = frame == "WORLD"
        self._exclude = exclude
        self._keep_invalid = keep_invalid
        self._velocities, self._tables = velocities, dict(tables or {})
        self._receiver, self._optics, self._noise = receiver, optics, noise
        count = len(pattern)
        self._columns = np.ascontiguousarray(pattern.directions.T)
        self._table = np.empty((count, 6), np.float32)
        self._written = np.full(4, np.nan, np.float32)
        self._world = np.empty((3, count), np.float32)
        self._cosine, self._term = np.empty(count, np.float32), np.empty(count, np.float32)
        self._turned_by: bytes | None = None
        self._grid: RayGrid | None = None
        self._reach = float(pattern.far_m.max(initial=0.0)) * (1 + 1e-6)

    def scan(self, shot: Shot, channels: frozenset[str]) -> dict[str, np.ndarray]:
        """The channels asked for, each with one row per return, in the order of the pattern. Always has "count"."""
        optics = self._optics() if self._receiver is not None else None
        hits, aim = self._cast(shot, channels, optics)
        distance = hits.distance
        if self._noise is not None:
            hits.distance = self._noise.measured(distance, shot.rows, shot.turn)
        valid = self._valid(hits.distance, shot.rows)
        reflected = None
        if optics is not None and hits.normals is not None:
            reflected = reflected_light(self._incidence(hits.normals), hits.surface, optics)
            assert self._receiver is not None
            self._receiver.detect(reflected, distance, valid)
        index = np.arange(len(valid)) if self._keep_invalid else np.flatnonzero(valid)
        returns = Returns(
            pattern=self.pattern,
            shot=shot,
            hits=hits,
            index=index,
            valid=valid if self._keep_invalid else None,
            columns=self._columns[:, shot.rows],
            aim=aim,
            in_world=self._in_world,
            velocities=self._velocities,
            tables=self._tables,
            receiver=self._receiver,
            reflected=reflected,
        )
        return returns.arrays(channels)

    def _cast(self, shot: Shot, channels: frozenset[str], optics: Optics | None) -> tuple[Hits, Aim]:
        pattern, rows = self.pattern, shot.rows
        table = self._table[: rows.stop - rows.start]
        world = self._world[:, : len(table)]
        columns, origins, swing, exact = self._beams(shot)
        if shot.moves is not None:
            aim = moving_aim(shot.pose, shot.moves, columns, origins, world)
            for axis in range(3):
                table[:, 3 + axis] = world[axis]
            swing += shot.moves.swing(shot.pose)
            self._turned_by = None
        else:
            rotation = shot.pose[:3, :3]
            whole = exact and rows.start == 0 and rows.stop == len(pattern)
            key = rotation.tobytes() if whole else None
            if key is None or key != self._turned_by:
                self._turn(table, columns, rotation.astype(np.float32))
                self._turned_by = key
            offsets = None if origins is None else turned_back(origins, rotation.T.astype(np.float32))
            aim = Aim(shot.pose, world, offsets)
        bundle = RayBundle(
            origin=aim.pose[:3, 3],
            table=table,
            offsets=aim.offsets,
            exclude=self._exclude,
            reach=self._reach,
            grid=self._turned_grid(aim.pose[:3, :3]),
            first=rows.start,
            swing=swing,
            written=self._written,
        )
        receiver = self._receiver
        lit = receiver is not None and (receiver.detects or "scalar" in channels)
        hits = self._caster().cast(
            bundle,
            shot.poses,
            normals=lit or "hitNormals" in channels,
            surfaces="velocities" in channels
            or not channels.isdisjoint(self._tables)
            or (lit and optics is not None and optics.uniform is None),
        )
        return hits, aim

    def _beams(self, shot: Shot) -> tuple[np.ndarray, np.ndarray | None, float, bool]:
        """Directions (3, n) and origins (n, 3) of the shot's beams in the sensor frame, the largest angle [rad] between
        a direction and the pattern's, and whether they are the pattern's own.
        """
        rows, noise, pattern = shot.rows, self._noise, self.pattern
        columns = self._columns[:, rows]
        if noise is None:
            return columns, None if pattern.origins is None else pattern.origins[rows], 0.0, True
        off = noise.directions(rows, shot.turn)
        origins = noise.origins(rows, shot.turn)
        return (columns, origins, 0.0, True) if off is None else (off[0], origins, off[1], False)

    def _turn(self, table: np.ndarray, columns: np.ndarray, rotation: np.ndarray) -> None:
        """World directions into the table; by columns, so that a slice has the bytes it has in the whole."""
        x, y, z = columns
        term = np.empty_like(x)
        for axis in range(3):
            column = self._world[axis, : len(table)]
            np.multiply(x, rotation[axis, 0], out=column)
            np.multiply(y, rotation[axis, 1], out=term)
            column += term
            np.multiply(z, rotation[axis, 2], out=term)
            column += term
            table[:, 3 + axis] = column

    def _turned_grid(self, rotation: np.ndarray) -> RayGrid:
        if self._grid is None:
            self._grid = RayGrid(self.pattern.directions)
        self._grid.rotation = rotation
        return self._grid

    def _incidence(self, normals: np.ndarray) -> np.ndarray:
        """The cosine of incidence of each ray of the shot that was turned last, (n,) float32, unsigned."""
        count = len(normals)
        cosine, term = self._cosine[:count], self._term[:count]
        np.multiply(self._world[0, :count], normals[:, 0], out=cosine)
        cosine += np.multiply(self._world[1, :count], normals[:, 1], out=term)
        cosine += np.multiply(self._world[2, :count], normals[:, 2], out=term)
        return np.abs(cosine, out=cosine)

    def _valid(self, distance: np.ndarray, rows: slice) -> np.ndarray:
        """Whether each distance lies between the gates of its emitter."""
        near, far = self.pattern.near_m, self.pattern.far_m
        if near.ndim:
            near, far = near[rows], far[rows]
        valid = distance >= near
        valid &= distance <= far
        return np.asarray(valid)
