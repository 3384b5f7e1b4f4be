"""How the rules read a script: the registry of finders, arguments, settings, the app's configuration."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator

from graph.portability.syntax import Script

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


def app_configs(script: Script) -> list[object]:
    """The configurations that SimulationApp gets."""
    return [script.value_of(argument(call, 0, "launch_config")) for call, name in script.called if name in APP]
