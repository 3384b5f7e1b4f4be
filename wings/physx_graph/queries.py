"""Scene queries: which colliders a ray hits, and which overlap a box or a sphere, at the newest physics step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type

if TYPE_CHECKING:
    from graph.sim.physics.protocol import PhysicsEngine, RayHit
    from graph.sim.transforms import Floats

POINT, VECTOR, LENGTH = ("pointd[3]", "pointf[3]"), ("vectord[3]", "vectorf[3]"), ("double", "float")
EXEC_IN = Attribute("execution", "asks the physics at its newest step")
EXEC_OUT = Attribute("execution", "follows when there is an answer")
SWEEP = {
    "execIn": EXEC_IN,
    "origin": Attribute(POINT, "where the centre begins in the world", unit="stage units"),
    "direction": Attribute(VECTOR, "where it goes, of any length but 0"),
    "radius": Attribute(LENGTH, "radius of the sphere", unit="stage units"),
    "sweepRange": Attribute(
        LENGTH, "how far it goes; unset or negative: without end", optional=True, unit="stage units"
    ),
    "bothSides": Attribute("bool", "has no effect: colliders are solid here", default=False),
}
RAY = {
    "execIn": EXEC_IN,
    "origin": Attribute(POINT, "where the ray begins in the world", unit="stage units"),
    "direction": Attribute(VECTOR, "where it goes, of any length but 0"),
    "raycastRange": Attribute(
        LENGTH, "how far it goes; unset or negative: without end", optional=True, unit="stage units"
    ),
    "bothSides": Attribute("bool", "has no effect: colliders are solid here", default=False),
}
BOX = {
    "execIn": EXEC_IN,
    "position": Attribute(POINT, "centre of the box in the world", unit="stage units"),
    "dimensions": Attribute(("double[3]", "float[3]"), "lengths of its sides", unit="stage units"),
    "rotation": Attribute(("double[3]", "float[3]"), "its turns about x, y, z, in this order", unit="deg"),
}
BALL = {
    "execIn": EXEC_IN,
    "position": Attribute(POINT, "centre of the sphere in the world", unit="stage units"),
    "radius": Attribute(LENGTH, "its radius", unit="stage units"),
}
COLLIDERS = {
    "execOut": EXEC_OUT,
    "colliderPrimPaths": Attribute("token[]", "the colliders", default=[]),
    "bodyPrimPaths": Attribute("token[]", "the body of each; empty for a static one", default=[]),
}
CLOSEST = {
    "execOut": EXEC_OUT,
    "hit": Attribute("bool", "whether a collider is hit", default=False),
    "colliderPrimPath": Attribute("token", "the nearest collider; empty without a hit"),
    "bodyPrimPath": Attribute("token", "its body; empty for a static one"),
    "position": Attribute("pointf[3]", "where it is hit in the world", unit="stage units"),
    "normal": Attribute("normalf[3]", "the surface normal there"),
    "distance": Attribute("float", "how far that is from the origin", unit="stage units"),
    "faceIndex": Attribute("int", "always -1: faces are not numbered here"),
    "materialPath": Attribute("token", "always empty: use the collider's material"),
}
EVERY = {
    **COLLIDERS,
    "positions": Attribute("pointf[3][]", "where each is hit first", default=[], unit="stage units"),
    "normals": Attribute("normalf[3][]", "the surface normals there", default=[]),
    "distances": Attribute("float[]", "how far these are from the origin", default=[], unit="stage units"),
    "faceIndexes": Attribute("int[]", "always -1: faces are not numbered here", default=[]),
    "materialPaths": Attribute("token[]", "always empty: use the colliders' materials", default=[]),
}
ANY = {"execOut": EXEC_OUT, "hit": Attribute("bool", "whether any collider is hit", default=False)}
OVERLAP = {"execOut": EXEC_OUT, "overlap": Attribute("bool", "whether any collider overlaps it", default=False)}


@node_type(
    "omni.physx.graph.SceneQueryRaycastClosest",
    version=1,
    volatile=True,
    inputs=RAY,
    outputs=CLOSEST,
)
def raycast_closest(db: Database) -> bool:
    """Find the nearest collider on a ray. From inside a collider it is hit at distance 0."""
    return _give_nearest(db, _ray(db))


@node_type(
    "omni.physx.graph.SceneQueryRaycastAny",
    version=1,
    volatile=True,
    inputs=RAY,
    outputs=ANY,
)
def raycast_any(db: Database) -> bool:
    """Tell whether a ray hits any collider."""
    return _give_any(db, _ray(db))


@node_type(
    "omni.physx.graph.SceneQueryRaycastAll",
    version=1,
    volatile=True,
    inputs={**RAY, "sortByDistance": Attribute("bool", "has no effect: they always are sorted", default=False)},
    outputs=EVERY,
)
def raycast_all(db: Database) -> bool:
    """List every collider on a ray, the nearest first."""
    return _give_all(db, _ray(db))


@node_type("omni.physx.graph.SceneQuerySweepSphereClosest", version=1, volatile=True, inputs=SWEEP, outputs=CLOSEST)
def sweep_closest(db: Database) -> bool:
    """Find the first collider that a moving sphere meets; distance is how far its centre goes until then."""
    return _give_nearest(db, _swept(db))


@node_type("omni.physx.graph.SceneQuerySweepSphereAny", version=1, volatile=True, inputs=SWEEP, outputs=ANY)
def sweep_any(db: Database) -> bool:
    """Tell whether a moving sphere meets any collider."""
    return _give_any(db, _swept(db))


@node_type(
    "omni.physx.graph.SceneQuerySweepSphereAll",
    version=2,
    volatile=True,
    inputs={**SWEEP, "sortByDistance": Attribute("bool", "has no effect: they always are sorted", default=False)},
    outputs=EVERY,
)
def sweep_all(db: Database) -> bool:
    """List every collider that a moving sphere meets, the first one first."""
    return _give_all(db, _swept(db))


@node_type("omni.physx.graph.SceneQueryOverlapBoxAll", version=1, volatile=True, inputs=BOX, outputs=COLLIDERS)
def overlap_box_all(db: Database) -> bool:
    """List the colliders that overlap a box; what only touches it is outside."""
    return _list(db, _in_box(db))


@node_type("omni.physx.graph.SceneQueryOverlapBoxAny", version=1, volatile=True, inputs=BOX, outputs=OVERLAP)
def overlap_box_any(db: Database) -> bool:
    """Tell whether any collider overlaps a box."""
    return _tell(db, _in_box(db))


@node_type("omni.physx.graph.SceneQueryOverlapSphereAll", version=1, volatile=True, inputs=BALL, outputs=COLLIDERS)
def overlap_sphere_all(db: Database) -> bool:
    """List the colliders that overlap a sphere; what only touches it is outside."""
    return _list(db, _in_sphere(db))


@node_type("omni.physx.graph.SceneQueryOverlapSphereAny", version=1, volatile=True, inputs=BALL, outputs=OVERLAP)
def overlap_sphere_any(db: Database) -> bool:
    """Tell whether any collider overlaps a sphere."""
    return _tell(db, _in_sphere(db))


def _engine(db: Database) -> PhysicsEngine | None:
    """The physics; None while the timeline is stopped, and in a world without any."""
    return None if db.app.timeline.is_stopped() else db.app.physics


def _ray(db: Database) -> Sequence[RayHit] | None:
    """What the node's ray hits; None without physics."""
    engine = _engine(db)
    return None if engine is None else engine.ray_hits(*_way(db, "raycastRange"))


