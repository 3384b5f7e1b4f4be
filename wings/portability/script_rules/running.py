"""Rules on how a script runs the app: its start and end, callbacks, clocks, settings."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graph.isaac.syntax import Script
from graph.sim import settings as keys
from wings.portability.clocks import truncated
from wings.portability.sensors import GPU_BUFFERS

from .reading import APP, Found, app_configs, argument, finds, settings_of

BEFORE_APP = ("isaacsim", "isaacsim.SimulationApp", "isaacsim.simulation_app", "omni.isaac.kit")
CALLBACK_SWITCHES = 4


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
    return any(config.get("fast_shutdown") is False for _, config in app_configs(script))


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
            dt = script.value_of(argument(call, 0, "dt"))
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
    written = {path: node for node, path, _ in settings_of(script)}
    names = {name.rpartition(".")[2] for _, name in script.called}
    if keys.RATE_LIMIT_FREQUENCY in written and keys.TIME_CODES_PER_SECOND not in written:
        rendering = any("RenderingManager.set_dt" in name for _, name in script.called)
        if not rendering and not names & {"set_time_codes_per_second", "SetTimeCodesPerSecond", "set_target_framerate"}:
            yield written[keys.RATE_LIMIT_FREQUENCY], "the script sets no timeCodesPerSecond"


@finds("fast-mode-wall-time")
def _fast(script: Script) -> Iterator[Found]:
    fast = any(path == keys.FAST_MODE and value for _, path, value in settings_of(script))
    fast = fast or any(
        name.endswith(".set_play_every_frame") and script.value_of(argument(call, 0, "play_every_frame")) is not False
        for call, name in script.called
    )
    for call, name in script.called if fast else ():
        if name in ("time.sleep", "time.time", "time.perf_counter", "time.monotonic", "asyncio.sleep"):
            yield call, f"{name} beside useFastMode"


@finds("timeline-stamp")
def _stamp(script: Script) -> Iterator[Found]:
    time = "omni.timeline.get_timeline_interface().get_current_time()"
    for node in script.nodes:
        if isinstance(node, ast.Assign):
            named = script.name_of(node.targets[0])
        elif isinstance(node, ast.keyword):
            named = node.arg or ""
        else:
            continue
        if "stamp" in named.lower() and any(script.name_of(one) == time for one in ast.walk(node.value)):
            yield node, f"{named.rpartition('.')[2]} gets the timeline's time"


@finds("manual-mode-lag")
def _manual_mode(script: Script) -> Iterator[Found]:
    yield from ((node, "the setting is written") for node, path, _ in settings_of(script) if path == keys.MANUAL_MODE)


@finds("output-buffer-on-gpu")
def _gpu(script: Script) -> Iterator[Found]:
    yield from ((node, f"{path} is set") for node, path, value in settings_of(script) if path in GPU_BUFFERS and value)


@finds("multi-tick-off")
def _multi_tick(script: Script) -> Iterator[Found]:
    for node, path, value in settings_of(script):
        if path == keys.MULTI_TICK and value is False:
            yield node, "it is switched off"
