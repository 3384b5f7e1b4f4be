"""The state of the joints of an articulated robot: positions, speeds, efforts, reactions."""

from __future__ import annotations

from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

from .articulation import joint_selection, robot_at


@dataclass(slots=True)
class _Robot:
    path: str = ""
    articulation: Any = None


def robot_of(db: Database) -> Any:
    """The articulation that robotPath, else targetPrim names, kept in `db.memory`.

    Fails the node if it does not exist.
    """
    inputs, memory = db.inputs, db.memory
    path = inputs.robotPath or (inputs.targetPrim[0] if inputs.targetPrim else "")
    if not path:
        db.lack("no robot; set targetPrim or robotPath to the root prim of an articulation")
    if path != memory.path:
        memory.articulation, memory.path = robot_at(db, path), path
    return memory.articulation


@node_type(
    "isaacsim.core.nodes.IsaacArticulationState",
    version=1,
    needs=(("targetPrim", "robotPath"),),
    inputs={
        "execIn": Attribute("execution", "reads the joints"),
        "targetPrim": Attribute("target", "the articulation's root prim; used where robotPath is empty", optional=True),
        "robotPath": Attribute("string", "path of the articulation's root prim; wins over targetPrim", role="prim"),
        "jointNames": Attribute("token[]", "the joints to read by name; wins over jointIndices, empty means by index"),
        "jointIndices": Attribute("int[]", "the joints to read by index; empty means all joints"),
    },
    outputs={
        "jointPositions": Attribute("double[]", "joint positions", unit="rad or stage units"),
        "jointVelocities": Attribute("double[]", "joint speeds", unit="rad/s or stage units/s"),
        "measuredJointEfforts": Attribute(
            "double[]", "efforts along the joints' axes: drives, applied efforts and limits", unit="N m or N"
        ),
        "measuredJointForces": Attribute(
            "double[3][]", "force that each joint passes on to its child link, in the joint's frame there", unit="N"
        ),
        "measuredJointTorques": Attribute(
            "double[3][]", "torque that each joint passes on to its child link, about the joint's frame", unit="N m"
        ),
        "jointNames": Attribute("token[]", "names of the joints read"),
    },
    memory=_Robot,
)
def articulation_state(db: Database) -> bool:
    """Read positions, speeds, efforts and joint reactions; the latter two are those of the last physics step."""
    if db.app.timeline.is_stopped():
        return False
    articulation = robot_of(db)
    joints = list(joint_selection(db, articulation))
    outputs = db.outputs
    outputs.jointNames = [articulation.joint_names[joint] for joint in joints]
    outputs.jointPositions = articulation.positions[joints]
    outputs.jointVelocities = articulation.velocities[joints]
    if db.wanted("measuredJointEfforts"):
        outputs.measuredJointEfforts = articulation.efforts[joints]
    if db.wanted("measuredJointForces") or db.wanted("measuredJointTorques"):
        reactions = articulation.reactions[joints]
        outputs.measuredJointForces, outputs.measuredJointTorques = reactions[:, :3], reactions[:, 3:]
    return True
