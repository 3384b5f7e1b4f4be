"""Nodes of robots: drives of wheels, grippers, conveyors, and the following of paths."""
