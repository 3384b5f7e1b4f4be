"""MJCF models as scenes: read safely, simulated unchanged, mirrored as prims for sensors and graphs."""
