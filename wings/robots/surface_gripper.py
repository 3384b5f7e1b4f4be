"""Suction grippers: open, close, toggle."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type


@node_type(
    "isaacsim.robot.surface_gripper.SurfaceGripper",
    version=3,
    needs=(("SurfaceGripper",),),
    inputs={
        "enabled": Attribute("bool", "if not, the node does nothing", default=True),
        "SurfaceGripper": Attribute("target", "an IsaacSurfaceGripper prim"),
        "Toggle": Attribute("execution", "opens a gripper that is closed or closing, closes one that is open"),
        "Open": Attribute("execution", "lets go"),
        "Close": Attribute("execution", "grips what is before its points of attachment, as soon as something is"),
    },
)
def surface_gripper(db: Database) -> bool:
    """Command a surface gripper: its attachment points hold what a ray of length isaac:maxGripDistance hits.

    They release it above isaac:coaxialForceLimit and :shearForceLimit, and stop trying after isaac:retryInterval.
    """
    inputs, app = db.inputs, db.app
    if not inputs.enabled or not inputs.SurfaceGripper or app.timeline.is_stopped():
        return False
    path = str(inputs.SurfaceGripper[0])
    if app.physics is None:
        db.lack(f"{path} is not a gripper: nothing on the stage can move")
    gripper = app.physics.gripper(path)
    if db.triggered("Close") or (db.triggered("Toggle") and gripper.status == "Open"):
        gripper.close()
    else:
        gripper.open()
    return True
