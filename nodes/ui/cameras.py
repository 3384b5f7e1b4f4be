"""The camera of a viewport, and the direction of a camera."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type
from nodes.data.stage_prims import find_prim, only_target


@node_type(
    "omni.graph.ui_nodes.GetActiveViewportCamera",
    version=1,
    volatile=True,
    inputs={"viewport": Attribute("token", "name of the viewport; empty is the default one", default="")},
    outputs={"camera": Attribute("token", "path of its camera; empty before it has one")},
)
def get_active_viewport_camera(db: Database) -> bool:
    """Give the camera of a viewport; viewports are render products without windows."""
    from nodes.isaac.viewports import DEFAULT, viewports_of

    name = db.inputs.viewport or DEFAULT
    viewport = viewports_of(db.app).get(name)
    if viewport is None:
        db.warn("viewport-missing", f'there is no viewport "{name}"; make it with IsaacCreateViewport')
        return False
    db.outputs.camera = viewport.camera
    return True


@node_type(
    "omni.graph.ui_nodes.SetCameraTarget",
    version=1,
    inputs={
        "execIn": Attribute("execution", "turns or moves the camera"),
        "prim": Attribute("target", "the camera, unless usePath is set", optional=True),
        "primPath": Attribute("token", "path of the camera where usePath is set", default="", optional=True),
        "rotate": Attribute(
            "bool", "whether the camera turns where it is; if not, it moves and keeps its direction", default=True
        ),
        "target": Attribute("pointd[3]", "the point in the world to look at", default=[0, 0, 0], unit="stage units"),
        "usePath": Attribute("bool", "whether primPath names the camera instead of the input prim", default=True),
    },
    outputs={"execOut": Attribute("execution", "follows once it is done")},
)
def set_camera_target(db: Database) -> bool:
    """Make a camera look at a point: turn it upright to the point, or move it so that the point is straight ahead."""
    import numpy as np

    from graph.sim import transforms
    from graph.sim.scene.prim_transforms import set_transform
    from graph.sim.usd import UsdGeom

    inputs, app = db.inputs, db.app
    path = inputs.primPath if inputs.usePath else only_target(db, "prim", inputs.prim)
    prim = find_prim(db, str(path))
    if prim is None:
        return False
    world = app.fabric.world_matrix(str(path))
    away = np.asarray(inputs.target, float) - world[:3, 3]
    distance = float(np.linalg.norm(away))
    placed = transforms.rigid_part(world)
    if inputs.rotate:
        if distance == 0:
            db.fail(f"input target is where {path} is; give it another point")
        placed[:3, :3] = looking(away / distance, str(UsdGeom.GetStageUpAxis(app.stage)))
    else:
        placed[:3, 3] = np.asarray(inputs.target, float) + placed[:3, 2] * distance
    parent = prim.GetParent()
    if parent and not parent.IsPseudoRoot():
        placed = np.linalg.inv(app.fabric.world_matrix(str(parent.GetPath()))) @ placed
    local = transforms.rigid_part(placed)
    orient = transforms.quaternion(local[:3, :3]).tolist()
    try:
        set_transform(prim, translate=local[:3, 3].tolist(), orient=orient)
    except ValueError as error:
        db.fail(f"{path}: {error}")
    db.fire("execOut")
    return True


def looking(forward: Any, up_axis: str) -> Any:
    """Rotation (3, 3), columns right, up, back, of an upright camera that looks along `forward` (unit)."""
    import numpy as np

    up = np.array([0.0, 0.0, 1.0] if up_axis == "Z" else [0.0, 1.0, 0.0])
    if abs(forward @ up) > 1 - 1e-12:  # straight up or down: any upright direction will do
        up = np.array([0.0, 1.0, 0.0] if up_axis == "Z" else [0.0, 0.0, -1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(right, forward), -forward])
