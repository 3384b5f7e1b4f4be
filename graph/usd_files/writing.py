"""Writes a graph file as USD text: OmniGraph prims as Isaac Sim writes them, everything else in customLayerData."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.base.errors import Problem, UserError
from graph.files.document import simple
from graph.node.registry import DEFAULT, Registry
from graph.sim.scene.prim_paths import is_path
from graph.spec.file_spec import FileSpec, GraphSpec, VariableSpec

from . import custom_data
from .hiding import Hiding, scene_graphs
from .json_values import noted
from .node_writing import NodeWriter, write_value
from .raw_graph import COMMENTS, KEY
from .written_links import Links

_EVALUATORS = {"execution": "execution", "push": "push", "dirty_push": "dirty_push"}
_STAGES = {
    "simulation": "pipelineStageSimulation",
    "pre_render": "pipelineStagePreRender",
    "post_render": "pipelineStagePostRender",
    "on_demand": "pipelineStageOnDemand",
}


def layer_of(
    spec: FileSpec,
    other_keys: Mapping[str, Any],
    folder: Path,
    documentation: Mapping[str, str] | None = None,
    registry: Registry = DEFAULT,
    allow: Iterable[Path] = (),
    *,
    skip_outside: bool = False,
) -> Any:
    """An anonymous layer (`Sdf.Layer`) with the content of the file.

    other_keys: the file's keys beside its graphs, as plain data. folder: where the layer will be saved; the scene
    becomes a sublayer relative to it. documentation: comments by place (see `graph.files.comments`); those of the file,
    of a graph or node become documentation of the layer or the prim. allow: further folders in which the scene may have
    files; skip_outside: what lies elsewhere is left out. Graphs that the scene has and the file does not are hidden
    (see `hiding`). Raises UserError if two graphs or nodes would need one prim.
    """
    from graph.sim.usd import Sdf

    documentation = documentation or {}
    _refuse_clashes(spec)
    layer = Sdf.Layer.CreateAnonymous("graphs.usda")
    _document(layer, documentation.get("", ""))
    _scene(layer, spec, folder)
    kept = custom_data.other_keys(other_keys)
    kept["graphs"] = custom_data.texts([graph.path for graph in spec.graphs])
    prims = {"", *(graph.path for graph in spec.graphs)}
    prims.update(f"{graph.path}/{node.name}" for graph in spec.graphs for node in graph.nodes)
    if comments := {place: text for place, text in documentation.items() if place not in prims}:
        kept[COMMENTS] = json.dumps(comments)
    layer.customLayerData = {KEY: kept}
    links = Links(spec, registry)
    with Sdf.ChangeBlock():
        for graph in spec.graphs:
            _graph(layer, graph, links, documentation, registry)
        for graph in spec.graphs:
            _instances(layer, graph)
    if spec.scene.usd is not None:
        Hiding(layer, spec).hide(scene_graphs(spec.scene.usd, allow, skip_outside=skip_outside))
    roots = [prim.name for prim in layer.rootPrims]
    if roots:
        layer.defaultPrim = roots[0]
    return layer


def _refuse_clashes(spec: FileSpec) -> None:

    owner: dict[str, str] = {}
    problems: list[Problem] = []
    for graph in spec.graphs:
        for path, what, mark in (
            (graph.path, f"graph {graph.path}", graph.mark),
            *((f"{graph.path}/{node.name}", f'node "{node.name}" of {graph.path}', node.mark) for node in graph.nodes),
        ):
            if not is_path(path):
                problems.append(Problem(f"{what} cannot be a prim of USD; rename it", mark))
            elif path in owner:
                problems.append(Problem(f"{what} and {owner[path]} would be one prim in USD; rename one", mark))
            owner[path] = what
    if problems:
        raise UserError(problems)


def _scene(layer: Any, spec: FileSpec, folder: Path) -> None:
    """The scene as a sublayer, with its units, which count only in the root layer."""
    from graph.sim.usd import Sdf

    scene = None
    if spec.scene.usd is not None:
        layer.subLayerPaths.append(Path(os.path.relpath(spec.scene.usd, folder)).as_posix())
        scene = Sdf.Layer.FindOrOpen(str(spec.scene.usd))
    root = layer.pseudoRoot
    defaults = {"metersPerUnit": 1.0, "upAxis": "Z"}
    for key in ("metersPerUnit", "upAxis", "kilogramsPerUnit", "timeCodesPerSecond", "startTimeCode", "endTimeCode"):
        if scene is not None and scene.pseudoRoot.HasInfo(key):
            root.SetInfo(key, scene.pseudoRoot.GetInfo(key))
        elif scene is None and key in defaults:
            root.SetInfo(key, defaults[key])


def _graph(layer: Any, graph: GraphSpec, links: Links, documentation: Mapping[str, str], registry: Registry) -> None:
    prim = defined(layer, graph.path, "OmniGraph", "" if layer.subLayerPaths else "Xform")
    _document(prim, documentation.get(graph.path, ""))
    write_settings(prim, graph)
    write_variables(prim, graph.variables)
    for node in graph.nodes:
        node_prim = defined(layer, f"{graph.path}/{node.name}", "OmniGraphNode", "Scope")
        _document(node_prim, documentation.get(f"{graph.path}/{node.name}", ""))
        NodeWriter(node_prim, node, registry).write()
    note_graph(prim, graph, links.write(layer, graph))


def write_settings(prim: Any, graph: GraphSpec) -> None:
    """Writes how and when a graph is evaluated."""
    from graph.sim.usd import Gf, Sdf

    for name, kind, value in (
        ("evaluationMode", Sdf.ValueTypeNames.Token, graph.evaluation_mode.capitalize()),
        ("evaluator:type", Sdf.ValueTypeNames.Token, _EVALUATORS[graph.evaluator]),
        ("fabricCacheBacking", Sdf.ValueTypeNames.Token, "StageWithoutHistory"),
        ("fileFormatVersion", Sdf.ValueTypeNames.Int2, Gf.Vec2i(1, 9)),
        ("pipelineStage", Sdf.ValueTypeNames.Token, _STAGES[graph.pipeline_stage]),
    ):
        (prim.attributes.get(name) or Sdf.AttributeSpec(prim, name, kind)).default = value


def write_variables(prim: Any, variables: Mapping[str, VariableSpec]) -> None:
    """Writes variables that the prim of a graph does not have yet."""
    for name, variable in variables.items():
        attribute = write_value(prim, f"graph:variable:{name}", variable.type, variable.value, note_type=True)
        attribute.displayName = name
        attribute.customData = {**attribute.customData, "scope": "private"}


def note_graph(prim: Any, graph: GraphSpec, links: Sequence[str]) -> None:
    """Records what the prims do not say; links: the records of the connections, see `written_links`."""
    ours: dict[str, Any] = {"connections": custom_data.texts(links)}
    if graph.saved:
        ours["lenient"] = True
    if len(graph.variables) > 1:
        ours["variables"] = noted(graph.variables)
    if any("/" in node.name for node in graph.nodes):  # prims are grouped by parent, whatever came between
        ours["nodes"] = noted(node.name for node in graph.nodes)
    if graph.instances:
        ours["instances"] = json.dumps(simple(graph.instances))
    prim.customData = {KEY: ours}


def _instances(layer: Any, graph: GraphSpec) -> None:
    """Writes, on each prim that has the graph, their order and its own variable values."""
    from graph.sim.usd import Sdf

    for path, values in graph.instances.items():
        if not is_path(path):
            raise UserError(Problem(f"graph {graph.path}: {path} cannot be a prim of USD; rename it", graph.mark))
        prim = layer.GetPrimAtPath(path) or Sdf.CreatePrimInLayer(layer, path)
        prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["OmniGraphAPI"]))
        relationship = prim.relationships.get("omniGraphs") or Sdf.RelationshipSpec(prim, "omniGraphs")
        relationship.targetPathList.explicitItems.append(graph.path)
        for name, value in values.items():
            if f"graph:variable:{name}" not in prim.properties:
                variable = graph.variables.get(name)
                write_value(prim, f"graph:variable:{name}", variable.type if variable else None, value)


def _document(spec: Any, text: str) -> None:
    if text:
        spec.documentation = text


def defined(layer: Any, path: str, type_name: str, parent_type: str) -> Any:
    """The defining prim at `path`; missing parents are created as `parent_type`s."""
    from graph.sim.usd import Sdf

    parent, _, _ = path.rpartition("/")
    if parent and layer.GetPrimAtPath(parent) is None:
        defined(layer, parent, parent_type, parent_type)
    prim = Sdf.CreatePrimInLayer(layer, path)
    prim.specifier = Sdf.SpecifierDef
    if type_name:
        prim.typeName = type_name
    return prim
