"""Inline prims of a graph file: plain mappings become prims of the stage."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.limits import check
from graph.base.suggest import did_you_mean
from graph.sim.scene.prim_paths import is_path

from .prim_attributes import ending_alike
from .prim_keys import FINAL, KEYS, OTHER_WORDS, PrimContext, SensorConfig, SensorPrims
from .stage import Warn, ignore_warning
from .stage_faults import repair_transforms, tell_other_units

MAX_DEPTH = 256
"""Names in a prim path."""

TICK_RATE = "omni:sensor:tickRate"
RATES = ("rate", "hz", "frequency", "fps", "scanrate", "updaterate", "ratehz")
"""Common names for it, in lower case without `_`."""

Where = Callable[..., Mark | None]
"""Gives the mark of a prim path, or of a prim path and key."""


def author_prims(
    stage: Any,
    prims: Mapping[str, Mapping[str, Any]],
    where: Where = lambda path, key=None: None,
    *,
    sensor_config: SensorConfig | None = None,
    sensor_types: Mapping[str, SensorPrims] = MappingProxyType({}),
    folder: Path | None = None,
    allow_roots: Iterable[str | Path] | None = None,
    warn: Warn = ignore_warning,
) -> None:
    """Authors inline prims, in order, on top of the stage's scene.

    sensor_config(prim, config, variant): writes a sensor's configuration; its attributes are set before `attributes`.
    sensor_types: by prim type, the sensors that are registered, with attributes that no schema declares.
    folder: what `reference` is relative to; allow_roots: where referenced files may lie (default: `folder`).
    Raises UserError with every problem, each at `where(path, key)`, and beyond the limit file.prims.
    """
    folder = Path.cwd() if folder is None else folder
    roots = [folder] if allow_roots is None else [Path(root) for root in allow_roots]
    check("file.prims", _with_parents(prims), "the prims written in the file, with those above them, are too many")
    context = PrimContext(stage, folder, roots, sensor_config, sensor_types, warn)
    before = stage.GetUsedLayers()
    problems: list[Problem] = []
    context.define_new({path: keys for path, keys in prims.items() if not _path_problem(path)})
    for path, keys in prims.items():
        problems.extend(_author(context, path, keys, where))
    for path, keys in prims.items():
        for name, finish in FINAL.items():
            if isinstance(keys, Mapping) and name in keys and stage.GetPrimAtPath(path):
                problems.extend(_attempt(where, path, name, partial(finish, context, path, keys[name])))
    if problems:
        raise UserError(problems)
    context.confirm(before)
    if any("reference" in keys for keys in prims.values()):
        tell_other_units(stage, warn)
        repair_transforms(stage, warn)


def _with_parents(paths: Iterable[str]) -> int:
    """How many prims have these paths, or lie above one that does."""
    found: set[str] = set()
    for path in paths:
        while path and path not in found:
            found.add(path)
            path = path.rpartition("/")[0]
    return len(found)


def _author(context: PrimContext, path: str, keys: Any, where: Where) -> list[Problem]:
    if not isinstance(keys, Mapping):
        return [Problem(f"{path}: a prim is written as a mapping such as {{type: Cube, size: 1.0}}", where(path))]
    problem = _path_problem(path)
    if problem:
        return [Problem(problem, where(path))]
    made = _attempt(where, path, "type", partial(context.define, path, keys.get("type"), "reference" in keys))
    problems = [Problem(_unknown(context, path, key, keys[key]), where(path, key)) for key in keys if key not in KEYS]
    if made:
        return problems + made
    prim = context.stage.GetPrimAtPath(path)
    done: set[str] = set()
    for name, handle in KEYS.items():
        if handle is not None and (name in keys or name == "collision") and name not in done:
            problems.extend(_attempt(where, path, name, partial(handle, context, prim, keys, name, done)))
    attributes = keys.get("attributes", {})
    if not isinstance(attributes, Mapping):
        return [
            *problems,
            Problem(f"{path}: attributes: write them as a mapping of name to value", where(path, "attributes")),
        ]
    for name, value in attributes.items():
        at = name if where(path, name) != where(path) else "attributes"  # set by the caller, or written in the file
        problems += _attempt(where, path, at, partial(context.set_property, prim, name, value))
    return problems


def _attempt(where: Where, path: str, key: str, action: Callable[[], None]) -> list[Problem]:
    try:
        action()
    except UserError as error:
        return [Problem(f"{path}: {key}: {each}", where(path, key) or where(path)) for each in error.problems]
    except (ValueError, TypeError) as error:
        return [Problem(f"{path}: {key}: {error}", where(path, key) or where(path))]
    return []


def _path_problem(path: str) -> str | None:
    from graph.sim.usd import Sdf

    if not isinstance(path, str) or not is_path(path):
        return f"{path!r} is not the path of a prim; write it as /World/Box (letters, digits and _)"
    sdf = Sdf.Path(path)
    if not sdf.IsAbsolutePath() or not sdf.IsPrimPath():
        return f"{path!r} is not the path of a prim; write it as /World/Box, from the root"
    return f"{path[:80]}... is deeper than {MAX_DEPTH} prims" if sdf.pathElementCount > MAX_DEPTH else None


def _unknown(context: PrimContext, path: str, key: str, value: Any) -> str:
    prim = context.stage.GetPrimAtPath(path)
    if prim and (attribute := _meant([*prim.GetPropertyNames(), *context.own_attributes(prim)], str(key))):
        shown = json.dumps(value) if isinstance(value, (bool, int, float)) else "..."
        hint = f'; did you mean attributes: {{"{attribute}": {shown}}}?'
    else:
        hint = did_you_mean(OTHER_WORDS.get(str(key).lower(), str(key)), KEYS, "set USD attributes under attributes")
    return f'{path}: there is no key "{key}"{hint}'


def _meant(properties: Sequence[str], key: str) -> str | None:
    """The attribute that this key means: the tick rate of a sensor, or the attribute of that name."""
    if key.lower().replace("_", "") in RATES and TICK_RATE in properties:
        return TICK_RATE
    return ending_alike(properties, key)
