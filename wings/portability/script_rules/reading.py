"""How the rules read a script: the registry of finders, arguments, settings, the app's configuration."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from graph.isaac.syntax import Script
from graph.sim import settings as keys

Found = tuple[ast.AST, str]
Finder = Callable[[Script], Iterator[Found]]
FINDERS: dict[str, list[Finder]] = {}

APP = ("isaacsim.SimulationApp", "isaacsim.simulation_app.SimulationApp", "omni.isaac.kit.SimulationApp")


def finds(code: str) -> Callable[[Finder], Finder]:
    """Declares a function that finds what breaks a rule in scripts."""

    def register(finder: Finder) -> Finder:
        FINDERS.setdefault(code, []).append(finder)
        return finder

    return register


def argument(call: ast.Call, position: int, name: str) -> ast.expr | None:
    """An argument of a call, by keyword or position."""
    named = next((one.value for one in call.keywords if one.arg == name), None)
    return named if named is not None else call.args[position] if position < len(call.args) else None


def settings_of(script: Script) -> Iterator[tuple[ast.AST, str, object]]:
    """The settings that a script writes: place, path, value."""
    for call, name in script.called:
        method = name.rpartition(".")[2]
        if method in ("set", "set_bool", "set_int", "set_float", "set_string", "set_carb_setting"):
            shift = 1 if method == "set_carb_setting" else 0
            path = script.value_of(argument(call, shift, "path"))
            if isinstance(path, str) and path.count("/") > 1:
                yield call, f"/{path.lstrip('/')}", script.value_of(argument(call, shift + 1, "value"))


def app_configs(script: Script) -> list[tuple[ast.Call, dict[str, Any]]]:
    """The calls that make the app, each with its configuration; None stands for values that only a run knows."""
    found: list[tuple[ast.Call, dict[str, Any]]] = []
    for call, name in script.called:
        if name in APP:
            given = argument(call, 0, "launch_config")
            given = script.values.get(given.id) if isinstance(given, ast.Name) else given
            entries = zip(given.keys, given.values, strict=True) if isinstance(given, ast.Dict) else ()
            found.append((call, {str(script.value_of(key)): script.value_of(value) for key, value in entries}))
    return found


def all_settings(script: Script) -> list[tuple[ast.AST, str, Any]]:
    """The settings that a script gives to its app and writes: place, path, value (None: only a run knows it)."""
    launched = ((call, *entry) for call, config in app_configs(script) for entry in _launched(config))
    return [*launched, *settings_of(script)]


def _launched(config: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The settings that an app's configuration writes, with their values."""
    if config.get("enable_motion_bvh", False) is not False:
        yield keys.MOTION_BVH, True
    extra = config.get("extra_args")
    for one in extra if isinstance(extra, list) else ():
        path, sign, text = str(one).removeprefix("--").partition("=")
        if path.startswith("/") and sign:
            yield path, {"true": True, "false": False}.get(text.lower(), text)
