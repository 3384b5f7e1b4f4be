import math
from dataclasses import replace

import numpy as np
import pytest

from graph.sim.geometry.collect import collect_geometry
from graph.sim.geometry.subdivision import Cage, Sharp, refine
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Sdf, UsdGeom

CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def cage_of(points, faces, **sharp):
    counts = np.array([len(face) for face in faces])
    return Cage(np.asarray(points, np.float64), counts, np.concatenate(faces), np.arange(len(faces)), Sharp(**sharp))


CUBE = cage_of(CORNERS, [np.array(quad) for quad in QUADS])
TOP = np.array([[4, 5], [5, 7], [7, 6], [6, 4]])


def grid(side):
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    points = np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], axis=1)
    return points, np.stack([first, first + 1, first + side + 1, first + side], axis=1)


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-3])
def test_the_corners_of_a_cube_go_where_catmull_and_clark_send_them(tolerance):
    # Valence 3: (9 v + 4 (sum of the edges' ends) + (sum of the faces' far corners)) / 24 = (9 + 4 - 1) / 24 = 1 / 2.
    fine = refine(CUBE, "catmullClark", tolerance)
    assert fine.points[:8] == pytest.approx(CORNERS / 2)
    assert fine.points.max() < 1


@pytest.mark.parametrize("tolerance", [0.05, 0.01, 1e-3])
def test_the_tolerance_bounds_the_distance_to_the_limit(tolerance):
    fine = refine(CUBE, "catmullClark", tolerance)
    finer = refine(CUBE, "catmullClark", 1, levels=round(math.log(len(fine.counts) / 6, 4)) + 1)
    quads = fine.points[fine.corners.reshape(-1, 4)]
    off = finer.points[-len(quads) :] - (quads[:, 0] + quads[:, 2]) / 2  # the points that halve the quads lie last
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    distances = np.abs((off * normals).sum(axis=1)) / np.linalg.norm(normals, axis=1)
    assert tolerance / 20 < distances.max() < tolerance


def test_a_regular_grid_is_a_cubic_b_spline():
    points, quads = grid(7)
    points[24, 2] = 1.0  # the middle: (4/6)^2 of its height is left
    fine = refine(cage_of(points, list(quads)), "catmullClark", 1e-3)
    assert fine.points[24] == pytest.approx([3, 3, 4 / 9])


def test_loop_leaves_half_of_a_regular_point_and_its_own_share_of_others():
    points, quads = grid(7)
    points[24, 2] = 1.0
    triangles = [face for quad in quads for face in (quad[[0, 1, 2]], quad[[0, 2, 3]])]
    fine = refine(cage_of(points, triangles), "loop", 1e-3)
    assert fine.points[24] == pytest.approx([3, 3, 0.5])
    corners = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    octahedron = refine(cage_of(corners, [np.array(face) for face in faces]), "loop", 1e-3)
    beta = (5 / 8 - (3 / 8 + math.cos(math.pi / 2) / 4) ** 2) / 4
    assert octahedron.points[:6] == pytest.approx(corners * (1 - 4 / (4 + 3 / (8 * beta))))


def test_a_sharp_ring_of_edges_is_a_b_spline_and_sharp_corners_stay():
    # Along a crease: (1, 4, 1) / 6 of a square's corners, so 2/3 of the way out, in the plane of the ring.
    ring = replace(CUBE, sharp=Sharp(edges=TOP, edge_sharpness=np.full(4, 10.0)))
    assert refine(ring, "catmullClark", 1e-2).points[4:8] == pytest.approx(CORNERS[4:8] * [2 / 3, 2 / 3, 1])
    corners = replace(ring, sharp=replace(ring.sharp, vertices=np.arange(4, 8), vertex_sharpness=np.full(4, 10.0)))
    assert refine(corners, "catmullClark", 1e-2).points[4:8] == pytest.approx(CORNERS[4:8])


