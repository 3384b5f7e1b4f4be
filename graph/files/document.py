"""A graph file as plain data: the keys of the format, with dicts, lists, numbers and texts, ready to be written."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from graph.base.errors import Problem, UserError
from graph.spec.file_spec import GraphSpec, NodeSpec

from . import json_text
from .paths import is_own_file
from .source import file_format, read
from .tree import Map


def parsed(path: Path, name: str) -> tuple[Map, str]:
    """The tree of a YAML or JSON graph file, with values as written, and its text."""
    source = read(path, name)
    if file_format(name) == "json":
        parse = json_text.parse
    else:
        from .yaml_text import parse
    problems: list[Problem] = []
    root, _ = parse(source, problems)
    if problems or not isinstance(root, Map):
        raise UserError(problems or f"{name}: a graph file is a mapping")
    return root, source.text


def graph_document(graph: GraphSpec) -> dict[str, Any]:
    """A graph as written below `graphs:`; values equal to the default are left out."""
    document: dict[str, Any] = {}
    if graph.evaluator != "execution":
        document["evaluator"] = graph.evaluator
    if graph.pipeline_stage != "simulation":
        document["pipeline_stage"] = graph.pipeline_stage
    if graph.evaluation_mode != "automatic":
        document["evaluation_mode"] = graph.evaluation_mode
    if graph.saved:
        document["lenient"] = True
    if graph.instances:
        document["instances"] = {prim: dict(values) for prim, values in graph.instances.items()}
    if graph.variables:
        document["variables"] = {
            name: {"type": one.type} | ({} if one.value is None else {"value": one.value})
            for name, one in graph.variables.items()
        }
    if graph.nodes:
        document["nodes"] = {node.name: _node(node) for node in graph.nodes}
    if graph.connections:
        document["connections"] = [f"{one.source} -> {one.target}" for one in graph.connections]
    return document


def _node(node: NodeSpec) -> Any:
    state = {key.removeprefix("state:"): value for key, value in node.inputs.items() if key.startswith("state:")}
    inputs = {key: value for key, value in node.inputs.items() if not key.startswith("state:")}
    if not state and not inputs and not node.attributes:
        return node.type
    parts = {"inputs": inputs, "state": state, "attributes": dict(node.attributes)}
    return {"type": node.type, **{key: values for key, values in parts.items() if values}}


def relocated(document: Mapping[str, Any], old: Path, new: Path) -> dict[str, Any]:
    """The same document, with its file names relative to another folder."""
    if old.resolve() == new.resolve():
        return dict(document)

    def moved(text: Any) -> Any:
        return Path(os.path.relpath(old / text, new)).as_posix() if isinstance(text, str) else text

    return _with_files(document, moved)


def _with_files(document: Mapping[str, Any], moved: Callable[[Any], Any]) -> dict[str, Any]:
    """The document with `moved` applied to every file name in it."""
    scene = document.get("scene")
    if not isinstance(scene, Mapping):
        return dict(document)
    scene = dict(scene)
    for key in ("usd", "mjcf", "urdf"):
        if key in scene:
            scene[key] = moved(scene[key])
    if isinstance(scene.get("prims"), Mapping):
        scene["prims"] = {path: _prim(prim, moved) for path, prim in scene["prims"].items()}
    return {**document, "scene": scene}


def named_files(document: Mapping[str, Any]) -> list[str]:
    """The file names in it, as written, each once."""
    found: dict[str, None] = {}

    def note(text: Any) -> Any:
        if isinstance(text, str):
            found[text] = None
        return text

    _with_files(document, note)
    return list(found)


def _prim(prim: Any, moved: Callable[[Any], Any]) -> Any:
    if not isinstance(prim, Mapping):
        return prim
    prim = dict(prim)
    for key in ("config", "reference"):
        text = prim.get(key)
        if isinstance(text, str) and is_own_file(key, text):
            prim[key] = moved(text)
    return prim


def simple(value: Any) -> Any:
    """The value as plain Python types, without subclasses and fractions, as the writers need it."""
    if isinstance(value, Mapping):
        return {str(key): simple(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [simple(item) for item in value]
    if isinstance(value, Fraction):
        return str(value)
    return value
