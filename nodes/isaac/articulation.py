"""Commands to the joints of an articulated robot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim.scene.prim_paths import near_prim, prim_at

NAN = "an empty array leaves them all alone, NaN leaves one joint alone"


@dataclass(slots=True)
class _Robot:
    path: str = ""
    articulation: Any = None
    checked: bool = False


def robot_at(db: Database, path: str) -> Any:
    """The articulation at a path.

    Reported by `db.lack` if nothing moves there, for example if a robot's asset is missing.
    """
    if not prim_at(db.app.stage, path):
        db.lack(f"there is no prim {path} on the stage{near_prim(db.app.stage, path)}")
    if db.app.physics is None:
        db.lack(f"{path} is not a robot: nothing on the stage can move")
    try:
        return db.app.physics.articulation(path)
    except RunError as error:
        db.lack(str(error))


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Joint names that no joint on the stage has; joints with several axes go by `name:axis`."""
    if "jointNames" not in node.given:
        return
    known = {name for _, names in _joints(node.stage) for name in names}
    for name in node.db.inputs.jointNames if known else ():
        if name.partition(":")[0] not in known and name not in known:
            yield "jointNames", f'no joint on the stage is called "{name}"{did_you_mean(name, known)}'


def _notes(db: Database) -> Iterator[tuple[str, str, str]]:
    """The joints that are commanded and that no stage gives a drive, as far as the file names them."""
    from graph.sim.scene.mechanisms import GIVEN

    inputs = db.inputs
    asked = [
        word
        for word, name in (("positions", "positionCommand"), ("velocities", "velocityCommand"))
        if db.connected(f"inputs:{name}") or len(getattr(inputs, name))
    ]
    path = inputs.robotPath or (inputs.targetPrim[0] if inputs.targetPrim else "")
    if not asked or not path or db.connected("inputs:jointNames") or not len(inputs.jointNames):
        return
    driven: dict[str, bool] = {}
    for prim, names in _joints(db.app.stage):
        # A model's own joints have its actuators.
        has_drive = bool(prim.GetAttribute(GIVEN).Get()) or any(
            schema.startswith("PhysicsDriveAPI") for schema in prim.GetAppliedSchemas()
        )
        for name in names:
            driven[name] = driven.get(name, False) or has_drive
    idle = [name for name in inputs.jointNames if not driven.get(name, True)]
    if idle:
        yield "jointNames", *_without_drive(idle, path, asked)


def _without_drive(joints: Iterable[str], path: Any, asked: Iterable[str]) -> tuple[str, str]:
    return (
        "joint-without-drive",
        f"{', '.join(joints)} of {path} do not follow {' or '.join(asked)}: give each a drive (PhysicsDriveAPI) with "
        "stiffness for positions, damping for velocities",
    )


def _joints(stage: Any) -> Iterator[tuple[Any, set[str]]]:
    """The joint prims of a stage, each with the names that it goes by."""
    from graph.sim.scene.mechanisms import GIVEN
    from graph.sim.scene.prim_paths import NAME_OVERRIDE
    from graph.sim.usd import Usd, UsdPhysics

    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdPhysics.Joint):
            given = (prim.GetAttribute(name).Get() for name in (GIVEN, NAME_OVERRIDE))
            yield prim, {prim.GetName(), *(str(name) for name in given if name)}


@node_type(
    "isaacsim.core.nodes.IsaacArticulationController",
    version=1,
    needs=(("targetPrim", "robotPath"),),
    check=_check,
    notes=_notes,
    inputs={
        "execIn": Attribute("execution", "applies the commands"),
        "targetPrim": Attribute("target", "the articulation's root prim; used where robotPath is empty", optional=True),
        "robotPath": Attribute("string", "path of the articulation's root prim; wins over targetPrim", role="prim"),
        "jointNames": Attribute(
            "token[]", "the commanded joints by name; wins over jointIndices, empty means by index"
        ),
        "jointIndices": Attribute("int[]", "the commanded joints by index; empty means all joints"),
        "positionCommand": Attribute(
            "double[]", f"wanted positions, one per joint; {NAN}", unit="rad or m", role="command"
        ),
        "velocityCommand": Attribute(
            "double[]", f"wanted speeds, one per joint; {NAN}", unit="rad/s or m/s", role="command"
        ),
        "effortCommand": Attribute(
            "double[]", f"wanted efforts, one per joint; {NAN}", unit="N m or N", role="command"
        ),
    },
    memory=_Robot,
)
def articulation_controller(db: Database) -> bool:
    """Send position, velocity and effort commands to joints; a command of the wrong length fails and sends nothing.

    A command for jointIndices [0] reaches joint 0 only (Isaac Sim takes it for all joints; not copied).
    """
    app, inputs, memory = db.app, db.inputs, db.memory
    if app.timeline.is_stopped():
        return False
    path = inputs.robotPath or (inputs.targetPrim[0] if inputs.targetPrim else "")
    if not path:
        db.lack("no robot; set targetPrim or robotPath to the root prim of an articulation")
    if path != memory.path:
        memory.articulation, memory.path = robot_at(db, path), path
    articulation = memory.articulation
    joints = joint_selection(db, articulation)
    commands = {
        "position": inputs.positionCommand,
        "velocity": inputs.velocityCommand,
        "effort": inputs.effortCommand,
    }
    width = len(joints)
    for name, command in commands.items():
        if len(command) not in (0, width):
            db.fail(f"{name}Command has {len(command)} values for {width} joints of {path}; nothing was sent")
    articulation.set_targets(*commands.values(), joints=joints)
    if not memory.checked and (len(inputs.positionCommand) or len(inputs.velocityCommand)):
        memory.checked = True
        told = {"positions": len(inputs.positionCommand) > 0, "velocities": len(inputs.velocityCommand) > 0}
        deaf = articulation.deaf(**told)
        idle = [articulation.joint_names[joint] for joint in joints if deaf[joint]]
        if idle:
            db.warn(*_without_drive(idle, path, [one for one in told if told[one]]))
    return True


def joint_selection(db: Database, articulation: Any) -> Sequence[int]:
    """The indices of the commanded joints, in command order. Fails the node for an unknown name or index.

    Joints have their names in messages (those of their model, `isaac:nameOverride`) and those of their prims.
    """
    inputs, names = db.inputs, articulation.joint_names
    if len(inputs.jointNames):
        known = articulation.numbers
        if "" in inputs.jointNames:
            element, source = list(inputs.jointNames).index(""), db.source_of("jointNames")
            which = f"jointNames[{element}]" + (f" (element {element} of {source})" if source else "")
            db.fail(f"{which} is unset; the robot has {', '.join(names)}")
        unknown = [name for name in inputs.jointNames if name not in known]
        if unknown:
            db.fail(f"no joint {', '.join(unknown)}; the robot has {', '.join(names)}")
        return [known[name] for name in inputs.jointNames]
    if len(inputs.jointIndices):
        wrong = [int(index) for index in inputs.jointIndices if not 0 <= index < len(names)]
        if wrong:
            db.fail(f"no joint with index {wrong[0]}; the robot has {len(names)} joints, counted from 0")
        return [int(index) for index in inputs.jointIndices]
    return range(len(names))
