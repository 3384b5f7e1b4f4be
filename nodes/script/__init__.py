"""Nodes whose work is Python code that a graph file brings; they run it only where the user allows it."""
