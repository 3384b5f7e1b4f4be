"""The motion of prims between physics states: past states, and poses in between."""
