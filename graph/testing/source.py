"""What a test runs: a graph file, a text or a specification, with the test's own values in it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from graph.base import exact
from graph.base.errors import Problem, UserError
from graph.base.suggest import did_you_mean
from graph.spec.file_spec import FileSpec, GraphSpec, NodeSpec
from graph.spec.migration import migrate


def load_source(source: str | Path | FileSpec | GraphSpec, allow: Sequence[Path] = ()) -> FileSpec:
    """The file that a test names.

    A text with several lines or with a brace at its start is content; any other str is a path.
    """
    from graph.files import load, loads

    if isinstance(source, FileSpec):
        return source
    if isinstance(source, GraphSpec):
        return migrate(FileSpec(folder=Path.cwd(), graphs=(source,)))
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        is_json = source.lstrip().startswith("{")
        return loads(source, name="<text>.json" if is_json else "<text>", allow=allow)
    return load(source, allow=allow)


def changed(
    spec: FileSpec,
    inputs: Mapping[str, Any],
    loop_hz: float | str | Fraction | None,
    settings: Mapping[str, Any],
    fidelity: Mapping[str, Any],
) -> FileSpec:
    """The file with a test's values in place of its own; callables give their value of update 0.

    Raises UserError with every reference to a missing node.
    """
    problems: list[Problem] = []
    graphs = list(spec.graphs)
    for reference, value in inputs.items():
        try:
            index, node, name = _find(graphs, reference)
        except KeyError as error:
            problems.append(Problem(f"inputs: {error.args[0]}"))
            continue
        values = {**node.inputs, name: value(0) if callable(value) else value}
        nodes = tuple(replace(one, inputs=values) if one is node else one for one in graphs[index].nodes)
        graphs[index] = replace(graphs[index], nodes=nodes)
    if problems:
        raise UserError(problems)
    clock = spec.clock if loop_hz is None else replace(spec.clock, loop_hz=exact.rate(loop_hz))
    return replace(
        spec,
        graphs=tuple(graphs),
        clock=clock,
        settings={**spec.settings, **settings},
        fidelity={**spec.fidelity, **fidelity},
    )


def length_in_updates(spec: FileSpec, rate: Fraction) -> int:
    """The file's duration in updates at `rate` [Hz], rounded up; 1 without a duration."""
    return 1 if spec.duration is None else math.ceil(spec.duration * rate)


def _find(graphs: Sequence[GraphSpec], reference: str) -> tuple[int, NodeSpec, str]:
    """Graph index, node and attribute of `node.attr`; the attribute as in the inputs of a NodeSpec."""
    name, dot, attribute = reference.rpartition(".")
    if not dot:
        raise KeyError(f'"{reference}" names no attribute; write node.attribute')
    every = [(index, graph, node) for index, graph in enumerate(graphs) for node in graph.nodes]
    found = [(index, node) for index, graph, node in every if name in (node.name, f"{graph.path}/{node.name}")]
    if len(found) == 1:
        return *found[0], attribute.removeprefix("inputs:")
    if found:
        raise KeyError(f'"{name}" stands in several graphs; write its whole path')
    known = [f"{graph.path}/{node.name}" if "/" in name else node.name for _, graph, node in every]
    raise KeyError(f'there is no node "{name}"{did_you_mean(name, known)}')
