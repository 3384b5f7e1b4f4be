"""Registering node types: a declaration above one `compute` function.

    @node_type(
        "omni.graph.action.Branch",
        version=2,
        inputs={"execIn": Attribute("execution", "activates"), "condition": Attribute("bool", "which", default=False)},
        outputs={"execTrue": Attribute("execution", "if so"), "execFalse": Attribute("execution", "if not")},
    )
    def branch(db: Database) -> None:
        \"\"\"Goes one way or the other.\"\"\"
        db.fire("execTrue" if db.inputs.condition else "execFalse")

`compute(db)` reads `db.inputs.x` and writes `db.outputs.x`; see `Database` for the rest. It returns None or True when
it did its work, and False for "nothing to do": then outputs keep their values and no execution output is followed. A
type without compute (constants) is declared with `declare(...)`.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from graph.base.callables import check_callable

from .declaration import (
    Asks,
    Attribute,
    Check,
    Compute,
    Frames,
    FurtherTopics,
    Hook,
    MessageType,
    NodeType,
    Notes,
    Resolve,
    Specialize,
)
from .registry import DEFAULT, Registry

ComputeFunction = TypeVar("ComputeFunction", bound=Compute)


def node_type(
    type_id: str,
    *,
    version: int = 1,
    inputs: Mapping[str, Attribute] | None = None,
    outputs: Mapping[str, Attribute] | None = None,
    state: Mapping[str, Attribute] | None = None,
    memory: Callable[[], Any] | None = None,
    event: bool | int = False,
    release: Hook | None = None,
    prepare: Hook | None = None,
    resolve: Resolve | None = None,
    specialize: Specialize | None = None,
    phase: str = "",
    runs_code: bool = False,
    check: Check | None = None,
    latent: bool = False,
    needs: Sequence[Sequence[str]] = (),
    message_type: MessageType | None = None,
    notes: Notes | None = None,
    further_topics: FurtherTopics | None = None,
    frames: Frames | None = None,
    asks: Asks | None = None,
    volatile: bool = False,
    dynamic_inputs: Mapping[str, Attribute] | None = None,
    dynamic_outputs: Mapping[str, Attribute] | None = None,
    registry: Registry | None = None,
) -> Callable[[ComputeFunction], ComputeFunction]:
    """Registers the decorated function as the `compute` of a new node type and returns it unchanged.

    The function's docstring is the type's description; the other arguments are the fields of `NodeType`. Raises
    UserError if the id is taken, ValueError for an unknown attribute type or a default that does not fit it.

    >>> from graph.testing import run_node
    >>> types = Registry()  # without registry=, the type is known everywhere
    >>> @node_type(
    ...     "docs.Twice",
    ...     inputs={"x": Attribute("double", "a number", default=0.0)},
    ...     outputs={"y": Attribute("double", "twice the number")},
    ...     registry=types,
    ... )
    ... def compute(db):
    ...     'Double a number.'
    ...     db.outputs.y = 2 * db.inputs.x
    >>> run_node(types.get("docs.Twice"), inputs={"x": 21.0}).values("y")
    [42.0]
    """

    def register(compute: ComputeFunction) -> ComputeFunction:
        check_callable(compute, f"@node_type({type_id!r})")
        line = inspect.unwrap(compute).__code__.co_firstlineno
        (DEFAULT if registry is None else registry).add(
            NodeType(
                type_id,
                version,
                inputs or {},
                outputs or {},
                state or {},
                compute,
                memory,
                _event_order(event),
                release,
                prepare,
                resolve,
                volatile,
                dynamic_inputs or {},
                dynamic_outputs or {},
                inspect.cleandoc(compute.__doc__ or ""),
                f"{compute.__module__}:{line}",
                specialize,
                phase,
                runs_code,
                check,
                latent,
                tuple(map(tuple, needs)),
                message_type,
                notes,
                further_topics,
                frames,
                asks,
            )
        )
        return compute

    return register


def declare(
    type_id: str,
    doc: str,
    *,
    version: int = 1,
    inputs: Mapping[str, Attribute] | None = None,
    outputs: Mapping[str, Attribute] | None = None,
    resolve: Resolve | None = None,
    registry: Registry | None = None,
) -> NodeType:
    """Registers a node type that never computes, such as a constant, and returns it."""
    caller = sys._getframe(1)
    origin = f"{caller.f_globals.get('__name__', '?')}:{caller.f_lineno}"
    declared = NodeType(
        type_id, version, inputs or {}, outputs or {}, resolve=resolve, doc=inspect.cleandoc(doc), origin=origin
    )
    (DEFAULT if registry is None else registry).add(declared)
    return declared


def _event_order(event: bool | int) -> int | None:
    return None if event is False else 0 if event is True else event
