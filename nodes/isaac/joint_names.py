"""Converts overridden joint names to the names of prims."""

from __future__ import annotations

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.scene.mechanisms import mechanisms_of
from graph.sim.scene.prim_paths import NAME_OVERRIDE, prim_at


@dataclass(slots=True)
class _Names:
    """The robot, and the prim name behind each name override below it; taken at the first compute after play."""

    robot: str = ""
    real: dict[str, str] | None = None


@node_type(
    "isaacsim.core.nodes.IsaacJointNameResolver",
    version=1,
    needs=(("targetPrim", "robotPath"),),
    inputs={
        "execIn": Attribute("execution", "looks the names up"),
        "targetPrim": Attribute("target", "the robot; used where robotPath is empty", optional=True),
        "robotPath": Attribute("string", "path of the robot; wins over targetPrim", role="prim"),
        "jointNames": Attribute("token[]", "joint names, overrides among them"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute"),
        "jointNames": Attribute("token[]", "the joints' prim names; a name that overrides none stays as it is"),
        "robotPath": Attribute("string", "path of the robot"),
    },
    memory=_Names,
)
def joint_name_resolver(db: Database) -> None:
    """Replace each name that a prim below the robot has as isaac:nameOverride by that prim's own name."""
    inputs, memory = db.inputs, db.memory
    if memory.real is None:
        robot = str(inputs.robotPath or (inputs.targetPrim[0] if inputs.targetPrim else ""))
        memory.real, memory.robot = _overrides(db, robot), robot
    outputs, real = db.outputs, memory.real
    outputs.jointNames = [real.get(name, name) for name in inputs.jointNames]
    outputs.robotPath = memory.robot
    db.fire("execOut")


def _overrides(db: Database, robot: str) -> dict[str, str]:
    """Override -> prim name; the first prim wins. Fails the node if there is no articulation at the path."""
    from graph.sim.usd import Usd

    stage = db.app.stage
    prim = prim_at(stage, robot)
    if not prim:
        db.lack(f"there is no prim {robot} on the stage" if robot else "no robot; set targetPrim or robotPath")
    mechanisms = mechanisms_of(stage)
    joints = mechanisms.joints(mechanisms.carriers(robot))
    if not joints:
        db.fail(f"{robot} is not a robot: it has no joints")
    real: dict[str, str] = {}
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    for each in (*map(stage.GetPrimAtPath, joints), *below):
        override = each.GetAttribute(NAME_OVERRIDE).Get() if each.HasAttribute(NAME_OVERRIDE) else None
        if override:
            real.setdefault(str(override), each.GetName())
    return real
