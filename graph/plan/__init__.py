"""From what a file says to graphs that run."""

from graph.evaluate import ComputeError, Graph, Node, RunawayError

from .compiler import compile_graphs
from .types import Known

__all__ = ["ComputeError", "Graph", "Known", "Node", "RunawayError", "compile_graphs"]
