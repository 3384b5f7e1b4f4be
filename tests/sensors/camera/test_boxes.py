"""Boxes, occlusion, clouds and motion against projected extents; NVIDIA's golden values are within 3 px.

Boxes hold the first and the last column and row whose pixel centres are covered.
"""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from graph.sim import App
from sensors.replicator import get_annotator
from tests.support.camera_worlds import FX, add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

FIELDS_2D = [("semanticId", "<u4"), ("x_min", "<i4"), ("y_min", "<i4"), ("x_max", "<i4"), ("y_max", "<i4")]


def label(app, path, text):
    prim = app.stage.GetPrimAtPath(path)
    prim.AddAppliedSchema("SemanticsLabelsAPI:class")
    prim.GetAttribute("semantics:labels:class").Set([text])


def corners(row):
    return tuple(int(row[name]) for name in ("x_min", "y_min", "x_max", "y_max"))


def by_path(found):
    return dict(zip(found["info"]["primPaths"], found["data"], strict=True))


@pytest.fixture
def two_cubes():
    """A of side 1 at z 5 hides most of B of side 1 at (0.5, 0, 7)."""
    with weightless() as app:
        for name, place in (("A", (0, 0, 5)), ("B", (0.5, 0, 7))):
            add_box(app, f"/World/{name}", 1.0, ahead(*place))
            label(app, f"/World/{name}", name.lower())
        yield app


def test_a_tight_box_holds_what_is_seen_and_a_loose_one_what_is_there(two_cubes):
    """B alone covers 77 x 76 pixels, of which 21 x 76 are seen: 1 - 1596 / 5852 = 0.727273 is hidden."""
    tight, loose = look(two_cubes, add_camera(two_cubes), "bounding_box_2d_tight", "bounding_box_2d_loose_fast")
    assert tight["data"].dtype == loose["data"].dtype == np.dtype([*FIELDS_2D, ("occlusionRatio", "<f4")])
    assert {path: corners(row) for path, row in by_path(tight).items()} == {
        "/World/A": (264, 184, 375, 295), "/World/B": (376, 202, 396, 277)
    }  # fmt: skip
    assert {path: corners(row) for path, row in by_path(loose).items()} == {
        "/World/A": (264, 184, 375, 295), "/World/B": (320, 202, 396, 277)
    }  # fmt: skip
    for found in (tight, loose):
        assert [float(row["occlusionRatio"]) for row in found["data"]] == pytest.approx([0.0, 0.727273], abs=1e-6)
        assert found["info"]["idToLabels"] == {0: {"class": "a"}, 1: {"class": "b"}}
        assert found["data"]["semanticId"].tolist() == [0, 1]


def test_an_endless_plane_has_a_box_in_the_image_and_none_in_space():
    """It has no extent; a box of size 0 at its origin would be a lie."""
    with weightless() as app:
        app.add_prims({"/World/Ground": {"type": "Plane", "translate": [0, 0, -1]}})
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        for name in ("Ground", "A"):
            label(app, f"/World/{name}", name.lower())
        names = "bounding_box_2d_loose", "bounding_box_3d", "bounding_box_3d_360"
        loose, space, around = look(app, add_camera(app), *names)
    assert by_path(loose).keys() == {"/World/A", "/World/Ground"}
    assert by_path(space).keys() == by_path(around).keys() == {"/World/A"}


