import numpy as np
import pytest

from graph.sim.geometry.collect import collect_geometry
from graph.sim.geometry.surfaces import Mesh, Plane
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, Vt
from tests.support.collected_meshes import geometry_of, volume
from tests.support.costs import within


def collected(prims, stage=None, tolerance=1e-3):
    stage = stage or open_stage()
    author_prims(stage, prims)
    return geometry_of(stage, tolerance)


def bounds(mesh):
    return mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()


CUBE = {"type": "Cube", "size": 1.0}


def test_nested_transforms_compose_in_metres():
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    parts, _ = collected(
        {
            "/World": {"translate": [100, 0, 0], "rotate": [0, 0, 90]},
            "/World/Arm": {"translate": [200, 0, 0], "scale": [1, 2, 3]},
            "/World/Arm/Box": {"type": "Cube", "size": 100.0},
        },
        stage,
    )
    # Box: 1 m cube scaled to 1 x 2 x 3 m, 2 m along the world's turned X (that is Y), 1 m along X.
    low, high = bounds(parts["/World/Arm/Box"])
    assert low == pytest.approx([0.0, 1.5, -1.5])
    assert high == pytest.approx([2.0, 2.5, 1.5])


def test_a_mirrored_solid_still_faces_out():
    parts, _ = collected({"/A": {**CUBE, "scale": [-1, 2, 1]}, "/B": {"type": "Sphere", "scale": [1, 1, -2]}})
    assert volume(parts["/A"]) == pytest.approx(2.0)
    assert volume(parts["/B"]) > 0


def test_a_left_handed_mesh_faces_out_too():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    flipped = [face[::-1] for face in faces]
    parts, _ = collected(
        {
            "/Right": {"type": "Mesh", "points": points, "faces": faces},
            "/Left": {"type": "Mesh", "points": points, "faces": flipped, "attributes": {"orientation": "leftHanded"}},
        }
    )
    assert volume(parts["/Right"]) == pytest.approx(1 / 6)
    assert volume(parts["/Left"]) == pytest.approx(1 / 6)


def test_what_moves_is_given_in_its_bodys_frame_and_what_cannot_is_static():
    parts, _ = collected(
        {
            "/Body": {"translate": [5, 6, 7], "rotate": [0, 0, 90], "scale": 2, "rigid_body": True},
            "/Body/Box": {**CUBE, "translate": [1, 0, 0]},
            "/Held": {**CUBE, "translate": [0, 0, 9], "rigid_body": True},
            "/Held/Joint": {"type": "PhysicsFixedJoint", "attributes": {"physics:body1": "/Held"}},
            "/Off": {**CUBE, "rigid_body": True, "attributes": {"physics:rigidBodyEnabled": False}},
        }
    )
    box = parts["/Body/Box"]
    assert box.body == "/Body"
    assert bounds(box) == ([1.0, -1.0, -1.0], [3.0, 1.0, 1.0])
    assert parts["/Held"].body is None
    assert bounds(parts["/Held"])[0] == [-0.5, -0.5, 8.5]
    assert parts["/Off"].body is None


def test_copies_of_a_moving_mesh_share_one_key():
    copies = {
        f"/B{i}": {"type": "Sphere", "translate": [0.1 * i, 1 / 3, i], "rotate": [10 * i, 7, 3], "rigid_body": True}
        for i in range(5)
    }
    parts, _ = collected({**copies, "/Other": {"type": "Sphere", "radius": 0.5, "rigid_body": True}})
    assert len({parts[path].unique_key for path in copies}) == 1
    assert parts["/Other"].unique_key != parts["/B0"].unique_key
    assert (parts["/B0"].vertices == parts["/B4"].vertices).all()


def test_only_what_is_seen_is_collected():
    parts, _ = collected(
        {
            "/Shown": CUBE,
            "/Hidden": {"visible": False},
            "/Hidden/Below": CUBE,
            "/Guide": {**CUBE, "attributes": {"purpose": "guide"}},
            "/Proxy": {**CUBE, "attributes": {"purpose": "proxy"}},
            "/Render": {**CUBE, "attributes": {"purpose": "render"}},
        }
    )
    assert list(parts) == ["/Shown", "/Render"]


