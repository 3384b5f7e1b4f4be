"""Raycast sensors: the rays of an IsaacRaycastSensor prim, and what they hit."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.sim.transforms import Floats, apply, rigid_part, transformed

from .inertial import attribute_of

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView

FRAMES = ("SENSOR", "WORLD")
_RANGES = (("minRange", 0.4), ("maxRange", 100.0))


@dataclass(frozen=True, slots=True)
class RayReading:
    """What the rays of one reading hit: time [s]; lengths in stage units.

    origins, ends: (n, 3) world; depths: (n,), the longest range where a ray hits nothing; positions, normals: (n, 3) in
    the frame that the sensor asks for, normals 0 where nothing is hit; prims: paths of what is hit, if asked for.
    """

    time: float
    origins: Floats
    ends: Floats
    depths: Floats
    positions: Floats
    normals: Floats
    prims: list[str]


@dataclass(slots=True)
class RaySensor:
    """A sensor as its prim states it.

    origins, directions: (n, 3), axes of the sensor, directions of length 1; offsets: (n,) [s] or none; nearest,
    farthest: range [stage units]; in_world: whether hits are given in world axes; names: whether the prims that were
    hit are given.
    """

    path: str
    enabled: bool
    origins: Floats
    directions: Floats
    offsets: Floats
    nearest: float
    farthest: float
    in_world: bool
    names: bool

    @classmethod
    def of(cls, prim: Any) -> RaySensor:
        """The sensor that a prim describes. Raises RunError if its ray attributes do not fit together."""
        path = str(prim.GetPath())

        def vectors(name: str) -> Floats:
            return np.array(attribute_of(prim, name, []), float).reshape(-1, 3)

        origins, directions = vectors("rayOrigins"), vectors("rayDirections")
        # The stage stores floats: 0.7 is meant, not 0.699999988.
        offsets = np.array([float(str(np.float32(one))) for one in attribute_of(prim, "rayTimeOffsets", [])])
        count = int(attribute_of(prim, "numRays", len(directions)))
        for name, found in (("rayDirections", directions), ("rayOrigins", origins), ("rayTimeOffsets", offsets)):
            if len(found) != count and not (name == "rayTimeOffsets" and not len(found)):
                raise RunError(f"{path}.{name} has {len(found)} elements; give it {count}, one for each ray of numRays")
        lengths = np.linalg.norm(directions, axis=1)
        if not (np.isfinite(lengths) & (lengths > 0)).all():
            raise RunError(
                f"{path}.rayDirections holds a vector of length 0 or a vector that is not finite; correct it"
            )
        nearest, farthest = (float(attribute_of(prim, name, default)) for name, default in _RANGES)
        if not 0 <= nearest < farthest:
            raise RunError(
                f"{path} has minRange {nearest} and maxRange {farthest}; minRange must be the smaller, 0 or more"
            )
        frame = str(attribute_of(prim, "outputFrameOfReference", FRAMES[0]))
        if frame not in FRAMES:
            raise RunError(f'{path}.outputFrameOfReference is "{frame}"; it must be SENSOR or WORLD')
        enabled, names = attribute_of(prim, "enabled", True), attribute_of(prim, "reportHitPrimPaths", False)
        ahead = directions / lengths[:, None]
        in_world = frame == "WORLD"
        return cls(path, bool(enabled), origins, ahead, offsets, nearest, farthest, in_world, bool(names))

    def fired(self, start: Fraction, end: Fraction) -> Any:
        """(n,) which rays are fired from `start` until just before `end` [s]; all rays if the sensor has no offsets."""
        if not len(self.offsets):
            return np.ones(len(self.directions), bool)
        period = Fraction(str(self.offsets.max()))
        if period <= 0 or end - start >= period:
            return np.ones(len(self.directions), bool)
        phase = self.offsets % float(period)
        first, last = float(start % period), float(end % period)
        return (phase >= first) & (phase < last) if first <= last else (phase >= first) | (phase < last)

    def read(self, scene: WorldView) -> RayReading:
        """Casts the rays of the newest physics step, from the shortest range on, at the surfaces that lidars see."""
        now = scene.times.time
        chosen = self.fired(now - 1 / scene.steps_per_second, now)
        placed = np.asarray(scene.fabric.world_matrix(self.path), float)
        turn = rigid_part(placed)[:3, :3]
        origins, directions = transformed(placed, self.origins[chosen]), apply(turn, self.directions[chosen])
        depths, normals, prims = self._cast(scene, origins, directions)
        ends = positions = origins + directions * depths[:, None]
        if not self.in_world:
            positions, normals = transformed(np.linalg.inv(placed), ends), apply(turn.T, normals)
        return RayReading(float(now), origins, ends, depths, positions, normals, prims if self.names else [])

    def _cast(self, scene: WorldView, origins: Floats, directions: Floats) -> tuple[Floats, Floats, list[str]]:
        """Depths (n,) [stage units], normals (n, 3) and paths of the hit prims."""
        from .raycast.rays import NO_SURFACE, cast_ranged
        from .raycast.shared import cast_world

        count, unit = len(origins), float(scene.meters_per_unit)
        if not count:
            return np.zeros(0), np.zeros((0, 3)), []
        world = cast_world(scene)
        ranges = self.nearest * unit, (self.farthest - self.nearest) * unit
        hits = cast_ranged(world, origins * unit, directions, ranges, normals=True)
        depths = hits.distance.astype(float) / unit + self.nearest
        found = depths <= self.farthest
        paths = [
            world.surfaces[index].path if hit and index != NO_SURFACE else ""
            for index, hit in zip(hits.surfaces().tolist(), found.tolist(), strict=True)
        ]
        normals = np.where(found[:, None], np.zeros((count, 3)) if hits.normals is None else hits.normals, 0.0)
        return np.where(found, depths, self.farthest), normals, paths
