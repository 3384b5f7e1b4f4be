import math

import numpy as np
import pytest
from pxr import UsdSkel

from graph.sim.geometry.collect import collect_geometry
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Gf, UsdGeom, UsdShade
from tests.support.collected_meshes import geometry_of, volume


def curve(stage, points, counts, widths, **attributes):
    prim = UsdGeom.BasisCurves.Define(stage, "/Curve")
    prim.CreatePointsAttr(points)
    prim.CreateCurveVertexCountsAttr(counts)
    prim.CreateWidthsAttr(widths)
    prim.SetWidthsInterpolation("constant")
    for name, value in attributes.items():
        prim.GetPrim().GetAttribute(name).Set(value)
    return prim


def test_a_straight_curve_is_a_cylinder_of_its_width():
    stage = open_stage()
    curve(stage, [(0, 0, 0), (0, 0, 2), (1, 0, 0), (1, 0, 3)], [2, 2], [0.2], type="linear")
    parts, warnings = geometry_of(stage, 1e-5)
    assert warnings == []
    assert volume(parts["/Curve"]) == pytest.approx(math.pi * 0.01 * 5, rel=1e-3)


def test_a_ring_of_bezier_curves_is_a_torus():
    stage, k = open_stage(), 0.5522847498  # the best cubic for a quarter of a circle
    quarter = [(1, 0), (1, k), (k, 1), (0, 1), (-k, 1), (-1, k), (-1, 0), (-1, -k), (-k, -1), (0, -1), (k, -1), (1, -k)]
    curve(stage, [(x, y, 0) for x, y in quarter], [12], [0.2], wrap="periodic")
    parts, _ = geometry_of(stage, 1e-4)
    assert volume(parts["/Curve"]) == pytest.approx(2 * math.pi**2 * 0.01, rel=3e-3)


@pytest.mark.parametrize(
    ("basis", "wrap", "ends"),
    [("bspline", "nonperiodic", (1, 3)), ("bspline", "pinned", (0, 4)), ("catmullRom", "pinned", (0, 4))],
)
def test_splines_begin_and_end_where_usd_says(basis, wrap, ends):
    stage = open_stage()
    curve(stage, [(x, 0, 0) for x in range(5)], [5], [0.2], basis=basis, wrap=wrap)
    parts, _ = geometry_of(stage)
    along = parts["/Curve"].vertices[:, 0]
    assert (along.min(), along.max()) == pytest.approx(ends)


def test_points_are_spheres_and_curves_without_widths_are_reported():
    stage = open_stage()
    points = UsdGeom.Points.Define(stage, "/Points")
    points.CreatePointsAttr([(0, 0, 0), (5, 0, 0)])
    points.CreateWidthsAttr([1, 2])
    bare = UsdGeom.BasisCurves.Define(stage, "/Bare")
    bare.CreatePointsAttr([(0, 0, 0)] * 4)
    bare.CreateCurveVertexCountsAttr([4])
    parts, warnings = geometry_of(stage)
    assert volume(parts["/Points"]) == pytest.approx(math.pi / 6 * 9, rel=5e-3)
    assert [warning[:2] for warning in warnings] == [("bad-geometry", "/Bare")]


def test_a_nurbs_patch_of_a_quarter_cylinder_is_exact_at_its_vertices():
    stage, w = open_stage(), math.sqrt(0.5)
    patch = UsdGeom.NurbsPatch.Define(stage, "/Patch")
    patch.CreatePointsAttr([(1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 2), (1, 1, 2), (0, 1, 2)])
    patch.CreatePointWeightsAttr([1, w, 1, 1, w, 1])
    for name, value in (("u", (3, 3, [0, 0, 0, 1, 1, 1])), ("v", (2, 2, [0, 0, 1, 1]))):
        for kind, each in zip(("VertexCount", "Order", "Knots"), value, strict=True):
            patch.GetPrim().GetAttribute(f"{name}{kind}").Set(each)
    parts, _ = geometry_of(stage)
    vertices = parts["/Patch"].vertices
    assert np.hypot(vertices[:, 0], vertices[:, 1]) == pytest.approx(1.0)
    assert np.ptp(vertices[:, 2]) == 2