def test_a_crease_of_sharpness_one_is_one_sharp_step_and_then_smooth():
    soft = replace(CUBE, sharp=Sharp(edges=TOP, edge_sharpness=np.ones(4)))
    once = refine(replace(CUBE, sharp=Sharp(edges=TOP, edge_sharpness=np.full(4, 10.0))), "catmullClark", 1, levels=1)
    assert len(once.counts) == 24
    # After one level the ring's corners are at 3/4 (1, 1) + 1/8 (two neighbours) = 3/4; then the smooth limit holds.
    before = refine(soft, "catmullClark", 1e-2).points[4:8, :2]
    sharp, smooth = 2 / 3, 1 / 2
    assert (np.abs(before) < sharp).all()
    assert (np.abs(before) > smooth).all()


def test_the_boundary_rules_are_those_of_usd():
    points, quads = grid(5)
    patch = cage_of(points, list(quads))
    assert refine(patch, "catmullClark", 1e-2).points[0] == pytest.approx([0, 0, 0])
    # Without a sharp corner the boundary is a curve through (4 p + p' + p'') / 6.
    assert refine(patch, "catmullClark", 1e-2, boundary="edgeOnly").points[0] == pytest.approx([1 / 6, 1 / 6, 0])
    inner = refine(patch, "catmullClark", 1e-2, boundary="none")
    assert sorted(set(inner.source.tolist())) == [5, 6, 9, 10]


def test_bilinear_keeps_the_cage():
    fine = refine(CUBE, "bilinear", 1e-3)
    assert np.abs(fine.points).max(axis=1) == pytest.approx(1.0)
    assert fine.points[:8].tolist() == CORNERS.tolist()


def mesh_on_a_stage(stage, **attributes):
    mesh = UsdGeom.Mesh.Define(stage, "/M")
    mesh.GetPointsAttr().Set([tuple(point) for point in CORNERS.tolist()])
    mesh.GetFaceVertexCountsAttr().Set([4] * 6)
    mesh.GetFaceVertexIndicesAttr().Set([index for quad in QUADS for index in quad])
    for name, value in attributes.items():
        mesh.GetPrim().GetAttribute(name).Set(value)
    return mesh


def extent(stage, refined, warnings=None):
    (part,) = collect_geometry(
        stage, 1e-2, lambda *each: None if warnings is None else warnings.append(each), refine=refined
    )
    return np.abs(part.vertices).max(), len(part.triangles)


def test_a_mesh_is_its_cage_unless_the_run_or_the_mesh_wants_it_refined():
    stage = open_stage()
    mesh = mesh_on_a_stage(stage)
    assert extent(stage, False) == (1.0, 12)
    size, triangles = extent(stage, True)
    assert size < 0.9
    assert triangles > 100
    mesh.GetPrim().CreateAttribute("refinementEnableOverride", Sdf.ValueTypeNames.Bool).Set(True)
    mesh.GetPrim().CreateAttribute("refinementLevel", Sdf.ValueTypeNames.Int).Set(2)
    assert extent(stage, False)[1] == 6 * 4**2 * 2
    mesh.GetSubdivisionSchemeAttr().Set("none")
    assert extent(stage, True) == (1.0, 12)


def test_creases_on_the_stage_count_and_those_that_do_not_fit_are_reported():
    stage = open_stage()
    mesh_on_a_stage(stage, creaseIndices=[4, 5, 7, 6, 4], creaseLengths=[5], creaseSharpnesses=[10.0], holeIndices=[1])
    (part,) = collect_geometry(stage, 1e-2, refine=True)
    assert part.vertices[:, 2].max() == 1.0
    stage.GetPrimAtPath("/M").GetAttribute("creaseIndices").Set([4, 5, 99])
    warnings = []
    collect_geometry(stage, 1e-2, lambda *each: warnings.append(each), refine=True)
    assert "creases do not fit" in warnings[0][2]
