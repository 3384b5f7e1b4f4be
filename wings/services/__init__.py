"""Nodes of ROS 2 services: clients and servers of any type, and the stage as services."""
