"""Values that are not finite in every float input of every node: refused in a line, or carried."""

from __future__ import annotations

import math
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import RunError, UserError
from graph.cli.extreme_cases import Case
from graph.files import loads
from graph.node import registry
from graph.node.declaration import Attribute, NodeType
from graph.session.open import open_session
from graph.spec.file_spec import FileSpec
from graph.values.types import Type, parse_type
from nodes.catalog.example import example

AREA = "not finite"
VALUES = (math.nan, math.inf)
RAW = re.compile(r"\b\w+(Error|Warning): ")
EXPLAINED = "give it finite numbers"
"""What stands before a Python exception in a message that names the input."""


class FlawError(Exception):
    """Values that a part takes without a word, or fails over otherwise than in a line."""


@contextmanager
def strict() -> Iterator[None]:
    """Within it NumPy's warnings, which users would see on the terminal, are errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield


def fault(run: Callable[[], Any]) -> str:
    """What is wrong with how this ends: nothing for an end without an error, or with a line."""
    try:
        run()
    except (UserError, RunError) as error:
        return str(error) if RAW.search(str(error)) and EXPLAINED not in str(error) else ""
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def none_of(faults: list[str]) -> float:
    """0 without faults. Raises FlawError, which names the first ones."""
    if faults:
        raise FlawError(f"{len(faults)}: {'; '.join(faults[:3])}")
    return 0.0


def nodes(value: float) -> float:
    """Every node type's example, once for each of its float inputs with this value."""
    with strict(), tempfile.TemporaryDirectory() as folder:
        faults = []
        for kind in registry.all():
            spec = loads(example(kind), folder=Path(folder))
            for name, changed in spoilt(spec, kind, value):
                if found := fault(lambda spec=changed, kind=kind: play(spec, kind)):  # type: ignore[misc]
                    faults.append(f"{kind.short_name}.{name}: {found}")
        return none_of(faults)


def play(spec: FileSpec, kind: NodeType) -> None:
    """Three updates. Raises ArithmeticError if bodies are nowhere after them."""
    with open_session(spec, allow_scripts=kind.runs_code).app as app:
        app.play()
        app.update(3)
        if app.physics is not None and not np.isfinite(app.physics.positions).all():
            raise ArithmeticError("bodies have places that are not finite")


def spoilt(spec: FileSpec, kind: NodeType, value: float) -> Iterator[tuple[str, FileSpec]]:
    """The example with this value in each float input that nothing feeds, and the input's name."""
    graph = spec.graphs[0]
    node = next(one for one in graph.nodes if one.type == kind.id)
    ends = (one.target.rpartition(".") for one in graph.connections)
    fed = {name.removeprefix("inputs:") for owner, _, name in ends if owner == node.name}
    for name, attribute in kind.inputs.items():
        if name in fed:
            continue
        held = with_value(attribute, node.inputs.get(name), value)
        if held is not None:
            changed = replace(node, inputs={**node.inputs, name: held})
            others = tuple(changed if one is node else one for one in graph.nodes)
            yield name, replace(spec, graphs=(replace(graph, nodes=others), *spec.graphs[1:]))


def with_value(attribute: Attribute, present: Any, value: float) -> Any:
    """A value of the attribute's type with `value` in all its numbers; None for one that holds no floats."""
    if isinstance(present, dict) and "value" in present:
        return {**present, "value": filled(present["value"], value)}
    if present is not None and not isinstance(attribute.type, str):
        return filled(present, value)
    kind = parse_type(attribute.type) if isinstance(attribute.type, str) else None
    if not isinstance(kind, Type) or kind.storage not in ("double", "float", "half"):
        return None
    one = np.full(kind.shape, value).tolist()
    return [one] if kind.array else one


def filled(present: Any, value: float) -> Any:
    """The same with `value` for every number."""
    if isinstance(present, list | tuple):
        return [filled(one, value) for one in present]
    return value if isinstance(present, int | float) and not isinstance(present, bool) else present


CASES = (
    Case(AREA, "NaN and Inf in every float input of every node", 0.0, "flaws",
         "a line, or carried as IEEE 754 says", nodes, VALUES),
)  # fmt: skip
