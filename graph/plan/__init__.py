"""Compiles graph specs into graphs that run."""

from graph.evaluate import ComputeError, Graph, Node, RunawayError

from .compiler import SKIP_ADVICE, compile_graphs
from .types import Known

__all__ = ["SKIP_ADVICE", "ComputeError", "Graph", "Known", "Node", "RunawayError", "compile_graphs"]
