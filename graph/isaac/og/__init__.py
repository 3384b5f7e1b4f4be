"""Makes, changes, reads and evaluates graphs from Python: OmniGraph's Controller.

from graph import Controller
"""

from graph.editing.errors import OmniGraphError, OmniGraphValueError
from graph.editing.graph_set import GraphSet
from graph.evaluate.omnigraph_names import Variable

from .controller import Controller, get_graph_by_path, get_node_by_path, get_registered_nodes
from .handles import Compound
from .keys import GraphEvaluationMode, GraphPipelineStage, Keys, TypedValue

__all__ = [
    "Compound",
    "Controller",
    "GraphEvaluationMode",
    "GraphPipelineStage",
    "GraphSet",
    "Keys",
    "OmniGraphError",
    "OmniGraphValueError",
    "TypedValue",
    "Variable",
    "get_graph_by_path",
    "get_node_by_path",
    "get_registered_nodes",
]
