"""Which prims are solids of a few numbers."""

SOLIDS = ("Cube", "Sphere", "Capsule", "Capsule_1", "Cylinder", "Cylinder_1", "Cone", "Plane")
"""Types of UsdGeom that have a surface given by a few numbers."""
