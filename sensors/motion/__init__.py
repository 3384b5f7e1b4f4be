"""How prims move between physics states: what was kept of the past, and poses in between."""
