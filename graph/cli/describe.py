"""Node types as plain data: the JSON of `graph nodes` and `graph node`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.node.declaration import Attribute, NodeType


def node_type_as_dict(node_type: NodeType) -> dict[str, Any]:
    """A node type as plain data, with the names of the graph format; a missing default is null."""
    described: dict[str, Any] = {
        "version": node_type.version,
        "doc": node_type.doc,
        "origin": node_type.origin,
        "inputs": _attributes(node_type.inputs),
        "outputs": _attributes(node_type.outputs),
        "state": _attributes(node_type.state),
    }
    dynamic = {"inputs": _attributes(node_type.dynamic_inputs), "outputs": _attributes(node_type.dynamic_outputs)}
    if any(dynamic.values()):
        described["dynamic"] = dynamic
    return described


def default_of(attribute: Attribute) -> Any:
    """The declared default as data that JSON can hold (infinity as text), or None."""
    from graph.node.declaration import UNSET

    value = attribute.default
    if value is UNSET:
        return None
    return _plain(value.tolist() if hasattr(value, "tolist") else value)


def _plain(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def type_name(attribute: Attribute) -> str:
    """The declared type in one word; a union as `double | float`."""
    return attribute.type if isinstance(attribute.type, str) else " | ".join(attribute.type)


def first_line(doc: str) -> str:
    """The first line of a description."""
    return doc.partition("\n")[0]


def _attributes(attributes: Mapping[str, Attribute]) -> dict[str, dict[str, Any]]:
    return {name: _attribute(attribute) for name, attribute in attributes.items()}


def _attribute(attribute: Attribute) -> dict[str, Any]:
    described: dict[str, Any] = {
        "type": attribute.type if isinstance(attribute.type, str) else [*attribute.type],
        "default": default_of(attribute),
        "doc": attribute.doc,
    }
    extras = {
        "unit": attribute.unit,
        "optional": attribute.optional,
        "literal_only": attribute.literal_only,
        "output_only": attribute.output_only,
        "allowed_tokens": [*attribute.allowed_tokens],
        "deprecated": attribute.deprecated,
    }
    described |= {key: value for key, value in extras.items() if value}
    bounds = {"minimum": attribute.minimum, "maximum": attribute.maximum}
    return described | {key: value for key, value in bounds.items() if value is not None}
