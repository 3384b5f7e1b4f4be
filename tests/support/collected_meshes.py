"""What is collected of a stage's geometry, and how much space it encloses."""

import numpy as np

from graph.sim.geometry.collect import collect_geometry


def geometry_of(stage, tolerance=1e-3):
    """The parts of a stage by path, and the warnings that collecting them gave."""
    warnings = []
    found = collect_geometry(stage, tolerance, lambda *warning: warnings.append(warning))
    return {part.path: part for part in found}, warnings


def volume(mesh):
    """The volume of a closed mesh; negative if its triangles face inwards."""
    return volume_within(mesh.vertices, mesh.triangles)


def volume_within(vertices, triangles):
    """The volume within triangles (n, 3) over vertices (m, 3): the sum of tetrahedra to the origin."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6
