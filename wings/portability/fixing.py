"""`graph check --fix`: applies the safe fixes of findings to the text of a YAML or JSON graph file.

Only the text of a value or key changes; every other byte, comments too, stays.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.inputs import read_text
from graph.base.outputs import write
from graph.sim import settings as keys

from .report import Finding
from .rules import OVRTX

if TYPE_CHECKING:
    from graph.spec.file_spec import FileSpec

CORE = "omni:sensor:Core:"
TICK, FRAME = "omni:sensor:tickRate", "omni:sensor:frameRate"
Key = tuple[str, ...]
DROP = object()
"""The value of a key that is to be removed."""
SUFFIXES = (".yaml", ".yml", ".json")
SETTINGS: dict[str, tuple[str, Any]] = {
    "radar-motion-bvh-off": (keys.MOTION_BVH, True),
    "motion-compensation-off": (keys.MOTION_BVH, True),
    "normals-off": ("/app/sensors/nv/lidar/publishNormals", True),
    "stable-ids-off": ("/rtx-transient/stableIds/enabled", True),
    "multi-tick-off": (keys.MULTI_TICK, True),
}
"""Settings that mend a finding."""


def fix_file(file: Path, spec: FileSpec, findings: Sequence[Finding], target: str) -> list[str]:
    """Applies what is safe and written in the file itself; returns a line for each change.

    Raises UserError for a file of another kind, OSError if it cannot be read or written.
    """
    if file.suffix.lower() not in SUFFIXES:
        raise UserError(f"{file}: --fix changes YAML and JSON graph files; convert it with graph convert")
    text = before = read_text(file, "file.json")
    done: dict[str, None] = {}
    for one in findings:
        for key, value in _changes(one, spec, target):
            changed = changed_text(text, key, value)
            if changed != text:
                text = changed
                said = "removed" if value is DROP else f"= {_shown(value)}"
                done[f"fixed {one.rule.code}: {'.'.join(key)} {said}"] = None
    if text != before:
        write(file, text)
    return list(done)


def _changes(one: Finding, spec: FileSpec, target: str) -> Iterator[tuple[Key, Any]]:
    """The keys of the file to set or remove."""
    code, (path, _, name) = one.rule.code, one.subject.partition(".")
    if code in SETTINGS:
        yield ("settings", SETTINGS[code][0]), SETTINGS[code][1]
    elif code == "output-buffer-on-gpu":
        yield ("settings", one.subject), False
    elif code == "catch-up-cap" and keys.MIN_FRAME_RATE not in spec.settings:
        yield ("settings", keys.MIN_FRAME_RATE), 0  # no cap, as here without the setting
    elif path in spec.scene.prims:
        yield from _prim_changes(code, path, spec, target)
    else:
        for graph in spec.graphs:
            if path.startswith(f"{graph.path}/"):
                inputs = ("graphs", graph.path, "nodes", path.removeprefix(f"{graph.path}/"), "inputs")
                if code == "full-scan-deprecated":
                    yield (*inputs, name.removeprefix("inputs:")), DROP
                elif code == "system-time-never-resets":
                    yield (*inputs, "resetSimulationTimeOnStop"), False


def _prim_changes(code: str, path: str, spec: FileSpec, target: str) -> Iterator[tuple[Key, Any]]:
    written = spec.scene.prims[path]
    attributes = written.get("attributes") or {}
    prim = ("scene", "prims", path)
    if code == "lidar-partial-scan":
        if f"{CORE}accumulateOutputs" in attributes:
            yield (*prim, "attributes", f"{CORE}accumulateOutputs"), True
        if TICK in attributes and "config" in written:
            scan = attributes.get(f"{CORE}scanRateBaseHz") or _scan_rate(written)
            yield (*prim, "attributes", TICK), int(scan) if scan == int(scan) else float(scan)
    elif code == "sensor-api-missing":
        yield (*prim, "schemas"), [*(written.get("schemas") or ()), "OmniSensorAPI"]
    elif code == "isaac-vocabulary" and target == OVRTX:
        yield from _renamed(attributes, prim, TICK, FRAME, lambda rate: [rate, 1])
        yield from _renamed(attributes, prim, f"{CORE}accumulateOutputs", f"{CORE}partialOutputs", lambda on: not on)
    elif code == "ovrtx-vocabulary":
        yield from _renamed(attributes, prim, FRAME, TICK, lambda ratio: ratio[0] / ratio[1])
        yield from _renamed(attributes, prim, f"{CORE}partialOutputs", f"{CORE}accumulateOutputs", lambda on: not on)


def _renamed(
    attributes: Any, prim: Key, old: str, new: str, converted: Callable[[Any], Any]
) -> Iterator[tuple[Key, Any]]:
    if old in attributes:
        yield (*prim, "attributes", new), converted(attributes[old])
        yield (*prim, "attributes", old), DROP


def _scan_rate(written: Any) -> Any:
    from sensors.configs.catalog import find

    return find(written["config"], written.get("variant")).scan_rate_base_hz


# -- text --------------------------------------------------------------------------------------------------------------


def changed_text(text: str, key: Key, value: Any) -> str:
    """The text of a file with one key set or removed; missing mappings on the way are added.

    Unchanged if a value on the way is not a mapping (the short form of a node), or if the key to remove is missing.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.nodes import MappingNode

    mapping = YAML(typ="rt").compose(text)
    for depth, name in enumerate(key):
        if not isinstance(mapping, MappingNode):
            return text
        at = next((n for n, (one, _) in enumerate(mapping.value) if one.value == name), None)
        if at is None:
            if value is DROP:
                return text
            for outer in reversed(key[depth + 1 :]):
                value = {outer: value}
            return _added(text, mapping, name, value)
        if depth == len(key) - 1:
            return _dropped(text, mapping, at) if value is DROP else _replaced(text, mapping.value[at][1], value)
        mapping = mapping.value[at][1]
    return text


