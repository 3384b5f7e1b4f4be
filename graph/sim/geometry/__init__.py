"""Geometry for rays, as triangles: every kind of prim with a surface."""
