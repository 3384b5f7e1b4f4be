"""Two-state grippers: fingers that move to their open or closed positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import UNSET, Attribute, Database, node_type
from nodes.isaac.articulation import robot_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

UNIT = "rad or stage units"


@dataclass(slots=True)
class _Gripper:
    """The robot and its finger joints, their open and closed positions, their steps, and the target (None: at rest)."""

    articulation: Any = None
    joints: Any = ()
    opened: Any = None
    closed: Any = None
    steps: Any = None
    position: Any = None
    aim: Any = None


def _ends(doc: str) -> Attribute:
    text = f"{doc} of each joint, or one for all; none: the joints' limits; read at the first compute after play"
    return Attribute("double[]", text, default=UNSET, optional=True, unit=UNIT)


@node_type(
    "isaacsim.robot.manipulators.IsaacGripperController",
    version=1,
    needs=(("articulationRootPrim",),),
    inputs={
        "execIn": Attribute("execution", "moves on the way it is on"),
        "open": Attribute("execution", "starts to open, and moves"),
        "close": Attribute("execution", "starts to close, and moves"),
        "stop": Attribute("execution", "stays where the fingers are"),
        "articulationRootPrim": Attribute("target", "the robot's articulation", optional=True),
        "gripperPrim": Attribute("target", "the gripper; not needed", optional=True),
        "jointNames": Attribute("token[]", "the finger joints"),
        "openPosition": _ends("open position"),
        "closePosition": _ends("closed position"),
        "gripperSpeed": Attribute(
            "double[]", "how far each joint, or all, moves in a compute", unit=f"{UNIT} per compute"
        ),
    },
    outputs={
        "jointNames": Attribute("token[]", "the finger joints"),
        "positionCommands": Attribute("double[]", "where the fingers are to go in this compute", unit=UNIT),
    },
    memory=_Gripper,
)
def gripper_controller(db: Database) -> bool:
    """Move the fingers step by step to their open or closed positions.

    If positionCommands is not connected the commands are sent to the robot's drives; else they are only output.
    """
    import numpy as np

    inputs, memory = db.inputs, db.memory
    if db.app.timeline.is_stopped():
        return False
    if memory.articulation is None:
        _read(db)
    if db.triggered("open"):
        memory.aim = memory.opened
    elif db.triggered("close"):
        memory.aim = memory.closed
    elif db.triggered("stop"):
        memory.position, memory.aim = memory.articulation.positions[memory.joints], None
        _send(db)
    if memory.aim is not None:
        memory.position = memory.position + np.clip(memory.aim - memory.position, -memory.steps, memory.steps)
        _send(db)
        if (memory.position == memory.aim).all():
            memory.aim = None
    db.outputs.jointNames, db.outputs.positionCommands = list(inputs.jointNames), memory.position
    return True


def _send(db: Database) -> None:
    memory = db.memory
    if not db.consumed("positionCommands"):
        memory.articulation.set_targets(positions=memory.position, joints=memory.joints)


def _read(db: Database) -> None:
    import numpy as np

    inputs, memory = db.inputs, db.memory
    if len(inputs.articulationRootPrim) != 1:
        db.lack(f"articulationRootPrim names {len(inputs.articulationRootPrim)} prims; give it one articulation")
    root = str(inputs.articulationRootPrim[0])
    articulation = robot_at(db, root)
    known = articulation.numbers
    unknown = [name for name in inputs.jointNames if name not in known]
    if unknown or not len(inputs.jointNames):
        what = f"no joint {', '.join(unknown)}" if unknown else "no jointNames"
        db.fail(f"{what}; the robot has {', '.join(articulation.joint_names)}")
    joints = [known[name] for name in inputs.jointNames]
    steps = _per_joint(db, "gripperSpeed", len(joints))
    if steps is None or not (steps > 0).all():
        db.fail("input gripperSpeed must be above 0 for every joint")
    ends = [_per_joint(db, name, len(joints)) for name in ("openPosition", "closePosition")]
    if all(end is None or not end.any() for end in ends):
        limits = articulation.limits[joints]
        if not np.isfinite(limits).all():
            db.fail("openPosition and closePosition are not set, and the joints have no limits to take instead")
        memory.opened, memory.closed = limits[:, 1], limits[:, 0]
    else:
        still = np.zeros(len(joints))
        memory.opened, memory.closed = (still if end is None else end for end in ends)
    memory.joints, memory.steps = joints, steps
    memory.position, memory.articulation = articulation.positions[joints], articulation


def _per_joint(db: Database, name: str, count: int) -> Floats | None:
    """One number per joint; None if the input is empty."""
    import numpy as np

    values = np.array(getattr(db.inputs, name), dtype=np.float64)
    if len(values) not in (0, 1, count):
        db.fail(f"{name} has {len(values)} entries for {count} joints; give one per joint, or one for all")
    return np.broadcast_to(values, (count,)).copy() if len(values) else None
