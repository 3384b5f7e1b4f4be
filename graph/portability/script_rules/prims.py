"""Rules on the prims and sensors that a script makes, and on what it edits while the app plays."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any

from graph.base.errors import UserError
from graph.portability.syntax import Script
from graph.sim import settings as keys

from .reading import APP, Found, app_configs, argument, finds, settings_of

TIMELINE = "omni.timeline.get_timeline_interface()"
APP_UTILS = "isaacsim.core.experimental.utils.app"
WORLDS = (".World()", ".SimulationContext()")
OBJECTS = "isaacsim.core.experimental.objects."
SENSORS = "isaacsim.sensors.experimental.rtx."
MAKERS = (
    *(f"isaacsim.core.experimental.utils.stage.{name}" for name in ("define_prim", "add_reference_to_stage")),
    *(f"isaacsim.core.utils.prims.{name}" for name in ("create_prim", "define_prim")),
    "isaacsim.core.utils.stage.add_reference_to_stage",
)


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
    on = any(isinstance(one, dict) and one.get("enable_motion_bvh") for one in app_configs(script))
    on = on or any(path == keys.MOTION_BVH and value for _, path, value in settings_of(script))
    on = on or any(f"--{keys.MOTION_BVH}=true" in map(str, _extra(one)) for one in app_configs(script))
    editor = not any(name in APP for _, name in script.called)
    for call, name in script.called if not (on or editor) else ():
        made = name in (f"{SENSORS}Radar", f"{SENSORS}Radar.create")
        if made or _command(script, call) == "IsaacSensorCreateRtxRadar":
            yield call, "a radar is made without Motion BVH"


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


@finds("lidar-partial-scan")
def _scan_rate(script: Script) -> Iterator[Found]:
    from sensors.configs.catalog import find

    for call, name in script.called:
        if name in (f"{SENSORS}Lidar", f"{SENSORS}Lidar.create"):
            rate = script.value_of(argument(call, 99, "tick_rate"))
            attributes = script.value_of(argument(call, 99, "attributes"))
            given = attributes if isinstance(attributes, dict) else {}
            config = script.value_of(argument(call, 99, "config"))
            scan = given.get("omni:sensor:Core:scanRateBaseHz")
            rate = given.get("omni:sensor:tickRate", rate)
            if scan is None and config is None and name.endswith("Lidar"):
                scan = 10
            if scan is None and isinstance(config, str):
                variant: Any = script.value_of(argument(call, 99, "variant"))
                try:
                    scan = float(find(config, variant).scan_rate_base_hz)
                except UserError:  # an unknown configuration is another mistake
                    continue
            if isinstance(rate, int | float) and isinstance(scan, int | float) and rate and rate != scan:
                yield call, f"tick_rate is {rate:g} Hz, scanRateBaseHz {scan:g} Hz"
            elif script.value_of(argument(call, 99, "accumulate_outputs")) is False:
                yield call, "accumulate_outputs is False"


def _extra(config: object) -> list[object]:
    extra = config.get("extra_args") if isinstance(config, dict) else None
    return extra if isinstance(extra, list) else []


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
