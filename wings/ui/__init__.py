"""Nodes of viewports and cameras (`omni.graph.ui_nodes`) that work without a window."""
