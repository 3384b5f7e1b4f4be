"""Where cameras are, and what they look at.

The point that a camera looks at is the attribute omni:kit:centerOfInterest of its prim, in the camera's own axes, where
the editor of Omniverse keeps it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.data.stage_prims import find_prim, path_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

INTEREST = "omni:kit:centerOfInterest"
CAMERA = {
    "prim": Attribute("target", "the camera, unless usePath is set", optional=True),
    "primPath": Attribute("token", "path of the camera where usePath is set", default="", optional=True, role="prim"),
    "usePath": Attribute("bool", "whether primPath names the camera instead of the input prim", default=True),
}
EXEC_OUT = Attribute("execution", "follows once it is done")


@node_type(
    "omni.graph.ui_nodes.GetCameraPosition",
    version=2,
    volatile=True,
    inputs=CAMERA,
    outputs={"position": Attribute("pointd[3]", "where the camera is in the world", unit="stage units")},
)
def get_camera_position(db: Database) -> bool:
    """Give the place of a camera."""
    path, prim = _camera(db)
    if prim is None:
        return False
    db.outputs.position = db.app.fabric.world_matrix(path)[:3, 3].tolist()
    return True


@node_type(
    "omni.graph.ui_nodes.GetCameraTarget",
    version=2,
    volatile=True,
    inputs=CAMERA,
    outputs={"target": Attribute("pointd[3]", "the point in the world that it looks at", unit="stage units")},
)
def get_camera_target(db: Database) -> bool:
    """Give the point that a camera looks at: its centre of interest, which SetCameraTarget and the editor author."""
    path, prim = _camera(db)
    if prim is None:
        return False
    interest = _interest(prim)
    if interest is None:
        advice = "set it, or let SetCameraTarget turn the camera to a point first"
        db.warn("camera-target-missing", f"{path} has no {INTEREST}; {advice}")
        return False
    world = db.app.fabric.world_matrix(path)
    db.outputs.target = (world[:3, :3] @ interest + world[:3, 3]).tolist()
    return True


@node_type(
    "omni.graph.ui_nodes.SetCameraPosition",
    version=2,
    inputs={
        "execIn": Attribute("execution", "moves the camera"),
        "position": Attribute("pointd[3]", "where the camera is to be", default=[0, 0, 0], unit="stage units"),
        "rotate": Attribute(
            "bool", "whether it turns, to look at the same point; if not, it keeps its direction", default=True
        ),
        **CAMERA,
    },
    outputs={"execOut": EXEC_OUT},
)
def set_camera_position(db: Database) -> bool:
    """Move a camera. It goes on looking at its centre of interest, or at its parent's origin before it has one."""
    import numpy as np

    path, prim = _camera(db)
    if prim is None:
        return False
    world, interest = db.app.fabric.world_matrix(path), _interest(prim)
    place = np.asarray(db.inputs.position, float)
    target = _parent(db, prim)[:3, 3] if interest is None else world[:3, :3] @ interest + world[:3, 3]
    if db.inputs.rotate:
        _aim(db, prim, place, target, f"position is the point that {path} looks at")
    else:
        _place(db, prim, _rotation(world), place, target + place - world[:3, 3])
    db.fire("execOut")
    return True


@node_type(
    "omni.graph.ui_nodes.SetCameraTarget",
    version=1,
    inputs={
        "execIn": Attribute("execution", "turns or moves the camera"),
        "rotate": Attribute(
            "bool", "whether the camera turns where it is; if not, it moves and keeps its direction", default=True
        ),
        "target": Attribute("pointd[3]", "the point in the world to look at", default=[0, 0, 0], unit="stage units"),
        **CAMERA,
    },
    outputs={"execOut": EXEC_OUT},
)
def set_camera_target(db: Database) -> bool:
    """Make a camera look at a point: turn it upright to the point, or move it so that the point is straight ahead.

    Moved, it keeps the distance of its centre of interest; before it has one, that of the point.
    """
    import numpy as np

    path, prim = _camera(db)
    if prim is None:
        return False
    world, target = db.app.fabric.world_matrix(path), np.asarray(db.inputs.target, float)
    if db.inputs.rotate:
        _aim(db, prim, world[:3, 3], target, f"target is where {path} is")
    else:
        rotation, interest = _rotation(world), _interest(prim)
        away = target - world[:3, 3] if interest is None else world[:3, :3] @ interest
        place = target + rotation[:, 2] * float(np.linalg.norm(away))
        _place(db, prim, rotation, place, target)
    db.fire("execOut")
    return True


