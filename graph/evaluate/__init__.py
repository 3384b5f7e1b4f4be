"""Evaluates compiled graphs: execution (action), push and dirty_push."""

from .graph import Activation, Graph, by_path
from .node import ComputeError, Node, RunawayError

__all__ = ["Activation", "ComputeError", "Graph", "Node", "RunawayError", "by_path"]
