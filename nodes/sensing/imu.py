"""Inertial measurement units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim import settings as keys
from graph.sim.scene.prim_paths import prim_at

EVERY_STEP = "readings are always of the newest physics step"


@dataclass(slots=True)
class _Imu:
    path: str = ""
    unit: Any = None


def _release(db: Database) -> None:
    if db.memory.unit is not None:
        db.memory.unit.close()
        db.memory.unit = None


def sensor_prim(db: Database, targets: Any, name: str, kind: str = "") -> Any:
    """The prim that a target input names. Fails the node unless it is exactly one prim, on the stage.

    `kind`: the type of sensors that the node reads; other prims do only while settings let bodies stand for them.
    """
    if len(targets) != 1:
        db.lack(f"input {name} names {len(targets)} prims; give it the path of one prim")
    prim = prim_at(db.app.stage, targets[0])
    if not prim:
        db.fail(f"there is no prim {targets[0]} on the stage; correct the path")
    if kind and prim.GetTypeName() != kind and not db.app.settings.get(keys.SENSOR_NODES_TAKE_BODIES):
        db.fail(f"{targets[0]} is not an {kind}; give {name} the path of one")
    return prim


def check_body(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A prim that a target input of the file names and that is on no rigid body."""
    from sensors.inertial import may_be_on_body

    for name in {"imuPrim", "csPrim"}.intersection(node.given):
        for path in map(str, getattr(node.db.inputs, name)):
            prim = prim_at(node.stage, path)
            if prim and not may_be_on_body(prim):
                yield name, f"{path} is on no rigid body; put it on one, or below"


@node_type(
    "isaacsim.sensors.physics.IsaacReadIMU",
    version=1,
    check=check_body,
    needs=(("imuPrim",),),
    inputs={
        "execIn": Attribute("execution", "reads the sensor"),
        "imuPrim": Attribute("target", "an IsaacImuSensor, or any other prim, on a rigid body or below one"),
        "useLatestData": Attribute("bool", "has no effect", default=False, deprecated=EVERY_STEP),
        "readGravity": Attribute("bool", "feel gravity, as a real sensor does: 9.81 m/s^2 up at rest", default=True),
    },
    outputs={
        "execOut": Attribute("execution", "follows when there is a reading"),
        "sensorTime": Attribute("float", "simulation time of the reading", default=0, unit="s"),
        "linAcc": Attribute("vectord[3]", "acceleration along the sensor's axes", default=[0.0] * 3, unit="m/s^2"),
        "angVel": Attribute("vectord[3]", "turn rate about the sensor's axes", default=[0.0] * 3, unit="rad/s"),
        "orientation": Attribute(
            "quatd[4]", "orientation in the world, quaternion x, y, z, w", default=[0.0, 0.0, 0.0, 1.0]
        ),
    },
    memory=_Imu,
    release=_release,
)
def read_imu(db: Database) -> None:
    """Read an IMU: the change of its velocity over the newest physics step, averaged over its filter widths.

    The first compute after play starts the sensor; the first reading is that of the next physics step. Before it, and
    while the prim's `enabled` is false, the outputs are zero and execOut does not fire.
    """
    from sensors.inertial import InertialUnit, attribute_of, widths_of

    inputs, outputs, memory, app = db.inputs, db.outputs, db.memory, db.app
    prim = sensor_prim(db, inputs.imuPrim, "imuPrim", "IsaacImuSensor")
    path = str(prim.GetPath())
    if path != memory.path or memory.unit is None:
        _release(db)
        if not app.timeline.is_stopped():
            memory.path, memory.unit = path, InertialUnit(app.world, path, widths_of(prim))
    reading = memory.unit.reading(inputs.readGravity) if memory.unit and attribute_of(prim, "enabled", True) else None
    if reading is None:
        outputs.linAcc = outputs.angVel = [0.0, 0.0, 0.0]
        outputs.orientation, outputs.sensorTime = [0.0, 0.0, 0.0, 1.0], 0.0
        return
    outputs.linAcc, outputs.angVel = reading.acceleration, reading.angular_velocity
    outputs.orientation, outputs.sensorTime = reading.orientation, reading.time
    db.fire("execOut")
