"""Reads a USD file to a `FileSpec`: the stage is the scene, its OmniGraph prims are the graphs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from graph.base import limits
from graph.base.errors import Mark, Problem, UserError
from graph.base.gc_pause import collector_paused
from graph.files.loading import Examined, examine_text
from graph.files.source import DEPTH_LIMIT
from graph.spec.file_spec import FileSpec, GraphSpec, Note, SceneSpec
from graph.spec.migration import migrate

from .custom_data import KEYS
from .graph_prims import read_graphs
from .json_values import decoded, loaded
from .places import PlacedMark, Text
from .raw_graph import COMMENTS, KEY
from .specs import graph_specs
from .tidying import tidied
from .values import plain


@collector_paused()
def examine(path: Path, name: str, allow: Sequence[Path] = (), *, skip_outside: bool = False) -> Examined:
    """A USD file as a graph file, with all its problems; see `graph.files.examine`."""
    from graph.sim.scene.diagnostics import reading

    notes: list[Note] = []
    try:
        check_text(path, name)
        with reading(name):
            return _examined(path, name, allow, notes, skip_outside=skip_outside)
    except UserError as error:
        return Examined(None, error.problems)


def _examined(path: Path, name: str, allow: Sequence[Path], notes: list[Note], *, skip_outside: bool) -> Examined:
    stage = _open(path, allow, notes, skip_outside=skip_outside)
    text = Text(str(path), name)

    def mark_of(place: str) -> Mark:
        return PlacedMark(text, place)

    def tell(code: str, place: str, message: str) -> None:
        notes.append((code, str(mark_of(place)), message))

    base, problems = _other_keys(path, name, text, allow)
    raw = read_graphs(stage, tell)
    graphs = graph_specs(raw, mark_of, tell)
    graphs = _in_file_order(graphs, path)
    spec = replace(base, path=path, folder=path.parent, graphs=graphs, notes=tuple(notes))
    ours = {graph.path for graph in raw if graph.custom} | {
        node.path for graph in raw for node in graph.nodes if node.custom
    }
    return Examined(tidied(migrate(spec), ours), problems, stage.GetUsedLayers())


def _in_file_order(graphs: tuple[GraphSpec, ...], path: Path) -> tuple[GraphSpec, ...]:
    """Graphs in the order that our own writer recorded; others come last, in stage order."""
    noted = _ours(_layer(path)).get("graphs")
    rank = {name: position for position, name in enumerate(noted)} if isinstance(noted, list) else {}
    return tuple(sorted(graphs, key=lambda graph: rank.get(graph.path, len(rank))))


def _parts(spec: FileSpec) -> Iterator[str]:
    for graph in spec.graphs:
        yield graph.path
        yield from (f"{graph.path}/{node.name}" for node in graph.nodes)


def check_text(path: Path, name: str) -> None:
    """Refuses, by its bytes alone, a text file that is too large, nested too deeply or not USD."""
    from graph.sim.scene.layer_text import BINARY, depth, layer_bytes

    data = layer_bytes(path)
    if data.startswith(BINARY):
        return
    limits.check("usd.text", len(data), f"{name} is too much USD text; save it as .usdc")
    if not data.strip():
        raise UserError(Problem('the file is empty; a USD text file starts with "#usda 1.0"', Mark(name, 1, 1)))
    if not data.startswith(b"#"):
        raise UserError(Problem('this is not USD text; it must start with "#usda 1.0"', Mark(name, 1, 1)))
    _decoded(data, name)
    if b"\0" in data:
        before = data[: data.index(0)]
        place = Mark(name, before.count(b"\n") + 1, len(before) - before.rfind(b"\n"))
        raise UserError(Problem("U+0000 cannot stand in a text file; remove it", place))
    if depth(path.resolve()) > DEPTH_LIMIT:
        raise UserError(f"{name} is nested deeper than {DEPTH_LIMIT} levels; a graph file need not be")


def _decoded(data: bytes, name: str) -> None:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        place = Mark(name, before.count(b"\n") + 1, error.start - before.rfind(b"\n"))
        raise UserError(
            Problem(f"byte 0x{data[error.start]:02X} is not UTF-8; save the file as UTF-8", place)
        ) from None


def _open(path: Path, allow: Sequence[Path], notes: list[Note], *, skip_outside: bool) -> Any:
    from graph.sim.scene.stage import open_stage

    def warn(code: str, where: str, message: str) -> None:
        notes.append((code, where, message))

    return open_stage(path, [path.parent, *allow], warn, skip_outside=skip_outside)


def _other_keys(path: Path, name: str, text: Text, allow: Sequence[Path]) -> tuple[FileSpec, tuple[Problem, ...]]:
    """The keys beside the graphs that our own writer stored, validated as in a graph file."""
    layer = _layer(path)
    scene = SceneSpec(usd=path, mark=PlacedMark(text, "/"))
    document = other_keys(layer)
    if isinstance(document.get("scene"), dict):
        document["scene"].pop("usd", None)  # a sublayer of this file
    if not document:
        return FileSpec(scene=scene), ()
    examined = examine_text(json.dumps({"tickgraph": 1, **document}), f"{name}.json", path.parent, allow)
    problems = tuple(Problem(f"customLayerData.{KEY}: {one.message}", Mark(name, 1, 1)) for one in examined.problems)
    spec = examined.spec or FileSpec()
    kept = spec.scene
    scene = replace(scene, prims=kept.prims, mjcf=kept.mjcf, keyframe=kept.keyframe, is_urdf=kept.is_urdf)
    return replace(spec, scene=scene, marks={}, graphs=()), problems


def other_keys(layer: Any) -> dict[str, Any]:
    """The keys of a graph file, other than its graphs, that a layer stores in `customLayerData.tickgraph`."""
    document: dict[str, Any] = {}
    for key, value in _ours(layer).items() if layer else ():
        if key in ("tickgraph", "graphs", COMMENTS, KEYS):
            continue
        name = key.removesuffix(":json")
        document[name] = value
        if name != key and isinstance(value, str):
            with suppress(ValueError):
                document[name] = loaded(value)
    return document


def _ours(layer: Any) -> dict[str, Any]:
    """The content of a layer's `customLayerData.tickgraph`."""
    ours = plain(dict(layer.customLayerData)).get(KEY)
    return ours if isinstance(ours, dict) else {}


