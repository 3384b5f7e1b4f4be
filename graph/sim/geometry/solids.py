"""The prim types that are solids with a few size attributes."""

SOLIDS = ("Cube", "Sphere", "Capsule", "Capsule_1", "Cylinder", "Cylinder_1", "Cone", "Plane")
"""UsdGeom types whose surface follows from a few numbers."""
