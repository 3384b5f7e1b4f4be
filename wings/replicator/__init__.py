"""Nodes of Replicator and SyntheticData: random poses, prims by path, events of frames, render variables, images."""
