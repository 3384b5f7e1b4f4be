"""Evaluates compiled graphs: execution (action), push and dirty_push."""

from .errors import ComputeError, RunawayError
from .graph import Activation, Graph, by_path
from .node import Node

__all__ = ["Activation", "ComputeError", "Graph", "Node", "RunawayError", "by_path"]
