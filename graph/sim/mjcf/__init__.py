"""MJCF models as scenes: read safely, simulated as they are, mirrored as prims so that sensors and graphs see them."""