def test_a_tetrahedral_mesh_is_its_outside():
    stage = open_stage()
    tets = UsdGeom.TetMesh.Define(stage, "/Tets")
    tets.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
    tets.CreateTetVertexIndicesAttr([Gf.Vec4i(0, 1, 2, 3), Gf.Vec4i(1, 2, 3, 4)])
    parts, _ = geometry_of(stage)
    assert len(parts["/Tets"].triangles) == 6
    assert volume(parts["/Tets"]) == pytest.approx(1 / 6 + 1 / 3)


def test_a_capsule_with_two_radii_is_two_half_spheres_and_a_frustum():
    stage = open_stage()
    capsule = UsdGeom.Capsule_1.Define(stage, "/Capsule")
    for name, value in (("radiusBottom", 1.0), ("radiusTop", 0.5), ("height", 2.0)):
        capsule.GetPrim().GetAttribute(name).Set(value)
    parts, _ = geometry_of(stage)
    true = math.pi * 2 / 3 * (1 + 0.125) + math.pi * 2 / 3 * (1 + 0.5 + 0.25)
    assert volume(parts["/Capsule"]) == pytest.approx(true, rel=2e-3)


def box_with_subsets(stage, path="/Box"):
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh.CreatePointsAttr(corners)
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([index for face in faces for index in face])
    for name, indices in (("Bottom", [0]), ("Top", [1, 0, 77])):
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", indices, "materialBind")
        material = UsdShade.Material.Define(stage, f"/Looks/{name}")
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    return mesh


def test_each_subset_is_a_surface_of_its_own_and_the_rest_is_the_mesh():
    stage = open_stage()
    box_with_subsets(stage)
    parts, warnings = geometry_of(stage)
    assert {path: (len(part.triangles), part.material) for path, part in parts.items()} == {
        "/Box": (8, None),
        "/Box/Bottom": (2, "/Looks/Bottom"),
        "/Box/Top": (2, "/Looks/Top"),
    }
    assert parts["/Box/Top"].vertices[:, 2].tolist() == [1] * 4
    ((_, _, message),) = warnings
    assert "Top names 1 faces that do not exist" in message
    assert "shares faces" in message


def test_copies_of_an_instancer_hit_like_equal_references():
    stage = open_stage()
    UsdGeom.Xform.Define(stage, "/World")
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Copies")
    UsdGeom.Xform.Define(stage, "/World/Copies/Tree").AddTranslateOp().Set((0, 0, 1))
    box_with_subsets(stage, "/World/Copies/Tree/Box")
    UsdGeom.Sphere.Define(stage, "/World/Copies/Tree/Ball").CreateRadiusAttr(0.3)
    instancer.CreatePrototypesRel().SetTargets(["/World/Copies/Tree"])
    instancer.CreateProtoIndicesAttr([0, 0, 0, 0])
    places, turns, sizes = [(0, 0, 0), (5, 1, 2), (9, 9, 9), (-3, 0, 1)], [0, 90, 10, 45], [1, 2, 1, 0.5]
    instancer.CreatePositionsAttr(places)
    instancer.CreateOrientationsfAttr([Gf.Quatf(Gf.Rotation((0, 0, 1), a).GetQuat()) for a in turns])
    instancer.CreateScalesAttr([(s, s, s) for s in sizes])
    instancer.CreateIdsAttr([10, 11, 12, 13])
    instancer.CreateInvisibleIdsAttr([12])
    for number in (0, 1, 3):
        copy = UsdGeom.Xform.Define(stage, f"/World/Ref{number}")
        copy.AddTranslateOp().Set(places[number])
        copy.AddRotateZOp().Set(turns[number])
        copy.AddScaleOp().Set((sizes[number],) * 3)
        inner = stage.DefinePrim(f"/World/Ref{number}/Tree")
        inner.GetReferences().AddInternalReference("/World/Copies/Tree")
    parts, _ = geometry_of(stage)
    for number in (0, 1, 3):
        for name in ("Box", "Box/Bottom", "Box/Top"):
            copy, ref = parts[f"/World/Copies[{number}]/{name}"], parts[f"/World/Ref{number}/Tree/{name}"]
            assert copy.vertices == pytest.approx(ref.vertices, abs=1e-6)
            assert copy.triangles.tolist() == ref.triangles.tolist()
            assert copy.material == ref.material
            assert copy.source == f"/World/Copies/Tree/{name}"
        low, high = (getattr(parts[f"/World/Copies[{number}]/Ball"].vertices, each)(axis=0) for each in ("min", "max"))
        assert (low + high) / 2 == pytest.approx(np.add(places[number], (0, 0, sizes[number])), abs=1e-3)
    assert not any("[2]" in path for path in parts)


