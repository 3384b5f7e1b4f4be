"""The ideal lidar: poses, geometry and a firing pattern in, channel arrays out. It knows no clock and no stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sensors.frame import spherical
from sensors.gmo import ElementFlags
from sensors.raycast.rays import Hits, RayBundle, RayCaster
from sensors.raycast.windows import RayGrid

from .pattern import Pattern

REFLECTANCE = 0.5
"""Reflectance of a surface whose material says nothing."""

Velocities = Callable[[np.ndarray, Callable[[np.ndarray], np.ndarray], Any], tuple[np.ndarray, np.ndarray]]
"""Surfaces (k,) hit, a function from rows to hit points (m, 3) float64 [m, world], a state -> the rows that move (m,)
and their velocities (m, 3) float64 [m/s], along world axes."""


@dataclass(slots=True)
class Shot:
    """One geometry state to look at: the firings, from where, at what, in which state of the world.

    rows: firings of the pattern. pose: (4, 4) float64 sensor to world [m]. poses: snapshot for the caster (None: now).
    base_ns: what the turn's start lies after the frame's timestamp [ns].
    """

    rows: slice
    pose: np.ndarray
    poses: Any = None
    base_ns: int = 0


class Scanner:
    """Measures with one pattern. Its arrays are allocated once; results are the caller's.

    frame: SENSOR gives points, angles, normals and velocities in the sensor frame of each shot, WORLD in world axes
    about the world's origin. Firings without a return between the near and far gates are left out, unless
    `keep_invalid`: then they stay with distance 0, scalar 0 and without the VALID flag. Ranges are exact.
    Intensity: reflectance x cosine of incidence, range divided out (NORMALIZATION of the documented chain);
    every surface has reflectance 0.5.
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
    ) -> None:
        self.pattern = pattern
        self._caster = caster
        self._in_world = frame == "WORLD"
        self._exclude = exclude
        self._keep_invalid = keep_invalid
        self._velocities = velocities
        count = len(pattern)
        self._columns = np.ascontiguousarray(pattern.directions.T)
        self._table = np.empty((count, 6), np.float32)
        self._world = np.empty((3, count), np.float32)
        self._turned_by: bytes | None = None
        self._grid: RayGrid | None = None
        self._reach = float(pattern.far_m.max(initial=0.0)) * (1 + 1e-6)

    def scan(self, shot: Shot, channels: frozenset[str]) -> dict[str, np.ndarray]:
        """The channels asked for, each with one row per return, in the order of the pattern. Always has "count"."""
        hits = self._cast(shot, channels)
        index = self._returns(hits.distance, shot.rows)
        return _Returns(self, shot, hits, index).arrays(channels)

    def _cast(self, shot: Shot, channels: frozenset[str]) -> Hits:
        pattern, rows = self.pattern, shot.rows
        rotation = shot.pose[:3, :3]
        whole = rows.start == 0 and rows.stop == len(pattern)
        table = self._table[: rows.stop - rows.start]
        key = rotation.tobytes() if whole else None
        if key is None or key != self._turned_by:
            self._turn(table, rows, rotation.astype(np.float32))
            self._turned_by = key
        offsets = None if pattern.origins is None else turned_back(pattern.origins[rows], rotation.T.astype(np.float32))
        bundle = RayBundle(
            shot.pose[:3, 3], table, offsets, self._exclude, self._reach, self._turned_grid(rotation), rows.start
        )
        return self._caster().cast(
            bundle,
            shot.poses,
            normals="scalar" in channels or "hitNormals" in channels,
            surfaces="velocities" in channels,
        )

    def _turn(self, table: np.ndarray, rows: slice, rotation: np.ndarray) -> None:
        """World directions into the table; by columns, so that a slice has the bytes it has in the whole."""
        x, y, z = self._columns[:, rows]
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

    def _returns(self, distance: np.ndarray, rows: slice) -> np.ndarray:
        """Rows with a return between the gates, counted from the start of the slice."""
        if self._keep_invalid:
            return np.arange(len(distance))
        return np.flatnonzero(self.valid(distance, rows))

    def valid(self, distance: np.ndarray, rows: slice) -> np.ndarray:
        """Whether each distance lies between the gates of its emitter."""
        near, far = self.pattern.near_m, self.pattern.far_m
        if near.ndim:
            near, far = near[rows], far[rows]
        valid = distance >= near
        valid &= distance <= far
        return np.asarray(valid)