def _swept(db: Database) -> Sequence[RayHit] | None:
    """What the node's moving sphere hits; None without physics."""
    engine = _engine(db)
    if engine is None:
        return None
    origin, direction, reach = _way(db, "sweepRange")
    return engine.sphere_hits(origin, direction, _radius(db), reach)


def _way(db: Database, name: str) -> tuple[Floats, Floats, float]:
    """Origin [m], direction of length 1 and range [m]. Fails the node for a direction without a length."""
    import numpy as np

    unit = float(db.app.meters_per_unit)
    direction = np.asarray(db.inputs.direction, np.float64)
    length = float(np.linalg.norm(direction))
    if not (math.isfinite(length) and length > 0):
        db.fail(f"input direction is {direction.tolist()}; give it a length")
    most = _number(db, name)
    reach = math.inf if most is None or most < 0 else most * unit
    return _vector(db, "origin") * unit, direction / length, reach


def _radius(db: Database) -> float:
    """The radius [m]. Fails the node unless it is above 0."""
    radius = _number(db, "radius")
    if radius is None or not 0 < radius < math.inf:
        db.fail(f"input radius is {radius}; give it a length above 0")
    return float(radius or 0) * float(db.app.meters_per_unit)


def _give_nearest(db: Database, found: Sequence[RayHit] | None) -> bool:
    if found is None:
        return False
    outputs, unit = db.outputs, float(db.app.meters_per_unit)
    nearest = found[0] if found else None
    outputs.hit, outputs.faceIndex, outputs.materialPath = nearest is not None, -1, ""
    outputs.colliderPrimPath = nearest.collider if nearest else ""
    outputs.bodyPrimPath = nearest.body if nearest else ""
    outputs.position = nearest.position / unit if nearest else (0.0, 0.0, 0.0)
    outputs.normal = nearest.normal if nearest else (0.0, 0.0, 0.0)
    outputs.distance = nearest.distance / unit if nearest else 0.0
    db.fire("execOut")
    return True


