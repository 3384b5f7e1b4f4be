"""`graph show`: draws the graphs of a file as text, Mermaid or DOT: its nodes and edges.

Execution edges carry execution, data edges carry values. An edge is drawn as unknown if the node types do not tell (an
unknown type, a missing node), because a drawing helps when a file does not compile.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from graph.base.errors import UserError
from graph.node import registry
from graph.node.declaration import NodeType
from graph.spec.file_spec import FileSpec, GraphSpec

from .arguments import add_allow, add_nodes, add_skip_outside
from .printing import note_line, problem_line, say, tell


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out of the drawing")
    parser.add_argument(
        "--format",
        choices=("text", "mermaid", "dot"),
        default="text",
        help="text tree, Mermaid flowchart or Graphviz DOT (default: text)",
    )
    parser.add_argument("--values", action="store_true", help="show the values of inputs in pictures too")
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command. Problems of the file are printed, and the rest is drawn: a drawing helps to find mistakes."""
    from graph.files import examine
    from graph.session.partial_compile import without_unknown_types

    examined = examine(args.file, allow=args.allow, skip_outside=args.skip_outside)
    if examined.spec is None:
        raise UserError(examined.problems)
    spec = without_unknown_types(examined.spec) if args.skip_unknown else examined.spec
    drawn = read(spec)
    if args.format == "text":
        lines = as_text(drawn)
    else:
        picture = as_mermaid if args.format == "mermaid" else as_dot
        lines = picture(drawn, values=args.values)
    for line in lines:
        say(line)
    if not spec.graphs:
        tell(f"graph: {args.file}: no graphs in this file, so there is nothing to draw")
    for note in spec.notes:
        tell(note_line(note))
    for problem in examined.problems:
        tell(problem_line(problem))
    return 2 if examined.problems else 0


Kind = Literal["execution", "data", "unknown"]
_SHOWN = 40


@dataclass(frozen=True, slots=True)
class Edge:
    """A connection between two nodes, given by path; attributes without `outputs:` and `inputs:`."""

    source: str
    output: str
    target: str
    input: str
    kind: Kind


@dataclass(frozen=True, slots=True)
class DrawnNode:
    """A node: its path, name, short type (None for a missing node) and the inputs that the file sets."""

    path: str
    name: str
    type: str | None
    inputs: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Drawing:
    """All graphs of a file with their nodes, the ends that belong to no node, and every edge in file order."""

    graphs: tuple[tuple[GraphSpec, tuple[DrawnNode, ...]], ...]
    strangers: tuple[DrawnNode, ...]
    edges: tuple[Edge, ...]


def read(spec: FileSpec) -> Drawing:
    """The drawing of a loaded file."""
    types = _node_types(spec)
    graphs = tuple(
        (graph, tuple(DrawnNode(f"{graph.path}/{n.name}", n.name, _short(n.type), n.inputs) for n in graph.nodes))
        for graph in spec.graphs
    )
    edges = tuple(_edges(spec, types))
    ends = dict.fromkeys(end for edge in edges for end in (edge.source, edge.target) if end not in types)
    return Drawing(graphs, tuple(DrawnNode(path, path.rpartition("/")[2], None) for path in ends), edges)


def as_text(drawing: Drawing) -> Iterator[str]:
    """Every node with its given values and the targets of its outputs: `=>` execution, `->` data, `?>` unknown."""
    arrows = {"execution": "=>", "data": "->", "unknown": "?>"}
    outgoing: dict[str, list[Edge]] = {}
    for edge in drawing.edges:
        outgoing.setdefault(edge.source, []).append(edge)
    for index, (graph, nodes) in enumerate(drawing.graphs):
        if index:
            yield ""
        yield f"{graph.path} ({graph.evaluator}, {graph.pipeline_stage})"
        for name, variable in graph.variables.items():
            yield f"|   variable {name}: {_line(variable.type)} = {_value(variable.value)}"
        for node in nodes:
            last = node is nodes[-1]
            yield f"{'`--' if last else '|--'} {node.name}: {node.type}"
            rail = "    " if last else "|   "
            for key, value in node.inputs.items():
                yield f"{rail}    {_line(key)} = {_value(value)}"
            for edge in outgoing.get(node.path, ()):
                yield f"{rail}    {edge.output} {arrows[edge.kind]} {_relative(edge.target, graph.path)}.{edge.input}"
    for node in drawing.strangers:
        for edge in outgoing.get(node.path, ()):
            yield f"{node.path} (not in this file)"
            yield f"        {edge.output} {arrows[edge.kind]} {edge.target}.{edge.input}"


