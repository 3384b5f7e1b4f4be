"""The names used in edits; the same as OmniGraph's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graph.spec.file_spec import EvaluationMode, Evaluator, PipelineStage


class Keys:
    """What an edit can do, as the keys of `Controller.edit`. Their order in the dict does not matter."""

    DELETE_NODES = "delete_nodes"
    CREATE_NODES = "create_nodes"
    CREATE_PRIMS = "create_prims"
    CREATE_ATTRIBUTES = "create_attributes"
    CREATE_VARIABLES = "create_variables"
    EXPOSE_PRIMS = "expose_prims"
    PROMOTE_ATTRIBUTES = "promote_attributes"
    DISCONNECT = "disconnect"
    CONNECT = "connect"
    SET_VALUES = "set_values"


ORDER = tuple(value for name, value in vars(Keys).items() if name.isupper())
"""The order in which the parts of an edit are done."""

FORMS = {
    Keys.DELETE_NODES: "a node",
    Keys.CREATE_NODES: "(name, node type), or (name, dict of an edit) for a compound",
    Keys.CREATE_PRIMS: "a path, (path, type) or (path, {name: (type, value)}, type)",
    Keys.CREATE_ATTRIBUTES: "(node.inputs:name, type)",
    Keys.CREATE_VARIABLES: "(name, type) or (name, type, value)",
    Keys.EXPOSE_PRIMS: "(one of PrimExposureType, prim, node name)",
    Keys.PROMOTE_ATTRIBUTES: "(node.inputs:name, port name)",
    Keys.DISCONNECT: "(source, destination)",
    Keys.CONNECT: "(source, destination)",
    Keys.SET_VALUES: "(node.inputs:name, value) or (node.inputs:name, value, type)",
}
"""The form of an entry of each key."""


class PrimExposureType:
    """How EXPOSE_PRIMS exposes a prim: the node type that reads or writes it."""

    AS_ATTRIBUTES = "omni.graph.nodes.ReadPrimAttributes"
    AS_BUNDLE = "omni.graph.nodes.ReadPrimsBundle"
    AS_WRITABLE = "omni.graph.nodes.WritePrim"


class GraphPipelineStage:
    """Pipeline stages by their names in scripts."""

    GRAPH_PIPELINE_STAGE_SIMULATION: PipelineStage = "simulation"
    GRAPH_PIPELINE_STAGE_PRERENDER: PipelineStage = "pre_render"
    GRAPH_PIPELINE_STAGE_POSTRENDER: PipelineStage = "post_render"
    GRAPH_PIPELINE_STAGE_ONDEMAND: PipelineStage = "on_demand"


class GraphEvaluationMode:
    """Evaluation modes by their names in scripts."""

    GRAPH_EVALUATION_MODE_AUTOMATIC: EvaluationMode = "automatic"
    GRAPH_EVALUATION_MODE_STANDALONE: EvaluationMode = "standalone"
    GRAPH_EVALUATION_MODE_INSTANCED: EvaluationMode = "instanced"


@dataclass(frozen=True, slots=True)
class TypedValue:
    """A value together with its OGN type, for attributes of open type."""

    value: Any
    type: str


EVALUATORS: dict[str, Evaluator] = {
    "execution": "execution",
    "push": "push",
    "dirty_push": "dirty_push",
    "Action Graph": "execution",
    "Push Graph": "push",
    "Lazy Graph": "dirty_push",
}
STAGES: dict[str, PipelineStage] = {
    "simulation": "simulation",
    "pre_render": "pre_render",
    "post_render": "post_render",
    "on_demand": "on_demand",
    "pipelineStageSimulation": "simulation",
    "pipelineStagePreRender": "pre_render",
    "pipelineStagePostRender": "post_render",
    "pipelineStageOnDemand": "on_demand",
}
MODES: dict[str, EvaluationMode] = {
    "automatic": "automatic",
    "standalone": "standalone",
    "instanced": "instanced",
    "Automatic": "automatic",
    "Standalone": "standalone",
    "Instanced": "instanced",
}
