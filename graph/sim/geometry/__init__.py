"""What rays can hit, as triangles: every kind of prim that has a surface."""
