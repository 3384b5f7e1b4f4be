"""Nodes of viewports and cameras (`omni.graph.ui_nodes`) that need no window."""