def _shown(value: Any) -> str:
    """A value as JSON, which YAML reads too."""
    return json.dumps(value)


def _replaced(text: str, node: Any, value: Any) -> str:
    start, end = node.start_mark.index, node.end_mark.index
    old = text[start:end]
    kept = old[len(old.rstrip()) :]  # what follows a block value belongs to the lines after it
    return f"{text[:start]}{_shown(value)}{kept}{text[end:]}"


def _added(text: str, mapping: Any, name: str, value: Any) -> str:
    """The key at the end of a flow mapping, or in a line after the first of a block mapping."""
    written = f"{json.dumps(name) if ':' in name or mapping.flow_style else name}: {_shown(value)}"
    if mapping.flow_style:
        end = mapping.end_mark.index - 1
        last = mapping.value[-1][1].end_mark.index if mapping.value else end
        return f"{text[:last]}{', ' if mapping.value else ''}{written}{text[last:]}"
    first, content = mapping.value[0]
    indent = " " * first.start_mark.column
    if content.start_mark.line != content.end_mark.line:  # a block: before it, for its end is open
        return f"{text[: first.start_mark.index]}{written}\n{indent}{text[first.start_mark.index :]}"
    line = text.find("\n", content.end_mark.index)
    line = len(text) if line < 0 else line
    return f"{text[:line]}\n{indent}{written}{text[line:]}"


def _dropped(text: str, mapping: Any, at: int) -> str:
    name, content = mapping.value[at]
    start, end = name.start_mark.index, content.end_mark.index
    if mapping.flow_style:
        if at + 1 < len(mapping.value):
            return text[:start] + text[mapping.value[at + 1][0].start_mark.index :]
        before = mapping.value[at - 1][1].end_mark.index if at else start
        return text[:before] + text[end:]
    if len(mapping.value) == 1:  # an empty block would be null
        return f"{text[:start]}{{}}{text[end:]}"
    begin = text.rfind("\n", 0, start) + 1
    line = text.find("\n", start + len(text[start:end].rstrip()))
    return text[:begin] + ("" if line < 0 else text[line + 1 :])