def _camera(db: Database) -> tuple[str, Any]:
    """Path and prim of the camera that the inputs name; None, with a warning, if it does not exist."""
    path = path_of(db)
    return path, find_prim(db, path)


def _interest(prim: Any) -> Matrix | None:
    """(3,) the point that the camera looks at, in its own axes; None where nothing is authored."""
    import numpy as np

    attribute = prim.GetAttribute(INTEREST)
    value = attribute.Get() if attribute else None
    return None if value is None else np.asarray(value, float)


def _rotation(world: Matrix) -> Matrix:
    from graph.sim import transforms

    return transforms.rigid_part(world)[:3, :3]


def _aim(db: Database, prim: Any, place: Matrix, target: Matrix, problem: str) -> None:
    """Puts a camera at a place, upright, and turns it to a point. Fails the node if both are the same."""
    import numpy as np

    from graph.sim.usd import UsdGeom

    away = target - place
    distance = float(np.linalg.norm(away))
    if distance == 0:
        db.fail(f"input {problem}; give it another point")
    _place(db, prim, looking(away / distance, str(UsdGeom.GetStageUpAxis(db.app.stage))), place, target)


def _place(db: Database, prim: Any, rotation: Matrix, place: Matrix, target: Matrix) -> None:
    """Writes a camera's pose in the world, and its centre of interest. Fails the node unless both are finite."""
    import numpy as np

    from graph.sim import transforms
    from graph.sim.scene.prim_attributes import set_transform
    from graph.sim.usd import EARLIEST, Gf, Sdf, UsdGeom

    if not np.isfinite([place, target]).all():
        db.fail(f"{prim.GetPath()} would be at {place.tolist()} and look at {target.tolist()}; give finite numbers")
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = rotation, place
    parent = _parent(db, prim)
    local = transforms.rigid_part(np.linalg.inv(parent) @ placed)
    try:
        set_transform(prim, translate=local[:3, 3].tolist(), orient=transforms.quaternion(local[:3, :3]).tolist())
    except ValueError as error:
        db.fail(f"{prim.GetPath()}: {error}")
    world = parent @ transforms.from_usd(UsdGeom.Xformable(prim).GetLocalTransformation(EARLIEST))
    interest = np.linalg.solve(world[:3, :3], target - world[:3, 3])
    attribute = prim.CreateAttribute(INTEREST, Sdf.ValueTypeNames.Vector3d, True, Sdf.VariabilityUniform)
    attribute.Set(Gf.Vec3d(*interest.tolist()))


def _parent(db: Database, prim: Any) -> Matrix:
    """(4, 4) parent to world."""
    import numpy as np

    parent = prim.GetParent()
    if not parent or parent.IsPseudoRoot():
        return np.eye(4)
    found: Matrix = db.app.fabric.world_matrix(str(parent.GetPath()))
    return found


def looking(forward: Any, up_axis: str) -> Any:
    """Rotation (3, 3), columns right, up, back, of an upright camera that looks along `forward` (unit)."""
    import numpy as np

    up = np.array([0.0, 0.0, 1.0] if up_axis == "Z" else [0.0, 1.0, 0.0])
    if abs(forward @ up) > 1 - 1e-12:  # straight up or down: any upright direction will do
        up = np.array([0.0, 1.0, 0.0] if up_axis == "Z" else [0.0, 0.0, -1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(right, forward), -forward])