def _give_any(db: Database, found: Sequence[RayHit] | None) -> bool:
    if found is None:
        return False
    db.outputs.hit = bool(found)
    db.fire("execOut")
    return True


def _give_all(db: Database, found: Sequence[RayHit] | None) -> bool:
    import numpy as np

    if found is None:
        return False
    outputs, unit = db.outputs, float(db.app.meters_per_unit)
    outputs.colliderPrimPaths = [hit.collider for hit in found]
    outputs.bodyPrimPaths = [hit.body for hit in found]
    outputs.positions = np.array([hit.position / unit for hit in found]).reshape(-1, 3)
    outputs.normals = np.array([hit.normal for hit in found]).reshape(-1, 3)
    outputs.distances = np.array([hit.distance / unit for hit in found])
    outputs.faceIndexes, outputs.materialPaths = [-1] * len(found), [""] * len(found)
    db.fire("execOut")
    return True


def _in_box(db: Database) -> list[tuple[str, str]] | None:
    import numpy as np

    from graph.sim.usd import Gf

    engine = _engine(db)
    if engine is None:
        return None
    unit = float(db.app.meters_per_unit)
    sizes = _vector(db, "dimensions")
    if (sizes <= 0).any():
        db.fail(f"input dimensions is {sizes.tolist()}; give three lengths above 0")
    turn = Gf.Matrix3d(1.0)
    for axis, angle in zip(np.eye(3).tolist(), _vector(db, "rotation").tolist(), strict=True):
        turn = turn * Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*axis), angle))
    pose = np.eye(4)
    pose[:3, :3] = np.array(turn).T  # USD has row vectors
    pose[:3, 3] = _vector(db, "position") * unit
    return engine.overlapping(pose, sizes * unit / 2)


def _in_sphere(db: Database) -> list[tuple[str, str]] | None:
    engine = _engine(db)
    if engine is None:
        return None
    return engine.overlapping_sphere(_vector(db, "position") * float(db.app.meters_per_unit), _radius(db))


def _vector(db: Database, name: str) -> Floats:
    """A finite vector. Fails the node for another."""
    import numpy as np

    value = np.asarray(getattr(db.inputs, name), np.float64)
    if not np.isfinite(value).all():
        db.fail(f"input {name} is {value.tolist()}; give finite numbers")
    return value


def _number(db: Database, name: str) -> float | None:
    value: Any = getattr(db.inputs, name)
    return None if value is None else float(value)


def _list(db: Database, found: list[tuple[str, str]] | None) -> bool:
    if found is None:
        return False
    db.outputs.colliderPrimPaths = [collider for collider, _ in found]
    db.outputs.bodyPrimPaths = [body for _, body in found]
    db.fire("execOut")
    return True


def _tell(db: Database, found: list[tuple[str, str]] | None) -> bool:
    if found is None:
        return False
    db.outputs.overlap = bool(found)
    db.fire("execOut")
    return True
