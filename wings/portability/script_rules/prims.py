"""Rules on the prims and sensors that a script makes, and on what it edits while the app plays."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graph.isaac.syntax import Script
from graph.sim import settings as keys
from wings.portability.wiring import LIVE, PLACES, WAITING

from .authored import BODIES, LIDAR, RADAR, SCHEMAS, SENSORS, authored_by
from .reading import Found, all_settings, app_configs, argument, finds

TIMELINE = "omni.timeline.get_timeline_interface()"
APP_UTILS = "isaacsim.core.experimental.utils.app"
WORLDS = (".World()", ".SimulationContext()")
OBJECTS = "isaacsim.core.experimental.objects."
UPDATES = ("update", "update_app", "next_update_async", "step")
MOVES = ("SetTranslate", "SetRotate", "set_world_pose", "set_world_poses", "set_local_pose", "set_local_poses")
MAKERS = (
    *(f"isaacsim.core.experimental.utils.stage.{name}" for name in ("define_prim", "add_reference_to_stage")),
    *(f"isaacsim.core.utils.prims.{name}" for name in ("create_prim", "define_prim")),
    "isaacsim.core.utils.stage.add_reference_to_stage",
)


FORMER = {
    "report-rate-ignored": ("omni:sensor:Core:reportRateBaseHz",),
    "aux-output-type-ignored": ("omni:sensor:Core:auxOutputType", "omni:sensor:WpmDmat:auxOutputType"),
}
"""Attributes of former versions, by the rule that finds them."""


@finds("report-rate-ignored")
def _former_rate(script: Script) -> Iterator[Found]:
    yield from _named(script, FORMER["report-rate-ignored"])


@finds("aux-output-type-ignored")
def _former_level(script: Script) -> Iterator[Found]:
    yield from _named(script, FORMER["aux-output-type-ignored"])


def _named(script: Script, names: tuple[str, ...]) -> Iterator[Found]:
    """Where the script writes an attribute's name, unless it authors a known prim there, which is found by itself."""
    places = [place for prim in authored_by(script).prims.values() for place in prim.places.values()]
    lines = {getattr(place, "lineno", 0) for place in places}
    for node in script.nodes:
        if isinstance(node, ast.Constant) and node.value in names and node.lineno not in lines:
            yield node, f"{node.value} is named"


@finds("prims-added-while-playing")
def _added(script: Script) -> Iterator[Found]:
    known: set[object] = set()
    for playing, call, name in _played(script):
        path = script.value_of(argument(call, 0, "paths")) or script.value_of(argument(call, 0, "path"))
        if _makes_prim(name):
            if playing and (path is None or path not in known):
                yield call, f"{name.rpartition('.')[2] if not name.endswith('.create') else name} comes after play"
            if isinstance(path, str):
                known.add(path)


@finds("edit-not-live")
def _late(script: Script) -> Iterator[Found]:
    waiting = ("MassAttr", "DensityAttr", "DynamicFrictionAttr", "StaticFrictionAttr", "RestitutionAttr", "GravityAttr")
    for playing, call, name in _played(script):
        if playing and (attribute := _attribute_set(script, call)).startswith(WAITING):
            if not attribute.endswith(LIVE):
                yield call, f"{attribute} after play"
            continue
        method = name.rpartition(".")[2]
        late = method.startswith("Create") and method.endswith(waiting) and bool(call.args or call.keywords)
        late = late or (name.removesuffix("().Set").endswith(waiting) and name.endswith(".Set"))
        if playing and late:
            yield call, f"{method if method != 'Set' else name.split('.')[-2]} after play"


@finds("physics-dt-while-playing")
def _dt_after_play(script: Script) -> Iterator[Found]:
    for playing, call, name in _played(script):
        if playing and name.endswith("SimulationManager.set_physics_dt"):
            yield call, "it comes after play"


@finds("radar-motion-bvh-off")
def _radar(script: Script) -> Iterator[Found]:
    on = any(path == keys.MOTION_BVH and value for _, path, value in all_settings(script))
    editor = not app_configs(script)
    for call, name in script.called if not (on or editor) else ():
        made = name in (f"{SENSORS}Radar", f"{SENSORS}Radar.create")
        if made or _command(script, call) == "IsaacSensorCreateRtxRadar":
            yield call, "a radar is made without Motion BVH"