class _Returns:
    """The returns of one shot; each channel is a method, called only when somebody wants it."""

    def __init__(self, scanner: Scanner, shot: Shot, hits: Hits, index: np.ndarray) -> None:
        self._scanner, self._shot, self._hits, self._index = scanner, shot, hits, index
        self._pattern = scanner.pattern
        self._rows = shot.rows
        self._beam_angles = not scanner._in_world and scanner.pattern.origins is None
        self._range = np.take(hits.distance, index, mode="clip")
        self._cached: dict[str, Any] = {}
        if scanner._keep_invalid:
            self._valid = scanner.valid(hits.distance, shot.rows)
            self._range[~self._valid] = 0.0

    def arrays(self, channels: frozenset[str]) -> dict[str, np.ndarray]:
        found: dict[str, np.ndarray] = {"count": np.array(len(self._index))}
        for name in channels:
            maker = _MAKERS.get(name)
            if maker is not None:
                found[name] = maker(self)
        return found

    def _of_pattern(self, array: np.ndarray) -> np.ndarray:
        return np.take(array[self._rows], self._index, axis=0, mode="clip")

    def xyz(self) -> np.ndarray:
        if "xyz" not in self._cached:
            self._cached["xyz"] = self._points()
        return np.asarray(self._cached["xyz"])

    def _points(self) -> np.ndarray:
        pattern = self._pattern
        points = self._along_beams()
        if pattern.origins is not None:
            points += self._of_pattern(pattern.origins)
        if self._scanner._in_world:
            points = self._to_world(points).astype(np.float32)
        if self._scanner._keep_invalid:
            points[~self._valid] = 0.0
        return points

    def _along_beams(self) -> np.ndarray:
        """Range times direction, (k, 3) float32, sensor frame: from where each ray starts."""
        points = np.empty((len(self._index), 3), np.float32)
        column = np.empty(len(self._index), np.float32)
        for axis in range(3):
            np.take(self._scanner._columns[axis, self._rows], self._index, out=column, mode="clip")
            np.multiply(column, self._range, out=points[:, axis])
        return points

    def _to_world(self, points: np.ndarray) -> np.ndarray:
        """(k, 3) float64 [m], world, of points in the sensor frame; column by column, whatever their number."""
        rotation, origin = self._shot.pose[:3, :3], self._shot.pose[:3, 3]
        x, y, z = points.astype(np.float64).T
        return np.stack([rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2] * z + origin[i] for i in range(3)], 1)

    def azimuth(self) -> np.ndarray:
        return self._of_pattern(self._pattern.azimuth_deg) if self._beam_angles else self._spherical()[0]

    def elevation(self) -> np.ndarray:
        return self._of_pattern(self._pattern.elevation_deg) if self._beam_angles else self._spherical()[1]

    def distance(self) -> np.ndarray:
        return self._range if self._beam_angles else self._spherical()[2]

    def _spherical(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if "spherical" not in self._cached:
            self._cached["spherical"] = spherical(self.xyz())
        a, e, d = self._cached["spherical"]
        return a, e, d

    def _facing(self) -> tuple[np.ndarray, np.ndarray]:
        """(cosine of incidence, unsigned (k,) float32; unit normals towards the sensor (k, 3), world axes)."""
        if "facing" not in self._cached:
            assert self._hits.normals is not None
            normals = np.take(self._hits.normals, self._index, axis=0, mode="clip")
            cosine, column = np.zeros(len(normals), np.float32), np.empty(len(normals), np.float32)
            for axis in range(3):
                np.take(self._scanner._world[axis, : len(self._hits.distance)], self._index, out=column, mode="clip")
                cosine += np.multiply(column, normals[:, axis], out=column)
            self._cached["facing"] = cosine, normals
        cosine, normals = self._cached["facing"]
        return cosine, normals

    def scalar(self) -> np.ndarray:
        scalar = np.abs(self._facing()[0])
        scalar *= np.float32(REFLECTANCE)
        if self._scanner._keep_invalid:
            scalar[~self._valid] = 0.0
        return np.asarray(scalar)

    def hit_normals(self) -> np.ndarray:
        cosine, normals = self._facing()
        towards = np.where(cosine > 0, np.float32(-1.0), np.float32(1.0))
        facing = np.empty((3, len(cosine)), np.float32)
        for axis in range(3):
            np.multiply(normals[:, axis], towards, out=facing[axis])
        facing += np.float32(0.0)  # no negative zeros
        if self._scanner._in_world:
            return np.ascontiguousarray(facing.T)
        return turned_back(facing.T, self._shot.pose[:3, :3].astype(np.float32))

    def velocities(self) -> np.ndarray:
        found = np.zeros((len(self._index), 3), np.float32)
        measure = self._scanner._velocities
        if measure is None or self._hits.surface is None or not len(found):
            return found
        surfaces = np.take(self._hits.surface, self._index, mode="clip")
        rows, world = measure(surfaces, self._world_points, self._shot.poses)
        velocities = world if self._scanner._in_world else turned_back(world, self._shot.pose[:3, :3])
        found[rows] = velocities
        if self._scanner._keep_invalid:
            found[~self._valid] = 0.0
        return found

    def _world_points(self, rows: np.ndarray) -> np.ndarray:
        points = self._along_beams()[rows]
        if self._pattern.origins is not None:
            points += self._of_pattern(self._pattern.origins)[rows]
        return self._to_world(points)

    def time_offset(self) -> np.ndarray:
        offset = self._of_pattern(self._pattern.offset_ns)
        if self._shot.base_ns:
            offset = np.maximum(offset + np.int64(self._shot.base_ns), 0).astype(np.int32)
        return offset

    def flags(self) -> np.ndarray:
        flags = np.full(len(self._index), int(ElementFlags.VALID), np.uint8)
        if self._scanner._keep_invalid:
            flags[~self._valid] = 0
        return flags

    def emitter_id(self) -> np.ndarray:
        return self._of_pattern(self._pattern.emitter_id)

    def channel_id(self) -> np.ndarray:
        return self._of_pattern(self._pattern.channel_id)

    def tick_id(self) -> np.ndarray:
        return self._of_pattern(self._pattern.tick_id)

    def tick_state(self) -> np.ndarray:
        return self._of_pattern(self._pattern.tick_state)

    def echo_id(self) -> np.ndarray:
        return np.zeros(len(self._index), np.uint8)


_MAKERS: dict[str, Callable[[_Returns], np.ndarray]] = {
    "xyz": _Returns.xyz,
    "azimuth": _Returns.azimuth,
    "elevation": _Returns.elevation,
    "distance": _Returns.distance,
    "scalar": _Returns.scalar,
    "timeOffsetNs": _Returns.time_offset,
    "flags": _Returns.flags,
    "emitterId": _Returns.emitter_id,
    "channelId": _Returns.channel_id,
    "tickId": _Returns.tick_id,
    "echoId": _Returns.echo_id,
    "tickStates": _Returns.tick_state,
    "hitNormals": _Returns.hit_normals,
    "velocities": _Returns.velocities,
}


def turned_back(vectors: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) in the axes of the rotated frame: R^T v, column by column, so that no length changes the sums."""
    out = np.empty(vectors.shape, np.result_type(vectors, rotation))
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    column, term = np.empty(len(vectors), out.dtype), np.empty(len(vectors), out.dtype)
    for axis in range(3):
        np.multiply(x, rotation[0, axis], out=column)
        column += np.multiply(y, rotation[1, axis], out=term)
        column += np.multiply(z, rotation[2, axis], out=term)
        out[:, axis] = column
    return out
