"""Joint sensors: the effort of one joint, the state of all joints of a robot."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type

from .imu import EVERY_STEP, sensor_prim

ROTATION, TRANSLATION = 0, 1
"""Kinds of joints in jointDofTypes."""


def _mechanism(db: Database, prim: Any) -> Any:
    if db.app.physics is None:
        db.fail(f"{prim.GetPath()} has no joints that move: nothing on the stage can")
    return db.app.physics.articulation(str(prim.GetPath()))


@node_type(
    "isaacsim.sensors.physics.IsaacReadEffortSensor",
    version=1,
    needs=(("prim",),),
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "prim": Attribute("target", "a revolute or prismatic joint"),
        "useLatestData": Attribute("bool", "has no effect", default=False, deprecated=EVERY_STEP),
        "enabled": Attribute("bool", "has no effect", default=True, deprecated="gate execIn instead"),
        "sensorPeriod": Attribute("float", "has no effect", default=0, unit="s", deprecated=EVERY_STEP),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0, unit="s"),
        "value": Attribute(
            "float", "effort along the joint: drive, applied effort, limit", default=0.0, unit="N m or N"
        ),
    },
)
def read_effort_sensor(db: Database) -> None:
    """Read the effort of a joint in the newest physics step."""
    app, outputs = db.app, db.outputs
    prim = sensor_prim(db, db.inputs.prim, "prim")
    outputs.value = outputs.sensorTime = 0.0
    if app.timeline.is_stopped():
        return
    articulation = _mechanism(db, prim)
    path = str(prim.GetPath())
    if path not in articulation.joint_paths:
        db.fail(f"{path} is not a joint; give prim one of {', '.join(articulation.joint_paths)}")
    outputs.value = float(articulation.efforts[articulation.joint_paths.index(path)])
    outputs.sensorTime = float(app.simulation.time)
    db.fire("execOut")


@node_type(
    "isaacsim.sensors.physics.IsaacReadJointState",
    version=1,
    needs=(("prim",),),
    inputs={
        "execIn": Attribute("execution", "reads the joints"),
        "prim": Attribute("target", "the root of an articulation"),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0, unit="s"),
        "jointNames": Attribute("token[]", "names of the joints"),
        "jointPositions": Attribute("double[]", "joint positions", unit="rad or stage units"),
        "jointVelocities": Attribute("double[]", "joint speeds", unit="rad/s or stage units/s"),
        "jointEfforts": Attribute("double[]", "efforts along the joints", unit="N m or N"),
        "jointDofTypes": Attribute("uchar[]", f"{ROTATION} for joints that turn, {TRANSLATION} for those that slide"),
        "stageMetersPerUnit": Attribute("float", "metres in a unit of the stage", default=0.0, unit="m"),
    },
)
def read_joint_state(db: Database) -> None:
    """Read all joints of a robot, at the newest physics step."""
    app, outputs = db.app, db.outputs
    prim = sensor_prim(db, db.inputs.prim, "prim")
    if app.timeline.is_stopped():
        return
    articulation = _mechanism(db, prim)
    outputs.jointNames = list(articulation.joint_names)
    outputs.jointPositions, outputs.jointVelocities = articulation.positions, articulation.velocities
    if db.wanted("jointEfforts"):
        outputs.jointEfforts = articulation.efforts
    outputs.jointDofTypes = [TRANSLATION if slides else ROTATION for slides in articulation.linear]
    outputs.stageMetersPerUnit, outputs.sensorTime = app.meters_per_unit, float(app.simulation.time)
    db.fire("execOut")