@finds("fif-race")
def _race(script: Script) -> Iterator[Found]:
    prims = authored_by(script).prims.values()
    rendered = {kind: [one.asked[0][0] for one in prims if one.type == kind and one.asked] for kind in SCHEMAS}
    plays = [call.lineno for call, name in script.called if name.endswith(".play")]
    updates = [call.lineno for call, name in script.called if name.rpartition(".")[2] in UPDATES]
    with_bvh = (value for _, path, value in all_settings(script) if path == keys.MOTION_BVH)
    if rendered[LIDAR] and any(with_bvh):
        for place in rendered[RADAR]:
            before = script.mark(place).line
            if not any(min(plays, default=line) <= line < before for line in updates):
                yield place, "the radar is rendered beside a lidar before any update"


@finds("fabric-parent-moved")
def _moved(script: Script) -> Iterator[Found]:
    authored = authored_by(script)
    bodies = {authored.path_of(call) for call, name in script.called if name.rpartition(".")[2] in BODIES}
    bodies |= {
        authored.path_of(call.args[0])
        for call, name in script.called
        if name.endswith((".RigidBodyAPI.Apply", ".ArticulationRootAPI.Apply")) and call.args
    }
    for playing, call, name in _played(script):
        moves = name.rpartition(".")[2] in MOVES or _attribute_set(script, call).startswith(PLACES)
        if playing and moves and isinstance(call.func, ast.Attribute):
            path = authored.path_of(call.func.value)
            below = next((one for one in sorted(bodies) if path and one.startswith(f"{path}/")), None)
            if below is not None and path not in bodies:
                yield call, f"it moves {path}, above the body {below}"


@finds("aux-level-reset")
def _reset(script: Script) -> Iterator[Found]:
    levels: dict[object, str] = {}
    for call, name in script.called:
        if name.startswith(SENSORS) and name.removesuffix(".create").endswith(("Lidar", "Radar", "Acoustic")):
            level = script.value_of(argument(call, 99, "aux_output_level"))
            path = script.value_of(argument(call, 0, "path"))
            if isinstance(path, str) and isinstance(level, str) and level != "NONE":
                levels[path] = level
    for call, name in script.called:
        if name.startswith(SENSORS) and name.endswith(("LidarSensor", "RadarSensor", "AcousticSensor")):
            path = script.value_of(argument(call, 0, "path"))
            if isinstance(path, str) and path in levels:
                yield call, f"{path} loses its level {levels[path]}"


def _attribute_set(script: Script, call: ast.Call) -> str:
    """The name of the attribute that a call sets; "" for other calls and names that only a run knows."""
    owner = call.func.value if isinstance(call.func, ast.Attribute) and call.func.attr == "Set" else None
    if isinstance(owner, ast.Name):
        owner = script.values.get(owner.id)
    if not isinstance(owner, ast.Call) or not isinstance(owner.func, ast.Attribute) or not owner.args:
        return ""
    if owner.func.attr not in ("GetAttribute", "CreateAttribute", "GetAttributeAtPath"):
        return ""
    return str(script.value_of(owner.args[0])).rpartition(".")[2]


def _command(script: Script, call: ast.Call) -> str:
    """The Kit command that a call executes, or ""."""
    if script.name_of(call.func) != "omni.kit.commands.execute":
        return ""
    return str(script.value_of(argument(call, 0, "name"))).removesuffix("Command")


def _makes_prim(name: str) -> bool:
    if name.startswith(OBJECTS):
        return name.count(".") == OBJECTS.count(".")
    if name.startswith(SENSORS):
        return name.removeprefix(SENSORS).removesuffix(".create") in ("Lidar", "Radar", "Acoustic", "RtxCamera")
    return name in MAKERS or name.endswith(".DefinePrim") or (name.startswith("pxr.Usd") and name.endswith(".Define"))


def _played(script: Script) -> Iterator[tuple[bool, ast.Call, str]]:
    """The calls of each body in order, each with whether the body has called play, and no stop, before."""
    for body in script.bodies():
        playing = False
        for node in body:
            if not isinstance(node, ast.Call):
                continue
            name = script.name_of(node.func)
            owner, _, method = name.rpartition(".")
            ours = owner in (TIMELINE, APP_UTILS) or owner.endswith(WORLDS)
            yield playing, node, name
            if ours and (method == "play" or (method == "reset" and owner.endswith(WORLDS))):
                playing = True
            elif ours and method == "stop":
                playing = False
