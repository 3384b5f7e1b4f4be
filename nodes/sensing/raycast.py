"""Raycast sensors: distances along the sensor's own rays."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

from .imu import sensor_prim

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graph.sim.app import App

    Floats = NDArray[np.float64]

FRAMES = ("SENSOR", "WORLD")


@dataclass(slots=True)
class _Rays:
    """A sensor, read from its prim at the first reading after play.

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

    def fired(self, start: Fraction, end: Fraction) -> Any:
        """(n,) which rays are fired from `start` until just before `end` [s]; all rays if the sensor has no offsets."""
        import numpy as np

        if not len(self.offsets):
            return np.ones(len(self.directions), bool)
        period = Fraction(str(self.offsets.max()))
        if period <= 0 or end - start >= period:
            return np.ones(len(self.directions), bool)
        phase = self.offsets % float(period)
        first, last = float(start % period), float(end % period)
        return (phase >= first) & (phase < last) if first <= last else (phase >= first) | (phase < last)


@dataclass(slots=True)
class _Memory:
    rays: _Rays | None = None


@node_type(
    "isaacsim.sensors.physics.IsaacReadRaycastSensor",
    version=1,
    needs=(("raycastSensorPrim",),),
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "raycastSensorPrim": Attribute("target", "an IsaacRaycastSensor"),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0.0, unit="s"),
        "depths": Attribute(
            "float[]", "how far each ray goes from its origin; maxRange where it hits nothing", unit="stage units"
        ),
        "hitPositions": Attribute(
            "float[]", "x, y, z of where each ray ends, in the sensor's axes or the world's", unit="stage units"
        ),
        "hitNormals": Attribute(
            "float[]", "x, y, z of the normal of what each ray hits; 0, 0, 0 where it hits nothing"
        ),
        "hitPrimPaths": Attribute("token[]", "what each ray hits, with the prim's reportHitPrimPaths; else empty"),
        "numRays": Attribute("uint", "rays of this reading", default=0),
        "beamOrigins": Attribute("pointf[3][]", "where each ray begins in the world", default=[], unit="stage units"),
        "beamEndPoints": Attribute("pointf[3][]", "where each ray ends in the world", default=[], unit="stage units"),
    },
    memory=_Memory,
)
def read_raycast_sensor(db: Database) -> None:
    """Cast the sensor's rays at the newest physics step, from minRange on, at the surfaces that lidars see.

    The prim is read once after play. If it has time offsets, a reading holds the rays that were fired during the newest
    physics step; for all of them the graph must run in each step (OnPhysicsStep). With a disabled sensor or a stopped
    timeline, and while nobody reads what the node gives, there is no reading.
    """
    import numpy as np

    outputs, app = db.outputs, db.app
    if app.timeline.is_stopped():
        return
    rays = db.memory.rays or _read(db)
    db.memory.rays = rays
    if not rays.enabled or not db.is_read():
        return
    now = app.simulation.time
    chosen = rays.fired(now - 1 / app.simulation.steps_per_second, now)
    local, ahead = rays.origins[chosen], rays.directions[chosen]
    placed = np.asarray(app.fabric.world_matrix(rays.path), float)
    turn = _rotation(placed)
    origins = local @ placed[:3, :3].T + placed[:3, 3]
    directions = ahead @ turn.T
    depths, normals, surfaces = _cast(app, origins, directions, rays)
    ends = origins + directions * depths[:, None]
    outputs.sensorTime = float(now)
    outputs.depths = depths.astype(np.float32)
    outputs.beamOrigins, outputs.beamEndPoints = origins.astype(np.float32), ends.astype(np.float32)
    outputs.numRays = len(depths)
    if not rays.in_world:
        inverse = np.linalg.inv(placed)
        ends, normals = ends @ inverse[:3, :3].T + inverse[:3, 3], normals @ turn
    outputs.hitPositions = ends.astype(np.float32).reshape(-1)
    outputs.hitNormals = normals.astype(np.float32).reshape(-1)
    outputs.hitPrimPaths = surfaces if rays.names else []
    db.fire("execOut")


def _read(db: Database) -> _Rays:
    """The sensor that the input names. Fails the node if its ray attributes do not fit together."""
    import numpy as np

    from sensors.inertial import attribute_of

    prim = sensor_prim(db, db.inputs.raycastSensorPrim, "raycastSensorPrim")
    path = str(prim.GetPath())

    def vectors(name: str) -> Floats:
        return np.array(attribute_of(prim, name, []), float).reshape(-1, 3)

    origins, directions = vectors("rayOrigins"), vectors("rayDirections")
    # The stage stores floats: 0.7 is meant, not 0.699999988.
    offsets = np.array([float(str(np.float32(one))) for one in attribute_of(prim, "rayTimeOffsets", [])])
    count = int(attribute_of(prim, "numRays", len(directions)))
    for name, found in (("rayDirections", directions), ("rayOrigins", origins), ("rayTimeOffsets", offsets)):
        if len(found) != count and not (name == "rayTimeOffsets" and not len(found)):
            db.fail(f"{path}.{name} has {len(found)} elements; give it {count}, one for each ray of numRays")
    lengths = np.linalg.norm(directions, axis=1)
    if not (np.isfinite(lengths) & (lengths > 0)).all():
        db.fail(f"{path}.rayDirections holds a vector of length 0 or a vector that is not finite; correct it")
    nearest, farthest = (float(attribute_of(prim, name, default)) for name, default in _RANGES)
    if not 0 <= nearest < farthest:
        db.fail(f"{path} has minRange {nearest} and maxRange {farthest}; minRange must be the smaller, 0 or more")
    frame = str(attribute_of(prim, "outputFrameOfReference", FRAMES[0]))
    if frame not in FRAMES:
        db.fail(f'{path}.outputFrameOfReference is "{frame}"; it must be SENSOR or WORLD')
    return _Rays(
        path,
        bool(attribute_of(prim, "enabled", True)),
        origins,
        directions / lengths[:, None],
        offsets,
        nearest,
        farthest,
        frame == "WORLD",
        bool(attribute_of(prim, "reportHitPrimPaths", False)),
    )


_RANGES = (("minRange", 0.4), ("maxRange", 100.0))


def _rotation(placed: Floats) -> Floats:
    """The rotation (3, 3) of a column-vector pose with a scale."""
    from graph.sim.transforms import rigid_part

    return rigid_part(placed)[:3, :3]


def _cast(app: App, origins: Floats, directions: Floats, rays: _Rays) -> tuple[Floats, Floats, list[str]]:
    """Depths (n,) [stage units], normals (n, 3) and paths of the hit prims; rays start at the minimum range."""
    import numpy as np

    from sensors.raycast.ranged import cast_ranged
    from sensors.raycast.rays import NO_SURFACE
    from sensors.raycast.shared import cast_world

    count, unit = len(origins), float(app.meters_per_unit)
    if not count:
        return np.zeros(0), np.zeros((0, 3)), []
    world = cast_world(app)
    ranges = rays.nearest * unit, (rays.farthest - rays.nearest) * unit
    hits = cast_ranged(world, origins * unit, directions, ranges, normals=True)
    depths = hits.distance.astype(float) / unit + rays.nearest
    found = depths <= rays.farthest
    surfaces = hits.surfaces()
    paths = [
        world.surfaces[index].path if hit and index != NO_SURFACE else ""
        for index, hit in zip(surfaces.tolist(), found.tolist(), strict=True)
    ]
    normals = np.where(found[:, None], np.zeros((count, 3)) if hits.normals is None else hits.normals, 0.0)
    return np.where(found, depths, rays.farthest), normals, paths
