"""Graphs that can be changed while they run: a model of their present state, and the edits of it."""
