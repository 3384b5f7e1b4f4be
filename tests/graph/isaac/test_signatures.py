"""Parameters of Isaac Sim's functions, methods and classes: names, order and defaults, as scripts give them."""

import ast
import inspect
from importlib import import_module
from pathlib import Path

import graph.isaac
from graph.sim import App

LISTED = Path(__file__).with_name("signatures.txt")
"""One a line: module, name, parameters; `...` is a default that nothing here needs to have."""


def test_every_listed_call_takes_the_parameters_of_the_original():
    lines = [line.split(" ", 2) for line in LISTED.read_text(encoding="utf-8").splitlines()]
    with App(), graph.isaac.importable():
        found = [
            f"{module}.{name}: {one}" for module, name, listed in lines for one in _differences(module, name, listed)
        ]
    assert found == []
    assert len(lines) > 1000


def _differences(module, name, listed):
    place = import_module(module)
    for part in name.split("."):
        if not hasattr(place, part):
            return [f"there is no {part}"]
        place = getattr(place, part)
    if not callable(place):
        return []
    try:
        ours = [one for one in inspect.signature(place).parameters.values() if one.name not in ("self", "cls")]
    except ValueError:  # of a class written in C++
        return []
    wanted, keywords, defaults = _parsed(listed)
    return list(_compared(ours, wanted, keywords, defaults))


def _parsed(listed):
    given = ast.parse(f"def f{listed}: pass").body[0].args
    wanted = [one.arg for one in given.args]
    defaults = dict(zip(reversed(wanted), reversed(given.defaults), strict=False))
    defaults |= {one.arg: value for one, value in zip(given.kwonlyargs, given.kw_defaults, strict=True) if value}
    return wanted, [one.arg for one in given.kwonlyargs], defaults


def _compared(ours, wanted, keywords, defaults):
    named = {one.name: one for one in ours}
    kinds = {one.kind for one in ours}
    any_name, any_place = inspect.Parameter.VAR_KEYWORD in kinds, inspect.Parameter.VAR_POSITIONAL in kinds
    places = [one.name for one in ours if one.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
    for number, name in enumerate(wanted):
        if name not in named and not any_name:
            yield f"no parameter {name}"
        elif name in places and places.index(name) != number:
            yield f"{name} is number {places.index(name)}, not {number}"
        elif name in named and name not in places and not any_place:
            yield f"{name} cannot be given by place"
    yield from (f"no keyword {name}" for name in keywords if name not in named and not any_name)
    for name, value in defaults.items():
        if name in named and named[name].default is inspect.Parameter.empty:
            yield f"{name} has no default"
        elif name in named and isinstance(value, ast.Constant) and value.value is not ...:
            have = named[name].default
            if have != value.value and str(have) != str(value.value):
                yield f"{name} is {have!r} by default, not {value.value!r}"
    yield from (
        f"{name} must be given" for name in places if name not in wanted and named[name].default is named[name].empty
    )
