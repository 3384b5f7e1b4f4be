"""The small world of the tests of nodes, and the command in this process, for those of wings."""

from tests.graph.cli.conftest import folder, graph
from tests.nodes.conftest import lidar, stage, world

__all__ = ["folder", "graph", "lidar", "stage", "world"]
