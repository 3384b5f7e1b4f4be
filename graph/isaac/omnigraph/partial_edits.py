"""Edits of which entries may exist already, or fail."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from graph.editing.graph_set import GraphSet
from graph.isaac.og import Controller, OmniGraphError
from graph.isaac.og.keys import ORDER
from graph.isaac.og.names import listed, node_text

from .handles import Node


def split_existing(
    graphs: GraphSet, path: str, commands: dict[str, Any], *, nodes: bool, attributes: bool, prims: bool
) -> dict[str, Node]:
    """Takes entries of what may exist, and does, out of an edit; returns the nodes among them by their names."""
    found: dict[str, Node] = {}
    if nodes and Controller.Keys.CREATE_NODES in commands:
        left = []
        for entry in listed(commands[Controller.Keys.CREATE_NODES]):
            name = node_text(entry[0])
            there = Node(graphs, name if name.startswith("/") else f"{path}/{name}")
            if there.is_valid() and there.get_type_name() == str(getattr(entry[1], "id", entry[1])):
                found[name] = there
            else:
                left.append(entry)
        commands[Controller.Keys.CREATE_NODES] = left
    if attributes and Controller.Keys.CREATE_ATTRIBUTES in commands:
        left = []
        for entry in listed(commands[Controller.Keys.CREATE_ATTRIBUTES]):
            owner, _, name = str(getattr(entry[0], "path", entry[0])).rpartition(".")
            there = Node(graphs, owner if owner.startswith("/") else f"{path}/{owner}")
            if not (there.is_valid() and there.get_attribute_exists(name)):
                left.append(entry)
        commands[Controller.Keys.CREATE_ATTRIBUTES] = left
    if prims and graphs.app is not None and Controller.Keys.CREATE_PRIMS in commands:
        stage = graphs.app.stage
        commands[Controller.Keys.CREATE_PRIMS] = [
            entry
            for entry in listed(commands[Controller.Keys.CREATE_PRIMS])
            if not stage.GetPrimAtPath(str(entry[0] if isinstance(entry, (tuple, list)) else entry))
        ]
    return found


def one_by_one(controller: Any, graph_id: Any, commands: Mapping[str, Any]) -> None:
    """Makes the entries of an edit one at a time, up to the first that fails, as the product does."""
    path: Any = graph_id
    with suppress(OmniGraphError):
        path = controller.edit(graph_id, {})[0].path
        for key in ORDER:
            for entry in listed(commands.get(key, [])):
                controller.edit(path, {key: [entry]})