def as_mermaid(drawing: Drawing, *, values: bool = False) -> Iterator[str]:
    """A Mermaid flowchart: thick arrows are execution, thin ones data, dotted ones unknown."""
    arrows = {"execution": "==>", "data": "-->", "unknown": "-.->"}
    ids = _ids(drawing)
    yield "flowchart LR"
    for index, (graph, nodes) in enumerate(drawing.graphs):
        yield f'  subgraph g{index}["{_mermaid(graph.path)} ({graph.evaluator}, {graph.pipeline_stage})"]'
        for node in nodes:
            yield f'    {ids[node.path]}["{"<br/>".join(map(_mermaid, _label(node, values)))}"]'
        yield "  end"
    for node in drawing.strangers:
        yield f'  {ids[node.path]}["{_mermaid(node.path)}<br/>?"]'
    for edge in drawing.edges:
        label = _mermaid(f"{edge.output} → {edge.input}")
        yield f'  {ids[edge.source]} {arrows[edge.kind]}|"{label}"| {ids[edge.target]}'


def as_dot(drawing: Drawing, *, values: bool = False) -> Iterator[str]:
    """A Graphviz digraph: bold edges are execution, plain ones data, dotted ones unknown."""
    styles = {"execution": "bold", "data": "solid", "unknown": "dotted"}
    ids = _ids(drawing)
    yield "digraph tickgraph {"
    yield "  rankdir=LR; node [shape=box];"
    for index, (graph, nodes) in enumerate(drawing.graphs):
        yield f"  subgraph cluster_{index} {{"
        yield f"    label={_dot(f'{graph.path} ({graph.evaluator}, {graph.pipeline_stage})')};"
        for node in nodes:
            yield f"    {ids[node.path]} [label={_dot(*_label(node, values))}];"
        yield "  }"
    for node in drawing.strangers:
        yield f"  {ids[node.path]} [label={_dot(node.path, '?')}, style=dashed];"
    for edge in drawing.edges:
        label = _dot(f"{edge.output} → {edge.input}")
        yield f"  {ids[edge.source]} -> {ids[edge.target]} [label={label}, style={styles[edge.kind]}];"
    yield "}"


def _node_types(spec: FileSpec) -> dict[str, NodeType | None]:
    """The node type of every node by path; None for an unknown type."""
    found: dict[str, NodeType | None] = {}
    for name in {node.type for graph in spec.graphs for node in graph.nodes}:
        try:
            found[name] = registry.get(name)
        except UserError:
            found[name] = None
    return {f"{graph.path}/{node.name}": found[node.type] for graph in spec.graphs for node in graph.nodes}


def _edges(spec: FileSpec, types: Mapping[str, NodeType | None]) -> Iterator[Edge]:
    for graph in spec.graphs:
        for connection in graph.connections:
            source, output = _end(connection.source, graph.path)
            target, name = _end(connection.target, graph.path)
            kind = _kind(types.get(source), ("outputs", "inputs", "state"), output)
            if kind == "unknown":
                kind = _kind(types.get(target), ("inputs", "state"), name)
            yield Edge(source, _bare(output), target, _bare(name), kind)


def _end(text: str, graph: str) -> tuple[str, str]:
    """Node path and attribute of a connection's end; `/World/G.n.outputs:x` means node n of graph /World/G."""
    node, _, attribute = text.rpartition(".")
    return (node.replace(".", "/") if node.startswith("/") else f"{graph}/{node}"), attribute


def _kind(node_type: NodeType | None, prefixes: Sequence[str], attribute: str) -> Kind:
    prefix, colon, name = attribute.partition(":")
    if colon and prefix in ("inputs", "outputs", "state"):
        prefixes, attribute = (prefix,), name
    for candidate in prefixes if node_type else ():
        declared = node_type.find(candidate, attribute) if node_type else None
        if declared is not None:
            return "execution" if declared.is_execution else "data"
    return "unknown"


def _bare(attribute: str) -> str:
    return attribute.removeprefix("outputs:").removeprefix("inputs:")


def _short(type_id: str) -> str:
    return type_id.rpartition(".")[2]


def _relative(path: str, graph: str) -> str:
    return path.removeprefix(f"{graph}/")


def _ids(drawing: Drawing) -> dict[str, str]:
    nodes: Iterable[DrawnNode] = (*(node for _, nodes in drawing.graphs for node in nodes), *drawing.strangers)
    return {node.path: f"n{index}" for index, node in enumerate(nodes)}


def _label(node: DrawnNode, values: bool) -> list[str]:
    given = [f"{key} = {_value(value)}" for key, value in node.inputs.items()] if values else []
    return [node.name, str(node.type), *given]


def _value(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return _line(text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}...")


def _line(text: str) -> str:
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in text)


def _mermaid(text: str) -> str:
    return _line(text).replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;").replace(">", "&gt;")


def _dot(*lines: str) -> str:
    return '"' + "\\n".join(_line(line).replace("\\", "\\\\").replace('"', '\\"') for line in lines) + '"'
