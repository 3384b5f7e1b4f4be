"""Finds the graphs of a stage: their prims, settings, variables and nodes, compounds and old layouts included."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from graph.spec.file_spec import EvaluationMode, Evaluator, PipelineStage

from .instances import GRAPHS, Users
from .properties import LoneLayer, RawAttribute, lone_layer, properties_of
from .raw_graph import COMPOUND_TYPE, GRAPH_TYPES, KEY, NODE_TYPES, PREFIXES, RawGraph, RawNode, Tell, schemas_of, some
from .variables import VARIABLE, variable_name, variable_type

COMPOUND = "omni.graph.nodes.CompoundSubgraph"
_SETTINGS = ("evaluator:type", "evaluationMode", "pipelineStage")
_EVALUATORS: dict[str, Evaluator] = {"execution": "execution", "push": "push", "dirty_push": "dirty_push"}
_GONE_EVALUATORS: dict[str, Evaluator] = {"pull": "dirty_push", "execution_pull": "execution"}
_MODES: dict[str, EvaluationMode] = {mode: mode for mode in get_args(EvaluationMode)}
_STAGES: dict[str, PipelineStage] = {
    "pipelineStageSimulation": "simulation",
    "pipelineStagePreRender": "pre_render",
    "pipelineStagePostRender": "post_render",
    "pipelineStageOnDemand": "on_demand",
}


def read_graphs(stage: Any, tell: Tell) -> list[RawGraph]:
    """Every graph of a composed stage, in stage order."""
    from graph.sim.usd import Usd

    found: list[RawGraph] = []
    overs: dict[str, list[str]] = {}
    outside: list[str] = []
    users, lone = Users(), lone_layer(stage)
    predicate = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract)
    prims = iter(Usd.PrimRange(stage.GetPseudoRoot(), predicate))
    for prim in prims:
        if prim.IsPseudoRoot():
            continue
        if is_graph(prim):
            prims.PruneChildren()
            for graph in _graph_and_nested(prim, lone, predicate, tell):
                found.append(graph)
                for path in graph.overs:
                    overs.setdefault(graph.path, []).append(path)
        elif is_node(prim):
            outside.append(str(prim.GetPath()))
        elif prim.HasRelationship(GRAPHS):
            users.add(prim)
        elif not prim.IsDefined() and _over_of_node(prim):
            overs.setdefault(str(prim.GetPath().GetParentPath()), []).append(str(prim.GetPath()))
    users.give(found, tell)
    for parent, paths in overs.items():
        message = f"{parent}: {some(paths, 'prim')} only override nodes that no file defines; left out"
        tell("usd-over-only", paths[0], message)
    if outside:
        message = f"{some(outside, 'node')} in no graph; only nodes below an OmniGraph prim compute"
        tell("usd-node-outside", outside[0], message)
    return found


def is_graph(prim: Any) -> bool:
    """Whether a prim is a graph, in the present layout or in the old one."""
    return prim.GetTypeName() in GRAPH_TYPES and prim.IsDefined()


def is_node(prim: Any) -> bool:
    """Whether a prim is a node: by its type, or by a `node:type` if the type is lost."""
    type_name = prim.GetTypeName()
    if type_name not in NODE_TYPES and (type_name or not prim.HasAttribute("node:type")):
        return False
    return bool(prim.IsDefined())


def is_plain_node(prim: Any) -> bool:
    """Whether a prim is a node without nodes inside."""
    if not is_node(prim) or prim.HasAttribute(COMPOUND_TYPE) or "OmniGraphCompoundNodeAPI" in schemas_of(prim):
        return False
    kind = prim.GetAttribute("node:type")
    inside = any(is_node(one) or is_graph(one) for one in prim.GetAllChildren())
    return not inside and not (kind and kind.Get() == COMPOUND)


def _over_of_node(prim: Any) -> bool:
    """Whether an undefined prim looks like an override of a node; shaders and lights have inputs, too."""
    type_name = prim.GetTypeName()
    if type_name:
        return type_name in NODE_TYPES
    names = prim.GetAuthoredPropertyNames()
    if any(name.startswith(("node:type", "ui:nodegraph:node:")) for name in names):
        return not any(name.startswith("info:") for name in names)
    parent = prim.GetParent()
    in_graph = parent.HasAttribute("evaluator:type") or "graph" in parent.GetName().lower()
    return in_graph and any(name.startswith(PREFIXES) for name in names)


def _graph_and_nested(prim: Any, lone: LoneLayer | None, predicate: Any, tell: Tell) -> Iterator[RawGraph]:
    graph = RawGraph(str(prim.GetPath()), prim.GetStage(), lone)
    nested: list[Any] = []
    _settings(prim, graph, tell)
    _collect(prim, graph, "", nested, predicate, tell)
    yield graph
    for inner in nested:
        yield from _graph_and_nested(inner, lone, predicate, tell)


def _collect(prim: Any, graph: RawGraph, prefix: str, nested: list[Any], predicate: Any, tell: Tell) -> None:
    """Adds the nodes below a prim, those of compounds too; other graphs below it are added to `nested`."""

    def below(one: Any, path: str, before: str) -> list[tuple[Any, str, str]]:
        return [(child, f"{path}/", before) for child in one.GetFilteredChildren(predicate)][::-1]

    pending = below(prim, prim.GetPath().pathString, prefix)
    while pending:
        child, parent, before = pending.pop()
        path = child.GetPath()
        text, name = parent + path.name, before + path.name
        if is_node(child):
            node = RawNode(child, path, text, name, graph.lone)
            inside = below(child, text, f"{name}/")
            subgraph = _subgraph(child, node) if inside or node.type == COMPOUND or node.has_compound_type else None
            if subgraph is None and node.type == COMPOUND:
                graph.compounds.append(node)  # its ports lead nowhere
                tell("usd-empty-compound", text, f"{text} is a compound whose graph is missing; it does nothing")
            elif subgraph is None:
                graph.nodes.append(node)
                pending += inside
            else:
                graph.compounds.append(node)
                inner = f"{name}/{subgraph.GetName()}/" if subgraph.GetParent() == child else f"{name}/"
                _collect(subgraph, graph, inner, nested, predicate, tell)
        elif is_graph(child):
            nested.append(child)
        elif not child.IsDefined() and _over_of_node(child):
            graph.overs.append(text)
        elif child.GetTypeName() != "ComputeGraphSettings":
            pending += below(child, text, f"{name}/")


def _subgraph(prim: Any, node: RawNode) -> Any | None:
    """The graph inside a compound node; None for any other node."""
    applied = node.has_compound_type or "OmniGraphCompoundNodeAPI" in schemas_of(prim)
    if node.type != COMPOUND and not applied:
        return None
    kind = prim.GetAttribute(COMPOUND_TYPE)
    if kind and kind.Get() == "nodetype":
        return None
    relationship = prim.GetRelationship("omni:graph:compoundGraph")
    for target in relationship.GetTargets() if relationship else ():
        inner = prim.GetStage().GetPrimAtPath(target)
        if inner and is_graph(inner) and inner.GetPath().HasPrefix(prim.GetPath()):
            return inner
    return next((child for child in prim.GetChildren() if is_graph(child)), None)


def _settings(prim: Any, graph: RawGraph, tell: Tell) -> None:
    values: dict[str, Any] = {}
    for holder in (prim, *(child for child in prim.GetChildren() if child.GetTypeName() == "ComputeGraphSettings")):
        properties = properties_of(holder, holder.GetPath())
        for name in properties.names():
            if name.startswith(VARIABLE):
                _variable(properties.find(name), graph, tell)
            elif name in _SETTINGS and (value := properties.find(name).value) is not None:
                values[name] = value
    evaluator = str(values.get("evaluator:type") or "push")
    if evaluator in _GONE_EVALUATORS:
        graph.evaluator = _GONE_EVALUATORS[evaluator]
        tell(
            "evaluator-gone", graph.path, f'the evaluator "{evaluator}" is gone; {graph.path} runs as {graph.evaluator}'
        )
    elif evaluator in _EVALUATORS:
        graph.evaluator = _EVALUATORS[evaluator]
    else:
        tell("evaluator-unknown", graph.path, f'{graph.path} has the unknown evaluator "{evaluator}"; it runs as push')
    mode = str(values.get("evaluationMode") or "Automatic")
    graph.evaluation_mode = _MODES.get(mode.lower(), "automatic")
    if mode.lower() not in _MODES:
        message = f'{graph.path} has the unknown evaluation mode "{mode}"; it runs as automatic'
        tell("evaluation-mode-unknown", graph.path, message)
    stage = str(values.get("pipelineStage") or "pipelineStageSimulation")
    if stage not in _STAGES:
        tell(
            "stage-unknown",
            graph.path,
            f'{graph.path} has the unknown pipeline stage "{stage}"; it runs with the simulation',
        )
    graph.pipeline_stage = _STAGES.get(stage, "simulation")
    custom = properties_of(prim, prim.GetPath()).custom(KEY)
    graph.custom = custom if isinstance(custom, dict) else {}
    if prim.GetTypeName() == "ComputeGraph":
        tell(
            "usd-old-layout",
            graph.path,
            f"{graph.path} has the old ComputeGraph layout; it is read as an OmniGraph prim",
        )


def _variable(attribute: RawAttribute, graph: RawGraph, tell: Tell) -> None:
    if variable_type(attribute) is not None:
        graph.variables.append(attribute)
        return
    name, type_ = variable_name(attribute), attribute.sdf_type or "a type"
    message = f'{graph.path}: the variable "{name}" is left out; OmniGraph has no type {type_}'
    tell("usd-variable-type", f"{graph.path}.{attribute.name}", message)