def test_instancers_nest_and_their_prototypes_may_lie_in_a_class():
    stage = open_stage()
    stage.CreateClassPrim("/Protos")
    UsdGeom.Cube.Define(stage, "/Protos/Leaf").CreateSizeAttr(1.0)
    inner = UsdGeom.PointInstancer.Define(stage, "/Outer/Inner")
    outer = UsdGeom.PointInstancer.Define(stage, "/Outer")
    for prim, targets, places in (
        (inner, ["/Protos/Leaf"], [(0, 0, 1), (0, 0, 2)]),
        (outer, ["/Outer/Inner", "/Outer", "/Gone"], [(10, 0, 0), (20, 0, 0)]),
    ):
        prim.CreatePrototypesRel().SetTargets(targets)
        prim.CreateProtoIndicesAttr([0] * len(places))
        prim.CreatePositionsAttr(places)
    found = collect_geometry(stage, 1e-3)
    middles = sorted(tuple((part.vertices.min(axis=0) + part.vertices.max(axis=0)) / 2) for part in found)
    assert middles == [(10, 0, 1), (10, 0, 2), (20, 0, 1), (20, 0, 2)]


def test_points_of_an_instancer_that_make_no_sense_are_left_out_and_said():
    stage = open_stage()
    instancer = UsdGeom.PointInstancer.Define(stage, "/P")
    UsdGeom.Cube.Define(stage, "/P/Box")
    instancer.CreatePrototypesRel().SetTargets(["/P/Box", "/P"])
    instancer.CreateProtoIndicesAttr([0, 5, 0, 1])
    instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0), (math.nan, 0, 0), (4, 0, 0)])
    parts, warnings = geometry_of(stage)
    assert list(parts) == ["/P[0]"]
    ((code, where, message),) = warnings
    assert (code, where) == ("bad-geometry", "/P")
    assert "1 of its points name prototypes that do not exist and 1 are not finite" in message
    assert "copies itself" in message
    instancer.CreateScalesAttr([(1, 1, 1)])
    parts, warnings = geometry_of(stage)
    assert parts == {}
    assert "do not fit together" in warnings[0][2]


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([(1, 0, 0)] * 3, True),
        ([(1, 0, 0), (2, 1, 3), (3, 2, 6)], True),  # on a line
        ([(1, 0, 0), (2, 1, 3), (3, 2, 6.001)], False),
    ],
)
def test_faces_without_an_area_alone_are_reported(points, said):
    stage = open_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/M")
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    _, warnings = geometry_of(stage)
    assert [message for _, _, message in warnings] == ["its faces have no area; nothing can hit it"] * said


def test_what_a_skeleton_deforms_is_reported():
    stage = open_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/M")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    UsdSkel.BindingAPI.Apply(mesh.GetPrim()).CreateJointIndicesPrimvar(False, 1).Set([0, 0, 0])
    _, warnings = geometry_of(stage)
    assert [(code, where) for code, where, _ in warnings] == [("skinned-shape", "/M")]


def test_shapes_with_time_samples_are_seen_as_at_first_and_said():
    stage = open_stage()
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.GetRadiusAttr().Set(1.0, 0)
    ball.GetRadiusAttr().Set(2.0, 24)
    parts, warnings = geometry_of(stage)
    assert parts["/Ball"].vertices.max() == pytest.approx(1.0)
    assert [warning[:2] for warning in warnings] == [("animated-shape", "/Ball")]