def test_a_plane_without_sides_is_endless_and_one_with_a_side_is_a_rectangle():
    parts, _ = collected(
        {
            "/Endless": {"type": "Plane", "translate": [0, 0, 2], "rotate": [0, 90, 0]},
            "/Table": {"type": "Plane", "width": 4.0},
        }
    )
    assert isinstance(parts["/Endless"], Plane)
    assert parts["/Endless"].origin.tolist() == [0, 0, 2]
    assert parts["/Endless"].normal == pytest.approx([1, 0, 0])
    assert bounds(parts["/Table"]) == ([-2, -1, 0], [2, 1, 0])


def test_the_tolerance_holds_in_metres_whatever_the_scale():
    parts, _ = collected({"/S": {"type": "Sphere", "radius": 0.01, "scale": 100}})
    a, b, c = (parts["/S"].vertices[parts["/S"].triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    distances = np.einsum("ij,ij->i", normals, a) / np.linalg.norm(normals, axis=1)
    assert 1 - 1e-3 <= distances.min() < 1 - 0.8e-3


def test_instances_are_collected_once_each_and_point_instancers_once_a_point():
    stage = open_stage()
    author_prims(stage, {"/Proto": {"visible": False}, "/Proto/Box": CUBE})
    stage.GetPrimAtPath("/Proto").GetAttribute("visibility").Clear()
    for i in range(2):
        prim = UsdGeom.Xform.Define(stage, f"/Copy{i}").GetPrim()
        prim.GetReferences().AddInternalReference("/Proto")
        prim.SetInstanceable(True)
        UsdGeom.Xformable(prim).AddTranslateOp().Set((10 * i, 0, 0))
    points = UsdGeom.PointInstancer.Define(stage, "/Points")
    points.GetPrototypesRel().SetTargets(["/Proto"])
    points.GetProtoIndicesAttr().Set([0, 0, 0])
    points.GetPositionsAttr().Set([(0, 1, 0), (0, 2, 0), (0, 3, 0)])
    points.GetInvisibleIdsAttr().Set([1])
    parts, warnings = collected({}, stage)
    assert list(parts) == ["/Proto/Box", "/Copy0/Box", "/Copy1/Box", "/Points[0]", "/Points[2]"]
    assert bounds(parts["/Copy1/Box"])[0] == [9.5, -0.5, -0.5]
    assert bounds(parts["/Points[2]"])[0] == [-0.5, 2.5, -0.5]
    assert warnings == []


def test_the_bound_material_is_named():
    parts, _ = collected({"/A": {**CUBE, "material": "aluminum"}, "/B": CUBE})
    assert parts["/A"].material == "/NonVisualMaterials/aluminum"
    assert parts["/B"].material is None


def test_what_cannot_be_cast_is_named():
    stage = open_stage()
    UsdGeom.BasisCurves.Define(stage, "/Curves")
    UsdGeom.Mesh.Define(stage, "/Empty")
    flat = UsdGeom.Cube.Define(stage, "/Flat")
    flat.AddScaleOp().Set((1, 0, 1))
    broken = UsdGeom.Cube.Define(stage, "/Broken")
    broken.AddTranslateOp().Set((float("nan"), 0, 0))
    parts, warnings = collected({}, stage)
    assert parts == {}
    assert [(code, where) for code, where, _ in warnings] == [
        ("bad-geometry", "/Curves"),
        ("bad-geometry", "/Empty"),
        ("bad-transform", "/Flat"),
    ]
    assert warnings[-1][2].endswith("the same holds for /Broken")


def test_animated_prims_stand_where_their_first_sample_puts_them():
    stage = open_stage()
    cube = UsdGeom.Cube.Define(stage, "/A")
    cube.GetSizeAttr().Set(1.0)
    cube.AddTranslateOp().Set((3, 0, 0), 1.0)
    parts, _ = collected({}, stage)
    assert bounds(parts["/A"])[0] == [2.5, -0.5, -0.5]


def test_a_mesh_of_a_hundred_thousand_triangles_takes_a_moment():
    side = 225
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    points = np.stack([x.ravel(), y.ravel(), np.sin(x.ravel())], axis=1).astype(np.float32)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    quads = np.stack([first, first + 1, first + side + 1, first + side], axis=1).astype(np.int32)
    stage = open_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/Terrain")
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points))
    mesh.GetFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(np.full(len(quads), 4, np.int32)))
    mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(quads.ravel()))
    with within(2):
        (found,) = collect_geometry(stage, 1e-3)
    assert isinstance(found, Mesh)
    assert found.triangles.shape == (2 * 224 * 224, 3)
