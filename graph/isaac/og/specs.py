"""The spec of a new graph from the dict of an edit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError
from graph.editing.graph_set import GraphSet
from graph.editing.model import SUBGRAPH
from graph.spec.file_spec import GraphSpec
from graph.values.coercion import shown

from .find import graph_path
from .keys import EVALUATORS, MODES, STAGES

_KEYS = ("graph_path", "evaluator_name", "pipeline_stage", "evaluation_mode", "fc_backing_type")


def new_spec(graphs: GraphSet, graph_id: Any) -> GraphSpec:
    """The spec of a new, empty graph. Raises OmniGraphError for an invalid path or setting."""
    path = graph_path(graph_id)
    parts = path.split("/")[1:]
    if not path.startswith("/") or not all(part.replace("_", "a").isalnum() for part in parts):
        raise OmniGraphError(f'"{path}" is not a legal graph; write an absolute prim path such as /World/ActionGraph')
    if graphs.node(path) is not None:
        raise OmniGraphError(f"there is a node at {path}; a graph needs a path of its own")
    owner = graphs.owner_of(path)
    if owner is not None and path[len(owner.path) + 1 :] in owner.spec.compounds:
        inside = f"{path}/{SUBGRAPH}"
        raise OmniGraphError(f"there is a compound at {path}; edit {inside}, what is inside it, or choose another path")
    _refuse_other_prims(graphs, path)
    settings = graph_id if isinstance(graph_id, Mapping) else {}
    for key in settings:
        if key not in _KEYS:
            raise OmniGraphError(f'graph {path}: unknown setting "{key}"{did_you_mean(str(key), _KEYS)}')
    return GraphSpec(
        path,
        evaluator=_choice(path, settings, "evaluator_name", EVALUATORS, "push"),
        pipeline_stage=_choice(path, settings, "pipeline_stage", STAGES, "simulation"),
        evaluation_mode=_choice(path, settings, "evaluation_mode", MODES, "automatic"),
        unfinished=True,
    )


def _refuse_other_prims(graphs: GraphSet, path: str) -> None:
    """Raises OmniGraphError if the path is that of another prim on the stage."""
    from graph.session.stage import GRAPH_PRIMS

    prim = graphs.app.stage.GetPrimAtPath(path) if graphs.app is not None else None
    kind = str(prim.GetTypeName()) if prim else ""
    if kind not in GRAPH_PRIMS:
        raise OmniGraphError(f"{path} is a {kind} on the stage; give the graph another path")


def _choice(path: str, settings: Mapping[str, Any], key: str, choices: Mapping[str, Any], default: str) -> Any:
    written = settings.get(key, default)
    if written not in choices:
        near = did_you_mean(str(written), choices)
        known = ", ".join(dict.fromkeys(choices.values()))
        raise OmniGraphError(f"graph {path}: {key}: {shown(written)} is not one of {known}{near}")
    return choices[written]
