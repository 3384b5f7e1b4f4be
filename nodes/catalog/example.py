"""A graph file that shows one node type at work, made from its declaration."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from graph.base.errors import UserError
from graph.node.declaration import CLOSING, UNSET, Attribute, NodeType
from graph.node.registry import DEFAULT, Registry
from graph.plan import compile_graphs
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec
from graph.values.coercion import zero
from graph.values.types import Extended

from .example_parts import THING, Parts, parts_of

# Values to try for an open input, the simplest first.
_SAMPLES: tuple[tuple[str, Any], ...] = (
    ("double", 1.0),
    ("double[3]", [1.0, 2.0, 3.0]),
    ("double[]", [1.0, 2.0, 3.0]),
    ("bool", True),
    ("token", "text"),
    ("int", 1),
    ("double[2]", [1.0, 2.0]),
    ("double[4]", [0.0, 0.0, 0.0, 1.0]),
    ("vectord[3]", [1.0, 2.0, 3.0]),
    ("token[]", ["text"]),
)
_VARIABLE = "gain"
_GRAPH = "/World/Graph"
_TIME = "time.simulationTime"


def example(node_type: NodeType, registry: Registry = DEFAULT) -> str:
    """The text of a YAML graph file with one node of the type, its inputs at their defaults, and what starts it.

    Inputs without a default get a simple value if they need one: numbers, the prim /World/Thing, or the value in
    `nodes.catalog.example_parts`. What the reader must provide stands in a comment at the top.
    """
    name = _node_name(node_type)
    parts = parts_of(node_type)
    values = next((found for found in _candidates(node_type) if _compiles(node_type, found, registry)), {})
    stamps = {target for source, target in _links(node_type, "", parts) if source == _TIME}
    values = {key: value for key, value in values.items() if f".{key}" not in stamps}
    values = _in_order(node_type, {**values, **parts.inputs})
    prims = parts.prims
    if not prims and THING in values.values():
        prims = {THING: f"{{type: {_prim_type(node_type)}}}"}
    lines = [f"# Needs {parts.needs}."] if parts.needs else []
    lines.append("tickgraph: 1")
    if prims:
        lines += ["scene:", "  prims:", *(f"    {path}: {prim}" for path, prim in prims.items())]
    lines += ["graphs:", f"  {_GRAPH}:"]
    if not node_type.has_execution:
        lines.append("    evaluator: push")
    if node_type.phase not in ("", CLOSING):
        lines.append("    pipeline_stage: on_demand")
    if "variableName" in node_type.inputs:
        lines.append(f"    variables: {{{_VARIABLE}: {{type: double, value: 1.0}}}}")
    lines.append("    nodes:")
    links = list(_links(node_type, name, parts))
    if any(source == "tick.tick" for source, _ in links):
        lines.append("      tick: OnPlaybackTick")
    if any(source == _TIME for source, _ in links):
        lines.append("      time: IsaacReadSimulationTime")
    if parts.product:
        lines.append(f"      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: {parts.sensor}}}}}")
    lines += [f"      {name}:", f"        type: {node_type.id}"]
    if values:
        lines.append("        inputs:")
        lines += [
            f"          {_key(key)}: {_written(value)}{_note(node_type.find('inputs', key))}"
            for key, value in values.items()
        ]
    if any(target == "count.execIn" for _, target in links):
        lines.append("      count: Counter")
    if links:
        lines.append("    connections:")
        lines += [f"      - {source} -> {target}" for source, target in links]
    return "\n".join(lines) + "\n"


def _node_name(node_type: NodeType) -> str:
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", node_type.short_name.removeprefix("Ogn"))
    name = "_".join(words).lower() or "node"
    return f"the_{name}" if name in ("tick", "count", "time") else name


def _in_order(node_type: NodeType, values: Mapping[str, Any]) -> dict[str, Any]:
    """The values in the order of the declaration, dynamic inputs last."""
    declared = {name: values[name] for name in node_type.inputs if name in values}
    return {**declared, **values}


def _links(node_type: NodeType, name: str, parts: Parts) -> Iterator[tuple[str, str]]:
    """The connections that start the node, and those that follow it."""
    starts = [one for one, attribute in node_type.inputs.items() if attribute.is_execution]
    ends = [one for one, attribute in node_type.outputs.items() if attribute.is_execution]
    if starts and node_type.event is None:
        start = f"{name}.{'execIn' if 'execIn' in starts else starts[0]}"
        if parts.product:
            yield "tick.tick", "product.execIn"
            yield "product.execOut", start
            yield "product.renderProductPath", f"{name}.renderProductPath"
        else:
            yield "tick.tick", start
        yield from ((_TIME, f"{name}.{stamp}") for stamp in node_type.inputs_as("stamp")[:1])
    if ends:
        yield f"{name}.{'execOut' if 'execOut' in ends else ends[0]}", "count.execIn"


def _candidates(node_type: NodeType) -> Iterator[dict[str, Any]]:
    """Values of the inputs to write: the declared defaults, and for open inputs one choice after the other."""
    targets = [one for one, attribute in node_type.inputs.items() if attribute.type == "target" and one != "graph"]
    main = next((one for one in targets if not node_type.inputs[one].optional), next(iter(targets), ""))
    fixed: dict[str, Any] = {}
    choices: dict[str, list[dict[str, Any]]] = {}
    for name, attribute in node_type.inputs.items():
        if attribute.is_execution or attribute.deprecated:
            continue
        parsed = attribute.parsed
        if isinstance(parsed, Extended):
            accepted = [{"type": kind, "value": value} for kind, value in _SAMPLES if _accepts(parsed, kind)]
            rest = [{"type": one.name, "value": _plain(zero(one))} for one in parsed.members[:1]]
            choices[name] = accepted or rest
        elif name == "variableName":
            fixed[name] = _VARIABLE
        elif name == main:
            fixed[name] = THING
        elif name == "name" and main:
            fixed[name] = "size"
        elif name == "usePath" and main:
            fixed[name] = False
        elif attribute.default is not UNSET:
            fixed[name] = _plain(attribute.default)
    for number in range(max([len(one) for one in choices.values()], default=1)):
        chosen = {name: options[min(number, len(options) - 1)] for name, options in choices.items()}
        yield {name: (fixed | chosen)[name] for name in node_type.inputs if name in fixed or name in chosen}


def _accepts(open_type: Extended, name: str) -> bool:
    return not open_type.members or any(one.name == name for one in open_type.members)


def _compiles(node_type: NodeType, values: Mapping[str, Any], registry: Registry) -> bool:
    variables = {_VARIABLE: VariableSpec("double", 1.0)} if "variableName" in node_type.inputs else {}
    nodes = (NodeSpec("node", node_type.id, values),)
    evaluator = "execution" if node_type.has_execution else "push"
    connections: tuple[ConnectionSpec, ...] = ()
    try:
        compile_graphs([GraphSpec(_GRAPH, nodes, connections, evaluator, variables=variables)], registry)  # type: ignore[arg-type]
    except UserError:
        return False
    return True


def _prim_type(node_type: NodeType) -> str:
    """A prim type that suits the node's targets: a lidar for sensors, else a prim with a transform."""
    from sensors.sensor_types import sensor_types

    docs = " ".join(one.doc for one in node_type.inputs.values() if one.type == "target")
    sensor = "sensor" in docs or "lidar" in docs.lower()
    shown = (f"{name}, {kind.example}" for name, kind in sensor_types().items() if kind.example)
    return next(shown) if sensor else "Cube, rigid_body: true"


def _plain(value: Any) -> Any:
    value = value.tolist() if hasattr(value, "tolist") else value
    return [_plain(one) for one in value] if isinstance(value, (list, tuple)) else value


def _key(name: str) -> str:
    return json.dumps(name) if ":" in name else name


def _written(value: Any) -> str:
    """A value as YAML, on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_written(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_written, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    plain_text = isinstance(value, str) and re.fullmatch(r"[A-Za-z_/][\w/.\[\]]*", value) and "[" not in value
    return str(value) if plain_text and value not in ("true", "false", "null") else json.dumps(value)


def _note(attribute: Attribute | None) -> str:
    if attribute is None:
        return ""
    unit = f" [{attribute.unit}]" if attribute.unit else ""
    doc = " ".join(attribute.doc.split())
    return f"  # {doc}{unit}"
