"""The returns of one shot of a lidar: computes each channel from hits and beams, on request only."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from graph.base.records import dataclass, field
from sensors.channels import CHANNELS
from sensors.compiled import compiled
from sensors.frame import spherical
from sensors.gmo import ElementFlags
from sensors.motion.velocities import Velocities
from sensors.raycast.rays import COMMON, NO_SURFACE, Hits
from sensors.raycast.world import CastWorld
from sensors.surfaces.optics import Optics

from .aim import Aim, Output, RayPoses
from .echoes import Candidates, echo_ids
from .pattern import Pattern
from .receiver import Receiver

SurfaceTable = Callable[[], np.ndarray]
"""One row for each surface: encoded materials (n,) uint32, or ids (n, 16) uint8."""


@dataclass(frozen=True, slots=True)
class Span:
    """Some firings of a shot that look at one state of the world.

    rows: firings of the pattern. pose: (4, 4) float64 sensor to world [m], near the middle of these. poses: snapshot
    for the caster (None: now).
    """

    rows: slice
    pose: np.ndarray
    poses: Any = None


@dataclass(slots=True)
class Shot:
    """Firings that are cast together: origin, targets, and state of the world.

    rows: firings of the pattern. pose: (4, 4) float64 sensor to world [m]. poses: snapshot for the caster (None: now).
    base_ns: start of the turn relative to the frame's timestamp [ns]. moves: the sensor's pose at each firing; None if
    it is stationary at `pose`. turn: the number of the turn, on which noise depends. common: (4, 4) pose to which all
    points are transformed (motion compensation); None leaves each as its own firing saw it. spans: of firings that look
    at several states, all from the position of `pose`; `poses` then has no meaning.
    """

    rows: slice
    pose: np.ndarray
    poses: Any = None
    base_ns: int = 0
    moves: RayPoses | None = None
    turn: int = 0
    common: np.ndarray | None = None
    spans: Sequence[Span] = ()

    @property
    def looks(self) -> Sequence[Span]:
        """Its firings by the state that they look at."""
        return self.spans or (Span(self.rows, self.pose, self.poses),)


@dataclass(slots=True)
class Targets:
    """What beams may meet, and the channels that are requested of it.

    optics: the optical properties of the surfaces, by which returns that are too weak are dropped; without them there
    is no threshold and no intensity. velocities: of hit points, None: all rest. tables: of the surfaces, by channel.
    """

    channels: frozenset[str]
    world: CastWorld
    optics: Optics | None = None
    velocities: Velocities | None = None
    tables: Mapping[str, SurfaceTable] = field(default_factory=dict)


@dataclass(slots=True)
class Met:
    """What n rays meet, and the k returns among it.

    distance: (n,) float32 [m], true and along the beams (those of `hits` are along rays, which may begin behind glass);
    ranges: (n,) float32 [m], as reported. Of the returns: beam (k,), ascending, counted from the shot's first; at (k,),
    their hits; light (k,) float32, relative to a whole beam on a white diffuse surface along its normal. dark: (k,)
    bool, rows of beams without a return; None if these have no rows.
    """

    hits: Hits
    distance: np.ndarray
    ranges: np.ndarray
    beam: np.ndarray
    at: np.ndarray
    light: np.ndarray
    dark: np.ndarray | None = None

    def candidates(self) -> Candidates:
        """The returns, to be grouped."""
        hits, at = self.hits, self.at
        assert hits.normals is not None
        normals = np.take(hits.normals, at, axis=0, mode="clip")
        return Candidates(self.beam, np.take(self.distance, at, mode="clip"), self.light, normals, hits.surfaces(at))

    def add_dark_beams(self, beams: int) -> None:
        """Adds a row for each of `beams` beams without a return."""
        without = np.flatnonzero(np.bincount(self.beam, minlength=beams) == 0)
        returns, beam = len(self.beam), np.concatenate([self.beam, without])
        order = np.argsort(beam, kind="stable")
        self.beam, self.dark = beam[order], order >= returns
        self.at, self.light = (
            np.append(one, np.zeros_like(without, one.dtype))[order] for one in (self.at, self.light)
        )


class Returns:
    """The returns of one shot; each channel is a method, called only if the channel is requested."""

    def __init__(
        self,
        *,
        pattern: Pattern,
        shot: Shot,
        met: Met,
        aim: Aim,
        output: Output,
        targets: Targets,
        receiver: Receiver | None = None,
    ) -> None:
        """The data from which channels are computed. aim: origins and directions of the rays."""
        self._pattern, self._shot, self._hits, self._index = pattern, shot, met.hits, met.beam
        self._rows, self._at, self._light, self._invalid = shot.rows, met.at, met.light, met.dark
        self._aim, self._output = aim, output
        self._measure, self._tables, self._receiver = targets.velocities, targets.tables, receiver
        self._beam_angles = output.is_sensor_frame and pattern.origins is None
        self._cached: dict[str, Any] = {}
        self._range = np.take(met.ranges, met.at, mode="clip")
        if self._invalid is not None:
            self._range[self._invalid] = 0.0

    def arrays(self, channels: frozenset[str]) -> dict[str, np.ndarray]:
        """The requested channels of returns, and "count"."""
        found: dict[str, np.ndarray] = {"count": np.array(len(self._index))}
        for name in channels:
            if name in BEAM_CHANNELS:
                found[name] = self._of_pattern(getattr(self._pattern, BEAM_CHANNELS[name]))
            elif name in self._tables:
                found[name] = self._of_surface(name)
            elif name in MAKERS:
                found[name] = MAKERS[name](self)
        return found

    def _of_pattern(self, array: np.ndarray) -> np.ndarray:
        return np.take(array[self._rows], self._index, axis=0, mode="clip")

    def xyz(self) -> np.ndarray:
        """Hit points, (k, 3) [m]."""
        if "xyz" not in self._cached:
            self._cached["xyz"] = self._points()
        return np.asarray(self._cached["xyz"])

    def _points(self) -> np.ndarray:
        pattern = self._pattern
        points = self._along_beams()
        if pattern.origins is not None:
            points += self._of_pattern(pattern.origins)
        points = self._output.points(points, self._aim, self._index)
        if self._invalid is not None:
            points[self._invalid] = 0.0
        return points

    def _along_beams(self) -> np.ndarray:
        """Range times direction, (k, 3) float32, sensor frame, from each ray's origin."""
        points = np.empty((len(self._index), 3), np.float32)
        _along(self._pattern.directions[self._rows], self._index, self._range, points)
        return points

    def azimuth(self) -> np.ndarray:
        """Azimuths [deg]: those of the beams if points lie on them."""
        return self._of_pattern(self._pattern.azimuth_deg) if self._beam_angles else self._spherical()[0]

    def elevation(self) -> np.ndarray:
        """Elevations [deg], as azimuth."""
        return self._of_pattern(self._pattern.elevation_deg) if self._beam_angles else self._spherical()[1]

    def distance(self) -> np.ndarray:
        """Distances [m] from the origin of the frame of reference."""
        return self._range if self._beam_angles else self._spherical()[2]

    def _spherical(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if "spherical" not in self._cached:
            self._cached["spherical"] = spherical(self.xyz())
        a, e, d = self._cached["spherical"]
        return a, e, d

    def beam_azimuth(self) -> np.ndarray:
        """Azimuths [deg] in the sensor's frame at the firing, whatever the frame of reference."""
        return self._of_pattern(self._pattern.azimuth_deg) if self._pattern.origins is None else self._seen()[0]

    def beam_distance(self) -> np.ndarray:
        """Distances [m], as `beam_azimuth`."""
        return self._range if self._pattern.origins is None else self._seen()[2]

    def _seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if "seen" not in self._cached:
            assert self._pattern.origins is not None
            points = self._along_beams() + self._of_pattern(self._pattern.origins)
            if self._invalid is not None:
                points[self._invalid] = 0.0
            self._cached["seen"] = spherical(points)
        a, e, d = self._cached["seen"]
        return a, e, d

    def scalar(self) -> np.ndarray:
        """Intensities, as the receiver gives them."""
        if self._receiver is None:
            return np.zeros(len(self._index), np.float32)
        scalar = self._receiver.intensity(self._light, self._range)
        if self._invalid is not None:
            scalar[self._invalid] = 0.0
        return scalar

    def hit_normals(self) -> np.ndarray:
        """Unit normals towards the sensor, (k, 3); 0 without a return."""
        assert self._hits.normals is not None
        normals = np.take(self._hits.normals, self._at, axis=0, mode="clip")
        _face(normals, self._aim.table, self._index)
        if self._invalid is not None:
            normals[self._invalid] = 0.0
        return np.ascontiguousarray(self._output.vectors(normals, self._aim, self._index))

    def velocities(self) -> np.ndarray:
        """Velocities of the hit points [m/s], (k, 3), float32."""
        found = np.zeros((len(self._index), 3), np.float32)
        if self._measure is None or not len(found):
            return found
        levers, begin = cache(self._levers), self._rows.start
        for look in self._shot.looks:
            low, high = self._index.searchsorted((look.rows.start - begin, look.rows.stop - begin))
            self._add_velocities(found, slice(low, high), levers, look.poses)
        if self._invalid is not None:
            found[self._invalid] = 0.0
        return found

    def _add_velocities(self, found: np.ndarray, rows: slice, levers: Callable[[], np.ndarray], poses: Any) -> None:
        """Writes the velocities of the returns `rows`, seen in one state."""
        assert self._measure is not None
        aim, index = self._aim, self._index[rows]
        measured = self._measure.of(
            surfaces=self._surfaces()[rows],
            levers=lambda: levers()[:, rows],
            origin=aim.pose[:3, 3],
            poses=poses,
            own=lambda: aim.twists(index),
        )
        if measured is not None:
            moving, world = measured
            found[rows][moving] = self._output.vectors(world, aim, index[moving])

    def _levers(self) -> np.ndarray:
        """Vectors from the sensor's position to the hit points, (3, k) float32 [m], world axes."""
        offsets = COMMON if self._aim.offsets is None else self._aim.offsets
        places = np.empty((3, len(self._index)), np.float32)
        _places(self._aim.table, offsets, self._index, self._range, places)
        return places

    def _of_surface(self, name: str) -> np.ndarray:
        """Rows of a surface table; 0 without a return."""
        found = np.take(self._tables[name](), self._surfaces(), axis=0, mode="clip")
        if self._invalid is not None:
            found[self._invalid] = 0
        return np.asarray(found, CHANNELS[name].dtype)

    def _surfaces(self) -> np.ndarray:
        """The surface of each return, (k,) int32; `NO_SURFACE` without a return."""
        if "surfaces" not in self._cached:
            surface = self._hits.surfaces(self._at)
            if self._invalid is not None:
                surface[self._invalid] = NO_SURFACE
            self._cached["surfaces"] = surface
        return np.asarray(self._cached["surfaces"])

    def time_offset(self) -> np.ndarray:
        """Firing times after the frame's timestamp [ns]."""
        offset = self._of_pattern(self._pattern.offset_ns)
        if self._shot.base_ns:
            offset = np.maximum(offset + np.int64(self._shot.base_ns), 0).astype(np.int32)
        return offset

    def flags(self) -> np.ndarray:
        """VALID for each return."""
        flags = np.full(len(self._index), int(ElementFlags.VALID), np.uint8)
        if self._invalid is not None:
            flags[self._invalid] = 0
        return flags

    def echo_id(self) -> np.ndarray:
        """0 for the first return of a beam, 1 for the second ..."""
        return echo_ids(self._index)


@compiled
def _along(directions: np.ndarray, index: np.ndarray, ranges: np.ndarray, points: np.ndarray) -> None:
    """Writes the points (k, 3) on the beams `index` (k,) of directions (n, 3)."""
    for row in range(len(index)):
        for axis in range(3):
            points[row, axis] = directions[index[row], axis] * ranges[row]


@compiled
def _places(table: np.ndarray, offsets: np.ndarray, index: np.ndarray, ranges: np.ndarray, places: np.ndarray) -> None:
    """Writes the points (3, k) on the rays `index` (k,) of a table (n, 6), which begin at offsets (n or 1, 3)."""
    for row in range(len(index)):
        ray = index[row]
        own = min(ray, len(offsets) - 1)
        for axis in range(3):
            places[axis, row] = table[ray, 3 + axis] * ranges[row] + offsets[own, axis]


@compiled
def _face(normals: np.ndarray, table: np.ndarray, index: np.ndarray) -> None:
    """Turns normals (k, 3) towards the origins of the rays `index` (k,) of a table (n, 6), in place."""
    for row in range(len(index)):
        ray, (x, y, z) = index[row], (normals[row, 0], normals[row, 1], normals[row, 2])
        away = table[ray, 3] * x + table[ray, 4] * y + table[ray, 5] * z > 0
        side = np.float32(-1.0) if away else np.float32(1.0)
        for axis in range(3):
            normals[row, axis] = normals[row, axis] * side + np.float32(0.0)  # no negative zeros


BEAM_CHANNELS = {
    "emitterId": "emitter_id",
    "channelId": "channel_id",
    "tickId": "tick_id",
    "tickStates": "tick_state",
    "ring": "ring",
    "column": "column",
}
"""Channels that only identify the firing -> the pattern's array."""

MAKERS: dict[str, Callable[[Returns], np.ndarray]] = {
    "xyz": Returns.xyz,
    "azimuth": Returns.azimuth,
    "elevation": Returns.elevation,
    "distance": Returns.distance,
    "beamAzimuth": Returns.beam_azimuth,
    "beamDistance": Returns.beam_distance,
    "scalar": Returns.scalar,
    "timeOffsetNs": Returns.time_offset,
    "flags": Returns.flags,
    "echoId": Returns.echo_id,
    "hitNormals": Returns.hit_normals,
    "velocities": Returns.velocities,
}
"""The method for each measured channel: a frame's returns -> (k,) or (k, width)."""
