"""Nodes that run Python code from a graph file, only if the user allows it."""