def test_what_is_hidden_has_a_loose_box_and_a_box_in_space_but_no_tight_one():
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 53))
        add_box(app, "/World/B", 1.0, ahead(0, 0, 120))
        add_box(app, "/World/Aside", 1.0, ahead(100, 0, 5))
        for name in ("B", "Aside"):
            label(app, f"/World/{name}", name)
        tight, loose, space, hidden = look(
            *(app, add_camera(app)),
            *("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "occlusion"),
        )
    assert tight["data"].shape == (0,)
    assert loose["info"]["primPaths"] == space["info"]["primPaths"] == ["/World/B"]
    assert hidden.dtype.names == ("instanceId", "semanticId", "occlusionRatio")
    assert hidden["occlusionRatio"].tolist() == [1.0]


def test_a_box_in_space_is_the_extent_in_the_axes_of_the_prim_and_its_pose():
    """Scaled and turned by 90 deg about z: the extent stays +-0.5; row vectors have the translation in the last row."""
    with weightless() as app:
        app.add_prims(
            {
                "/World/Box": {
                    "type": "Cube",
                    "size": 1.0,
                    "translate": list(ahead(1, 0, 5)),
                    "rotate": [0, 0, 90],
                    "scale": [1, 2, 3],
                    "semantics": "box",
                }
            }
        )
        [found] = look(app, add_camera(app), "bounding_box_3d")
    [box] = found["data"]
    assert [float(box[f"{axis}_{end}"]) for end in ("min", "max") for axis in "xyz"] == pytest.approx(
        [-0.5, -0.5, -0.5, 0.5, 0.5, 0.5], abs=1e-5
    )
    expected = [[0, 1, 0, 0], [-2, 0, 0, 0], [0, 0, 3, 0], [1, 0, -5, 1]]
    np.testing.assert_allclose(box["transform"], expected, atol=1e-6)


def test_the_box_in_space_of_a_round_solid_ends_where_the_solid_does():
    """A ball of radius 0.3 about (0, 0.3, 0), under a prim turned by 30 deg and stretched to (2, 1, 1)."""
    with weightless() as app:
        parent = UsdGeom.Xform.Define(app.stage, "/World/Tree")
        parent.AddTranslateOp().Set(Gf.Vec3d(*ahead(0, 0, 9)))
        parent.AddRotateYOp().Set(30.0)
        parent.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))
        top = UsdGeom.Sphere.Define(app.stage, "/World/Tree/Top")
        top.CreateRadiusAttr(0.3)
        top.AddTranslateOp().Set(Gf.Vec3d(0, 0.3, 0))
        label(app, "/World/Tree", "tree")
        [space] = look(app, add_camera(app), "bounding_box_3d")
    [row] = space["data"]
    sides = [float(row[name]) for name in ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max")]
    assert sides == pytest.approx([-0.3, 0.0, -0.3, 0.3, 0.6, 0.3], abs=1e-5)


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_each_copy_of_a_labelled_prototype_is_an_entity(unit):
    """Two trees of two prims, the second turned by a quarter about z and twice as wide: x goes to 2 y, y to -x."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    with App(stage) as app:
        path = "/World/Forest"
        forest = UsdGeom.PointInstancer.Define(app.stage, path)
        forest.AddTranslateOp().Set(Gf.Vec3d(0.5 / unit, 0, 0))
        UsdGeom.Xform.Define(app.stage, f"{path}/Tree")
        for name, size, height in (("Crown", 0.6, 0.3), ("Trunk", 0.3, -0.3)):
            add_box(app, f"{path}/Tree/{name}", size / unit, (0, height / unit, 0))
        label(app, f"{path}/Tree", "tree")
        label(app, f"{path}/Tree/Trunk", "trunk")
        forest.CreatePrototypesRel().SetTargets([f"{path}/Tree"])
        forest.CreateProtoIndicesAttr([0, 0])
        forest.CreatePositionsAttr([(-1 / unit, 2 / unit, -9 / unit), (1 / unit, 2 / unit, -9 / unit)])
        forest.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0), Gf.Quath(0.70710678, 0, 0, 0.70710678)])
        forest.CreateScalesAttr([(1, 1, 1), (2, 1, 1)])
        names = "instance_segmentation", "semantic_segmentation", "bounding_box_3d"
        seen, classes, space = look(app, add_camera(app, far=1e9), *names)
    trees = [f"{path}[{number}]{part}" for number in (0, 1) for part in ("", "/Trunk")]
    assert list(seen["info"]["idToLabels"].values()) == ["BACKGROUND", *trees]
    semantics = [found["class"] for found in seen["info"]["idToSemantics"].values()]
    assert semantics == ["BACKGROUND", "tree", "tree, trunk", "tree", "tree, trunk"]
    kinds = [found["class"] for found in classes["info"]["idToLabels"].values()]
    assert kinds == ["BACKGROUND", "tree", "tree, trunk"]  # the labels of the prims above come first
    second = by_path(space)[f"{path}[1]"]
    turned = np.array([(0, 2, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (1.5 / unit, 2 / unit, -9 / unit, 1)])
    np.testing.assert_allclose(second["transform"], turned, atol=1e-3)  # Quath has 11 binary digits
    sides = [float(second[name]) * unit for name in ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max")]
    assert sides == pytest.approx([-0.3, 0.0, -0.3, 0.3, 0.6, 0.3], abs=1e-5)
    trunk = by_path(space)[f"{path}[1]/Trunk"]["transform"][3, :3] * unit
    assert trunk == pytest.approx((1.8, 2.0, -9.0), abs=1e-3)


def test_boxes_in_space_are_given_all_round_too():
    """One box ahead, one behind the camera; how much of it is hidden is known for what is in the image."""
    with weightless() as app:
        for name, depth in (("Ahead", 5), ("Behind", -5)):
            app.add_prims(
                {f"/World/{name}": {"type": "Cube", "size": 1.0, "translate": [0, 0, -depth], "semantics": name}}
            )
        ahead_only, all_round = look(app, add_camera(app), "bounding_box_3d", "bounding_box_3d_360")
    assert ahead_only["info"]["primPaths"] == ["/World/Ahead"]
    assert all_round["info"]["primPaths"] == ["/World/Ahead", "/World/Behind"]
    assert all_round["data"]["transform"][:, 3, 2].tolist() == [-5, 5]
    assert all_round["data"]["z_max"].tolist() == [0.5, 0.5]
    assert all_round["info"]["bboxIds"].tolist() == [0, 1]
    np.testing.assert_array_equal(all_round["data"]["occlusionRatio"], [0.0, np.nan])


def test_prims_of_several_meshes_have_no_ratio():
    with weightless() as app:
        UsdGeom.Xform.Define(app.stage, "/World/Car")
        label(app, "/World/Car", "car")
        add_box(app, "/World/Car/Left", 1.0, ahead(-1, 0, 5))
        add_box(app, "/World/Car/Right", 1.0, ahead(1, 0, 5))
        [found] = look(app, add_camera(app), "bounding_box_2d_tight")
    [box] = found["data"]
    assert box["occlusionRatio"] == -1.0
    assert corners(box) == (153, 184, 486, 295)  # 320 -+ 1.5 x 500 / 4.5 = 166.67


def looking_from(app, eye, target):
    """The camera P, 1280 x 720 of 60 deg, on a stage whose z is up."""
    UsdGeom.SetStageUpAxis(app.stage, "Z")
    product = add_camera(app, size=(1280, 720), focal=18.147562, aperture=20.955)
    matrix = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*eye), Gf.Vec3d(*target), Gf.Vec3d(0, 0, 1)).GetInverse()
    UsdGeom.Xformable(app.stage.GetPrimAtPath("/World/Camera")).AddTransformOp().Set(matrix)
    return product


def add_solid(app, path, kind, place, scale=(1, 1, 1), **attributes):
    prim = app.stage.DefinePrim(path, kind)
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(*place))
    UsdGeom.XformCommonAPI(prim).SetScale(Gf.Vec3f(*scale))
    label(app, path, path.rpartition("/")[2])


def test_golden_boxes_of_two_cubes():
    with weightless() as app:
        product = looking_from(app, (0, -6, 0.5), (0, 0, 0.5))
        add_solid(app, "/World/Near", "Cube", (0, -4, 0.5), (1.55, 0.4, 1), size=1.0)
        add_solid(app, "/World/Far", "Cube", (1.45, -1.9, 0.52), size=0.55)
        tight, loose = look(app, product, "bounding_box_2d_tight", "bounding_box_2d_loose")
    np.testing.assert_allclose(corners(by_path(tight)["/World/Near"]), (163, 52, 1116, 667), atol=3)
    np.testing.assert_allclose(corners(by_path(tight)["/World/Far"]), (1117, 275, 1139, 433), atol=3)
    np.testing.assert_allclose(corners(by_path(loose)["/World/Far"]), (938, 275, 1139, 433), atol=3)


def test_golden_boxes_of_cubes_in_the_ground():
    with weightless() as app:
        product = looking_from(app, (0, -6, 0.5), (0, 0, 0.5))
        UsdGeom.Plane.Define(app.stage, "/World/Ground")
        add_solid(app, "/World/Right", "Cube", (2, 0, 0), (1.5, 1, 1), size=1.0)
        add_solid(app, "/World/Left", "Cube", (-1.5, 0, 0), (1, 2, 1), size=1.0)
        [tight] = look(app, product, "bounding_box_2d_tight")
    np.testing.assert_allclose(corners(by_path(tight)["/World/Right"]), (853, 360, 1193, 460), atol=3)
    np.testing.assert_allclose(corners(by_path(tight)["/World/Left"]), (197, 360, 481, 470), atol=3)


def test_golden_boxes_of_round_shapes():
    with weightless() as app:
        product = looking_from(app, (0, -7.25, 1.15), (0, 0, 0.55))
        add_solid(app, "/World/Can", "Cylinder", (0, 0, 0.62), radius=0.36, height=1.05)
        add_solid(app, "/World/Ball", "Sphere", (-2.3, 0.35, 0.48), radius=0.52)
        [tight] = look(app, product, "bounding_box_2d_tight")
    np.testing.assert_allclose(corners(by_path(tight)["/World/Can"]), (585, 269, 694, 436), atol=3)
    ball = corners(by_path(tight)["/World/Ball"])
    np.testing.assert_allclose(ball, (228, 290, 380, 438), atol=3)
    assert ball == (225, 290, 382, 441)  # |c - (c . d) d| <= 0.52 for the directions d of the pixels' centres


def test_the_golden_cloud_of_four_by_four_pixels():
    """10 m over the ground, f 50, aperture 20.955: pixel centres +-0.5, +-1.5 of 4 look 0.523875, 1.571625 off."""
    with weightless() as app:
        add_box(app, "/World/Ground", 100.0, (0, 0, -60.0))
        product = add_camera(app, size=(4, 4), focal=50.0, aperture=20.955)
        every, labelled = (
            get_annotator("pointcloud", {"includeUnlabelled": unlabelled}, app=app).attach(product)
            for unlabelled in (True, False)
        )
        app.play()
        app.update()
        found, none = every.get_data(), labelled.get_data()
    assert none["data"].shape == (0, 3)
    assert (found["data"].dtype, found["info"]["pointNormals"].shape) == (np.float32, (64,))
    places = found["data"].reshape(4, 4, 3)
    np.testing.assert_allclose(places[..., 2], -10.0, rtol=1e-6)
    np.testing.assert_allclose(places[0, :, 0], [-1.571625, -0.523875, 0.523875, 1.571625], rtol=1e-5)
    np.testing.assert_allclose(places[:, 0, 1], [1.571625, 0.523875, -0.523875, -1.571625], rtol=1e-5)


def test_a_body_that_moves_to_the_right_was_to_the_left():
    """1.2 m/s is 0.02 m an update of 1/60 s; 500 px x 0.02 / 5 = 2 px: previous less present is -2."""
    with weightless() as app:
        add_box(app, "/World/Body", 1.0, ahead(0, 0, 5.5), velocity=(1.2, 0, 0))
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 60))
        annotator = get_annotator("motion_vectors", app=app).attach(add_camera(app))
        app.play()
        app.update()
        first = annotator.get_data()
        app.update()
        second = annotator.get_data()
    assert first.shape == (480, 640, 4)
    assert not first.any()
    np.testing.assert_allclose(second[240, 320], [-2.0, 0, 0, 0], atol=1e-4)
    assert not second[10, 10].any()


def moved_camera(**to):
    """Motion vectors of a wall 5 m ahead after the camera was moved to `to` between two updates."""
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 55))
        product = add_camera(app, focal=16.0)
        api = UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Camera"))
        api.SetTranslate(Gf.Vec3d(0, 0, to.get("from_z", 0.0)))
        api.SetRotate(Gf.Vec3f(0, 0, 0))
        annotator = get_annotator("motion_vectors", app=app).attach(product)
        app.play()
        app.update()
        api.SetTranslate(Gf.Vec3d(0, 0, 0))
        api.SetRotate(Gf.Vec3f(*to.get("rotate", (0, 0, 0))))
        app.update()
        return annotator.get_data()


def test_a_camera_that_went_ahead_saw_things_nearer_to_the_centre():
    """0.1 m ahead, a point 0.4 m to the right and now 5 m away: 500 x 0.4 (1 / 5.1 - 1 / 5) = -0.784314 px.

    The pixel at column 359 looks 39.5 px to the right, 0.395 m: 39.5 (5 / 5.1 - 1) = -0.774510.
    """
    found = moved_camera(from_z=0.1)
    assert found[240, 359, 0] == pytest.approx(39.5 * (5 / 5.1 - 1), abs=1e-4)


def test_a_camera_that_turned_left_saw_the_middle_further_left():
    """Left by 1 deg: 500 tan(1 deg) = 8.727533 px."""
    found = moved_camera(rotate=(0, 1.0, 0))
    angle = np.arctan(0.5 / FX) - np.deg2rad(1.0)
    assert found[240, 320, 0] == pytest.approx(FX * np.tan(angle) - 0.5, abs=1e-3)
    assert found[240, 320, 0] == pytest.approx(-8.727533, abs=2e-3)


def test_camera_params_say_where_the_camera_is_and_how_it_projects():
    """256 x 256, f 50, aperture 20.955, at (0, 0, 25) looking down, image-up +x: (-5, 1, 3) -> (100.235, 266.826)."""
    with App(None) as app:
        UsdGeom.SetStageUpAxis(app.stage, "Z")
        product = add_camera(app, size=(256, 256), focal=50.0, aperture=20.955)
        matrix = Gf.Matrix4d().SetLookAt(Gf.Vec3d(0, 0, 25), Gf.Vec3d(0, 0, 0), Gf.Vec3d(1, 0, 0)).GetInverse()
        UsdGeom.Xformable(app.stage.GetPrimAtPath("/World/Camera")).AddTransformOp().Set(matrix)
        found = get_annotator("camera_params", app=app).attach(product)
        time = get_annotator("ReferenceTime", app=app).attach(product)
        assert found.get_data() == {}
        app.play()
        app.update()
        data = found.get_data()
        assert time.get_data() == {"referenceTimeNumerator": 1, "referenceTimeDenominator": 60}
        assert product.frame.arrays == {}
    clip = np.array([-5, 1, 3, 1]) @ data["cameraViewTransform"].reshape(4, 4) @ data["cameraProjection"].reshape(4, 4)
    u, v = 128 * (1 + clip[0] / clip[3]), 128 * (1 - clip[1] / clip[3])
    assert (u, v) == pytest.approx((100.235, 266.826), abs=0.05)
    assert data["renderProductResolution"].tolist() == [256, 256]
    assert (data["cameraModel"], data["metersPerSceneUnit"]) == ("pinhole", app.meters_per_unit)
    assert data["cameraAperture"].tolist() == pytest.approx([20.955, 20.955])
    assert data["cameraNearFar"].tolist() == pytest.approx([0.01, 1e6])


def test_the_projection_of_a_kit_viewport():
    with App(None) as app:
        product = add_camera(app, size=(1280, 720), focal=18.147562, aperture=20.955)
        found = get_annotator("camera_params", app=app).attach(product)
        app.play()
        app.update()
        matrix = found.get_data()["cameraProjection"].reshape(4, 4)
    assert (matrix[0, 0], matrix[1, 1], matrix[2, 3]) == pytest.approx((1.7320508, 3.0792014, -1.0), abs=1e-6)
    assert matrix[3, 2] == pytest.approx(0.01)
