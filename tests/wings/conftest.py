"""The small world of the tests of nodes, for those of wings."""

from tests.nodes.conftest import lidar, stage, world

__all__ = ["lidar", "stage", "world"]