def whole_document(path: Path, graphs: Mapping[str, Any]) -> dict[str, Any]:
    """A USD file as a graph file with these graphs: its stored keys, or itself as the scene."""
    layer = _layer(path)
    document = {"tickgraph": 1, **other_keys(layer)}
    if KEY not in layer.customLayerData:
        document["scene"] = {"usd": path.name}
    noted = _ours(layer).get(KEYS)
    keys = dict.fromkeys(noted if isinstance(noted, list) else ())
    if graphs or "graphs" in keys:
        document["graphs"] = dict(graphs)
    return {key: document[key] for key in {**keys, **document} if key in document}


def documentation(path: Path, spec: FileSpec) -> dict[str, str]:
    """The documentation of a USD file ("") and of its graphs and nodes, by path, and the comments beside them."""
    layer = _layer(path)
    found = {"": layer.documentation, **_comments(layer)}
    for place in _parts(spec):
        prim = layer.GetPrimAtPath(place)
        found[place] = prim.documentation if prim else ""
    return {place: text for place, text in found.items() if text}


def _comments(layer: Any) -> dict[str, str]:
    comments = decoded(_ours(layer), COMMENTS)
    return {str(place): str(text) for place, text in comments.items()} if isinstance(comments, dict) else {}


def _layer(path: Path) -> Any:
    from graph.sim.usd import Sdf

    layer = Sdf.Layer.FindOrOpen(str(path.absolute()))
    if layer is None:
        raise UserError(f"{path}: USD cannot read this file")
    return layer
