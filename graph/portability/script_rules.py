"""What scripts for Isaac Sim lose or must change, found in their syntax trees."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

from graph.base.errors import UserError
from graph.sim import settings as keys

from .clocks import truncated
from .renamed import ANNOTATORS, CLASSES, DEPRECATED, GONE, PARSERS, STILL_THERE, replacement
from .sensors import GPU_BUFFERS
from .syntax import Script
from .wiring import REPLACED, last_part

Found = tuple[ast.AST, str]
Finder = Callable[[Script], Iterator[Found]]
FINDERS: dict[str, list[Finder]] = {}

APP = ("isaacsim.SimulationApp", "isaacsim.simulation_app.SimulationApp", "omni.isaac.kit.SimulationApp")
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
BEFORE_APP = ("isaacsim", "isaacsim.SimulationApp", "isaacsim.simulation_app", "omni.isaac.kit")
CALLBACK_SWITCHES = 4


def finds(code: str) -> Callable[[Finder], Finder]:
    """Declares a function that finds what breaks a rule in scripts."""

    def register(finder: Finder) -> Finder:
        FINDERS.setdefault(code, []).append(finder)
        return finder

    return register


# -- imports and names -------------------------------------------------------------------------------------------------


@finds("import-renamed")
def _gone(script: Script) -> Iterator[Found]:
    for name, place in script.imports:
        if instead := replacement(name, GONE):
            yield place, f"{name} is now in {instead}"


@finds("module-deprecated")
def _deprecated(script: Script) -> Iterator[Found]:
    told: set[str] = set()
    for name, place in script.imports:
        module = next((one for one in sorted(DEPRECATED, key=len)[::-1] if f"{name}.".startswith(f"{one}.")), "")
        if module and module not in told and not name.startswith(STILL_THERE):
            told.add(module)
            yield place, f"{module} gives way to {DEPRECATED[module]}"


@finds("extension-renamed")
def _extensions(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(("enable_extension", "set_extension_enabled_immediate", "set_extension_enabled")):
            extension = script.value_of(_argument(call, 0, "name"))
            if isinstance(extension, str) and (instead := replacement(extension, GONE)):
                yield call, f"{extension} is now {instead}"


@finds("class-deprecated")
def _classes(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        called = name.rpartition(".")[2]
        if called == "execute" and name.startswith("omni.kit.commands"):
            called = str(script.value_of(_argument(call, 0, "name"))).removesuffix("Command")
        if instead := CLASSES.get(called):
            yield call, f"{called} gives way to {instead}"


@finds("gmo-parser-deprecated")
def _parsers(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if instead := PARSERS.get(name.rpartition(".")[2]):
            yield call, f"{name.rpartition('.')[2]} gives way to {instead}"


@finds("annotator-deprecated")
def _annotators(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and (instead := ANNOTATORS.get(node.value)):
            yield node, f"{node.value} gives way to {instead}"


@finds("next-render-simulation-deprecated")
def _one_product(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(("next_render_simulation_async", "next_sensor_data_async")):
            yield call, f"{name.rpartition('.')[2]} waits for one render product"


@finds("gmo-attribute-missing")
def _no_such_property(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if not isinstance(node, ast.Attribute) or node.attr not in ("azimuth", "elevation", "distance"):
            continue
        if script.name_of(node.value).endswith(("parse_generic_model_output_data()", "get_gmo_data()")):
            yield node, f".{node.attr} does not exist"


@finds("object-id-without-entry")
def _subscripted(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if not isinstance(node, ast.Subscript) or not isinstance(node.ctx, ast.Load):
            continue
        if script.name_of(node.value).endswith(("parse_stable_id_map_data()", "decode_stable_id_mapping()")):
            yield node, "the map is subscripted"


# -- the app -----------------------------------------------------------------------------------------------------------


@finds("import-before-app")
def _too_early(script: Script) -> Iterator[Found]:
    made = [call.lineno for call, name in script.called if name in APP]
    for name, place in script.imports:
        early = made and place in script.tree.body and place.lineno < min(made)
        if early and name.startswith(("omni.", "isaacsim.")) and name not in (*BEFORE_APP, *APP):
            yield place, f"{name} is imported before SimulationApp(...)"


@finds("code-after-close")
def _after_close(script: Script) -> Iterator[Found]:
    body = script.tree.body
    for number, statement in enumerate(body):
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call):
            name = script.name_of(statement.value.func)
            if name.removesuffix(".close") in {f"{app}()" for app in APP} and name.endswith(".close"):
                rest = [one for one in body[number + 1 :] if not _ends(script, one)]
                if rest and not _returns_from_close(script):
                    yield rest[0], f"close() of line {statement.lineno} has ended the process"
                return


def _ends(script: Script, statement: ast.stmt) -> bool:
    called = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(called, ast.Call) and script.name_of(called.func) in ("sys.exit", "exit", "quit", "os._exit")


def _returns_from_close(script: Script) -> bool:
    """Whether the app is configured so that close() returns."""
    return any(isinstance(one, dict) and one.get("fast_shutdown") is False for one in _app_configs(script))


@finds("asyncio-run")
def _asyncio(script: Script) -> Iterator[Found]:
    yield from ((call, "asyncio.run is called") for call, name in script.called if name == "asyncio.run")


@finds("assets-root-raises")
def _assets_root(script: Script) -> Iterator[Found]:
    for node in script.nodes:
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is | ast.IsNot | ast.Eq | ast.NotEq):
            none = isinstance(node.comparators[0], ast.Constant) and node.comparators[0].value is None
            if none and script.name_of(node.left).endswith("get_assets_root_path()"):
                yield node, "it is compared with None"


@finds("open-stage-always-true")
def _open_stage(script: Script) -> Iterator[Found]:
    name = "isaacsim.core.experimental.utils.stage.open_stage()"
    for node in script.nodes:
        test = node.test if isinstance(node, ast.If | ast.While | ast.Assert | ast.IfExp) else None
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            test = test.operand
        if test is not None and script.name_of(test) == name:
            yield test, "its truth is tested"


# -- callbacks and clocks ----------------------------------------------------------------------------------------------


@finds("callback-arguments-swapped")
def _swapped(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        first = script.name_of(call.args[0]) if call.args else ""
        if name.endswith("SimulationManager.register_callback") and ("SimulationEvent." in first or "Events." in first):
            yield call, "its first argument is the event"
        elif name.endswith("RenderingManager.register_callback") and call.args and "RenderingEvent." not in first:
            second = script.name_of(call.args[1]) if len(call.args) > 1 else ""
            if "RenderingEvent." in second or any(
                one.arg == "event" and "RenderingEvent." in script.name_of(one.value) for one in call.keywords
            ):
                yield call, "its first argument is the callback"


@finds("callback-dropped")
def _dropped(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(("SimulationManager.register_callback", "RenderingManager.register_callback")):
            for given in (*call.args, *(one.value for one in call.keywords)):
                if isinstance(given, ast.Attribute) and isinstance(given.value, ast.Call):
                    yield given, "the object of this method is kept by nobody"


@finds("default-callbacks-off")
def _switches(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        given = len(call.keywords)
        if name.endswith("SimulationManager.enable_default_callbacks") and 0 < given < CALLBACK_SWITCHES:
            yield call, f"it gives {given} of {CALLBACK_SWITCHES} switches"


@finds("physics-rate-truncated")
def _dt(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith((".set_dt", ".setup_simulation", ".set_physics_dt")) and "Rendering" not in name:
            dt = script.value_of(_argument(call, 0, "dt"))
            if isinstance(dt, int | float) and not isinstance(dt, bool) and 0 < dt <= 1:
                lost = truncated(dt)
                lost = lost if lost is not None else (int(1 / dt) if int(1 / dt) != round(1 / dt) else None)
                if lost is not None:
                    yield call, f"dt {dt:.6g} s becomes {lost} steps a second"


@finds("min-frame-rate-changed")
def _set_simulation_dt(script: Script) -> Iterator[Found]:
    for call, name in script.called:
        if name.endswith(".set_simulation_dt"):
            yield call, "it is called"


@finds("rate-limit-without-time-codes")
def _limit_alone(script: Script) -> Iterator[Found]:
    written = {path: node for node, path, _ in _settings(script)}
    names = {name.rpartition(".")[2] for _, name in script.called}
    if keys.RATE_LIMIT_FREQUENCY in written and keys.TIME_CODES_PER_SECOND not in written:
        rendering = any("RenderingManager.set_dt" in name for _, name in script.called)
        if not rendering and not names & {"set_time_codes_per_second", "SetTimeCodesPerSecond", "set_target_framerate"}:
            yield written[keys.RATE_LIMIT_FREQUENCY], "the script sets no timeCodesPerSecond"


@finds("fast-mode-wall-time")
def _fast(script: Script) -> Iterator[Found]:
    fast = any(path == keys.FAST_MODE and value for _, path, value in _settings(script))
    fast = fast or any(
        name.endswith(".set_play_every_frame") and script.value_of(_argument(call, 0, "play_every_frame")) is not False
        for call, name in script.called
    )
    for call, name in script.called if fast else ():
        if name in ("time.sleep", "time.time", "time.perf_counter", "time.monotonic", "asyncio.sleep"):
            yield call, f"{name} beside useFastMode"


@finds("manual-mode-lag")
def _manual_mode(script: Script) -> Iterator[Found]:
    yield from ((node, "the setting is written") for node, path, _ in _settings(script) if path == keys.MANUAL_MODE)


@finds("output-buffer-on-gpu")
def _gpu(script: Script) -> Iterator[Found]:
    yield from ((node, f"{path} is set") for node, path, value in _settings(script) if path in GPU_BUFFERS and value)


@finds("multi-tick-off")
def _multi_tick(script: Script) -> Iterator[Found]:
    for node, path, value in _settings(script):
        if path == keys.MULTI_TICK and value is False:
            yield node, "it is switched off"


# -- prims and sensors -------------------------------------------------------------------------------------------------


@finds("prims-added-while-playing")
def _added(script: Script) -> Iterator[Found]:
    known: set[object] = set()
    for playing, call, name in _played(script):
        path = script.value_of(_argument(call, 0, "paths")) or script.value_of(_argument(call, 0, "path"))
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
    on = any(isinstance(one, dict) and one.get("enable_motion_bvh") for one in _app_configs(script))
    on = on or any(path == keys.MOTION_BVH and value for _, path, value in _settings(script))
    on = on or any(f"--{keys.MOTION_BVH}=true" in map(str, _extra(one)) for one in _app_configs(script))
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
            level = script.value_of(_argument(call, 99, "aux_output_level"))
            path = script.value_of(_argument(call, 0, "path"))
            if isinstance(path, str) and isinstance(level, str) and level != "NONE":
                levels[path] = level
    for call, name in script.called:
        if name.startswith(SENSORS) and name.endswith(("LidarSensor", "RadarSensor", "AcousticSensor")):
            path = script.value_of(_argument(call, 0, "path"))
            if isinstance(path, str) and path in levels:
                yield call, f"{path} loses its level {levels[path]}"


@finds("lidar-partial-scan")
def _scan_rate(script: Script) -> Iterator[Found]:
    from sensors.configs.catalog import find

    for call, name in script.called:
        if name in (f"{SENSORS}Lidar", f"{SENSORS}Lidar.create"):
            rate = script.value_of(_argument(call, 99, "tick_rate"))
            attributes = script.value_of(_argument(call, 99, "attributes"))
            given = attributes if isinstance(attributes, dict) else {}
            config = script.value_of(_argument(call, 99, "config"))
            scan = given.get("omni:sensor:Core:scanRateBaseHz")
            rate = given.get("omni:sensor:tickRate", rate)
            if scan is None and config is None and name.endswith("Lidar"):
                scan = 10
            if scan is None and isinstance(config, str):
                variant: Any = script.value_of(_argument(call, 99, "variant"))
                try:
                    scan = float(find(config, variant).scan_rate_base_hz)
                except UserError:  # an unknown configuration is another mistake
                    continue
            if isinstance(rate, int | float) and isinstance(scan, int | float) and rate and rate != scan:
                yield call, f"tick_rate is {rate:g} Hz, scanRateBaseHz {scan:g} Hz"
            elif script.value_of(_argument(call, 99, "accumulate_outputs")) is False:
                yield call, "accumulate_outputs is False"


# -- graphs that a script edits ----------------------------------------------------------------------------------------


@finds("node-deprecated")
def _nodes(script: Script) -> Iterator[Found]:
    for node, _, kind in _created(script):
        if instead := REPLACED.get(last_part(kind)):
            yield node, f"{last_part(kind)} gives way to {instead}"


@finds("type-renamed")
def _old_types(script: Script) -> Iterator[Found]:
    from graph.spec.migration import migrated_type

    for node, _, kind in _created(script):
        present, said = migrated_type(kind)
        if said and present != kind:
            yield node, f'"{kind}" is now called "{present}"'


@finds("frame-skip-deprecated")
def _skipped(script: Script) -> Iterator[Found]:
    yield from (
        (node, f"{name} is {value}") for node, name, value in _set(script) if name.endswith(":frameSkipCount") and value
    )


@finds("full-scan-deprecated")
def _whole(script: Script) -> Iterator[Found]:
    yield from ((node, f"{name} is set") for node, name, _ in _set(script) if name.endswith(":fullScan"))


@finds("gate-step-zero")
def _gates(script: Script) -> Iterator[Found]:
    gates = {name for _, name, kind in _created(script) if last_part(kind) == "IsaacSimulationGate"}
    for node, name, value in _set(script):
        if value == 0 and name.endswith(".inputs:step") and name.rpartition(".")[0] in gates:
            yield node, f"{name} is 0"


@finds("joint-indices-zero")
def _joints(script: Script) -> Iterator[Found]:
    for node, name, value in _set(script):
        if name.endswith(".inputs:jointIndices") and value in ([0], (0,)):
            yield node, f"{name} is [0]"


@finds("timeline-stamp")
def _stamps(script: Script) -> Iterator[Found]:
    kinds = {name: last_part(kind) for _, name, kind in _created(script)}
    for node, source, target in _pairs(script, "CONNECT"):
        kind = kinds.get(source.rpartition(".")[0], "")
        other_clock = source.endswith((":time", ":timeSinceStart", ":absoluteSimTime"))
        if other_clock and target.endswith(".inputs:timeStamp") and kind in ("OnPlaybackTick", "OnTick", "ReadTime"):
            yield node, f"{target} gets {source}"


def _created(script: Script) -> Iterator[tuple[ast.AST, str, str]]:
    """The nodes that edits create: place, name, type."""
    yield from _pairs(script, "CREATE_NODES")
    for call, name in script.called:
        if name.endswith("Controller.create_node"):
            kind = script.value_of(_argument(call, 1, "node_type_id"))
            if isinstance(kind, str):
                yield call, str(script.value_of(_argument(call, 0, "node_id"))), kind


def _pairs(script: Script, key: str) -> Iterator[tuple[ast.AST, str, str]]:
    """The entries of a key of Controller.edit that are two texts."""
    for node, first, second in _entries(script, key):
        if isinstance(text := script.value_of(second), str):
            yield node, first, text


def _set(script: Script) -> Iterator[tuple[ast.AST, str, Any]]:
    """The values that edits set: place, NODE.inputs:NAME, value."""
    for node, name, value in _entries(script, "SET_VALUES"):
        yield node, name, script.value_of(value)


def _entries(script: Script, key: str) -> Iterator[tuple[ast.AST, str, ast.expr]]:
    """The entries (text, expression) below a key of Controller.edit."""
    for node in script.nodes:
        if not isinstance(node, ast.Dict):
            continue
        for name, value in zip(node.keys, node.values, strict=True):
            if isinstance(name, ast.Attribute) and name.attr == key:
                entries = [value] if isinstance(value, ast.Tuple) else getattr(value, "elts", [])
                for entry in entries:
                    if isinstance(entry, ast.Tuple | ast.List) and len(entry.elts) >= 2:
                        first = script.value_of(entry.elts[0])
                        if isinstance(first, str):
                            yield entry, first, entry.elts[1]


# -- how the rules read a script ---------------------------------------------------------------------------------------


def _argument(call: ast.Call, position: int, name: str) -> ast.expr | None:
    """An argument of a call, by keyword or position."""
    named = next((one.value for one in call.keywords if one.arg == name), None)
    return named if named is not None else call.args[position] if position < len(call.args) else None


def _settings(script: Script) -> Iterator[tuple[ast.AST, str, object]]:
    """The settings that a script writes: place, path, value."""
    for call, name in script.called:
        method = name.rpartition(".")[2]
        if method in ("set", "set_bool", "set_int", "set_float", "set_string", "set_carb_setting"):
            shift = 1 if method == "set_carb_setting" else 0
            path = script.value_of(_argument(call, shift, "path"))
            if isinstance(path, str) and path.count("/") > 1:
                yield call, f"/{path.lstrip('/')}", script.value_of(_argument(call, shift + 1, "value"))


def _app_configs(script: Script) -> list[object]:
    """The configurations that SimulationApp gets."""
    return [script.value_of(_argument(call, 0, "launch_config")) for call, name in script.called if name in APP]


def _extra(config: object) -> list[object]:
    extra = config.get("extra_args") if isinstance(config, dict) else None
    return extra if isinstance(extra, list) else []


def _command(script: Script, call: ast.Call) -> str:
    """The Kit command that a call executes, or ""."""
    if script.name_of(call.func) != "omni.kit.commands.execute":
        return ""
    return str(script.value_of(_argument(call, 0, "name"))).removesuffix("Command")


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
