"""Graphs with messages, as the tests of ROS 2 nodes have them."""

from tests.nodes.ros2.conftest import run_file

__all__ = ["run_file"]
