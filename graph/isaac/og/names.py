"""Turns the forms in which scripts name graphs, nodes and attributes into text."""

from __future__ import annotations

from typing import Any

from graph.editing.errors import OmniGraphError
from graph.evaluate import Graph, Node


def node_text(spec: Any, what: str = "node") -> str:
    """The name or path of a node: from text, a path object, a node, or (name, graph)."""
    if isinstance(spec, (Node, Graph)):
        return spec.path
    if isinstance(spec, tuple) and len(spec) == 2:
        name, graph = spec
        text = node_text(name, what)
        return text if text.startswith("/") or graph is None else f"{node_text(graph, 'graph')}/{text}"
    text = spec if isinstance(spec, str) else getattr(spec, "path", None) or str(spec)
    if not isinstance(text, str) or not text or text.startswith("<"):
        raise OmniGraphError(f"{spec!r} is not a legal {what}; give its name or its path")
    return text


def end_text(spec: Any) -> str:
    """`node.inputs:x` of an attribute: from text, a path object, an attribute, or (attribute, node)."""
    if isinstance(spec, tuple) and len(spec) in (2, 3):
        attribute, *owner = spec
        if owner[0] is None:
            return end_text(attribute)
        return f"{node_text(tuple(owner) if len(owner) == 2 else owner[0])}.{attribute_text(attribute)}"
    text = spec if isinstance(spec, str) else getattr(spec, "path", None) or str(spec)
    owner_name, dot, attribute_name = str(text).rpartition(".")
    if not isinstance(text, str) or not dot or not owner_name or not attribute_name or text.startswith("<"):
        raise OmniGraphError(f"{text!r} is not a legal attribute; write node.inputs:name or a path")
    return text


def attribute_text(spec: Any) -> str:
    """The name of an attribute, `inputs:x` or `x`, from text or an attribute."""
    text: Any = spec if isinstance(spec, str) else getattr(spec, "full_name", None) or str(spec)
    if not isinstance(text, str) or not text or text.startswith("<"):
        raise OmniGraphError(f"{spec!r} is not a legal attribute; write inputs:name")
    return text.rpartition(".")[2]


def listed(entries: Any) -> list[Any]:
    """The entries of one key: a single entry may stand for a list of one."""
    if isinstance(entries, list):
        return entries
    if isinstance(entries, tuple) and entries and all(isinstance(one, (tuple, list)) for one in entries):
        # Tuples of tuples are lists; but (("inputs:a", node), 1) is one entry.
        return list(entries) if all(len(one) >= 2 and not _is_end(one) for one in entries) else [entries]
    return [entries]


def _is_end(entry: Any) -> bool:
    """Whether it is (attribute, node), which is a part of an entry and not a whole entry."""
    if len(entry) != 2 or isinstance(entry[1], Node):
        return len(entry) == 2
    first, second = entry
    texts = isinstance(first, str) and isinstance(second, str)
    return texts and first.startswith(("inputs:", "outputs:", "state:")) and "." not in second
