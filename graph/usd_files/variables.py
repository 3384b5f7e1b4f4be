"""Graph variables in USD: attributes `graph:variable:NAME` of a graph, and of each prim that has it."""

from __future__ import annotations

from typing import Any

from .json_values import restored
from .properties import RawAttribute, properties_of
from .raw_graph import KEY, ogn_type

VARIABLE = "graph:variable:"


def variable_name(attribute: RawAttribute) -> str:
    """A variable's name, from the name of its attribute."""
    return attribute.name.removeprefix(VARIABLE)


def variable_type(attribute: RawAttribute) -> str | None:
    """The OGN type of a variable, or None; our own writer records types that share a USD type with another."""
    ours = attribute.custom.get(KEY)
    noted = ours.get("type") if isinstance(ours, dict) else None
    return noted if isinstance(noted, str) else ogn_type(attribute)


def variables_of(prim: Any) -> dict[str, Any]:
    """The variable values that a prim gives to its graphs."""
    properties = properties_of(prim, prim.GetPath())
    found = [properties.find(name) for name in properties.names() if name.startswith(VARIABLE)]
    values = ((one, one.value) for one in found)
    return {variable_name(one): restored(value, one.custom) for one, value in values if value is not None}
