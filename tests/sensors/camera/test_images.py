"""Images of depth, normals and numbers against closed forms, in the camera's optical frame (`camera_worlds`).

The camera C has 640 x 480 pixels, fx = fy = 500, its centre at (320, 240); pixel (i, j) looks along
((i + 0.5 - 320) / 500, (j + 0.5 - 240) / 500, 1). Depths are float32 at some metres: 1e-6 relative.
"""

import re

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import sensors
from graph.base.errors import UserError
from graph.base.limits import raised
from graph.sim import App
from sensors.camera.config import read_config
from sensors.products import render_product
from sensors.replicator import get_annotator
from tests.support.camera_worlds import FX, add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

OFFSETS = [0.0, 1e3, 1e6]


def add_sphere(app, path, radius, place):
    sphere = UsdGeom.Sphere.Define(app.stage, path)
    sphere.CreateRadiusAttr(radius)
    UsdGeom.XformCommonAPI(sphere).SetTranslate(Gf.Vec3d(*place))


def label(app, path, text, taxonomy="class"):
    prim = app.stage.GetPrimAtPath(path)
    prim.AddAppliedSchema(f"SemanticsLabelsAPI:{taxonomy}")
    prim.GetAttribute(f"semantics:labels:{taxonomy}").Set([text])


def pixel_rays():
    """((640 columns), (480 rows)) of x / z and y / z."""
    return (np.arange(640) + 0.5 - 320) / FX, (np.arange(480) + 0.5 - 240) / FX


@pytest.mark.parametrize("offset", OFFSETS)
def test_a_wall_has_one_distance_from_the_image_plane_and_grows_away_from_the_camera(offset):
    """Its near side is 4 m ahead: at pixel (0, 0) 4 sqrt(1 + 0.639^2 + 0.479^2) = 5.1190030 m away."""
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, (offset, offset, offset - 54.0))
        product = add_camera(app)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Camera")).SetTranslate(Gf.Vec3d(offset, offset, offset))
        plane, away = look(app, product, "distance_to_image_plane", "distance_to_camera")
    assert plane.shape == away.shape == (480, 640)
    assert plane.dtype == away.dtype == np.float32
    x, y = pixel_rays()
    # At an offset both ends of a ray's depth are off by half a float32 step of at most 1024 m (6.1e-5 m).
    tolerance = {"rtol": 1e-6, "atol": 6.2e-5 if offset else 0.0}
    np.testing.assert_allclose(plane, 4.0, **tolerance)
    np.testing.assert_allclose(away, 4 * np.sqrt(1 + x[None] ** 2 + y[:, None] ** 2), **tolerance)
    assert away[0, 0] == pytest.approx(5.1190030, rel=1e-6, abs=tolerance["atol"])


def test_a_floor_has_the_depth_of_its_row():
    """1.5 m below: 1.5 x 500 / (row + 0.5 - 240); nothing from the horizon up."""
    with weightless() as app:
        UsdGeom.Plane.Define(app.stage, "/World/Floor").CreateAxisAttr("Y")
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Floor")).SetTranslate(Gf.Vec3d(*ahead(0, 1.5, 0)))
        plane, normals = look(app, add_camera(app), "distance_to_image_plane", "normals")
    for row, depth in ((240, 1500.0), (300, 12.396694), (479, 3.131524)):
        np.testing.assert_allclose(plane[row], depth, rtol=1e-5)
    assert np.isinf(plane[:240]).all()
    assert normals.shape == (480, 640, 4)
    np.testing.assert_allclose(normals[240:, :, :3], np.broadcast_to([0, 1, 0], (240, 640, 3)), atol=1e-6)
    assert not normals[:240].any()


def test_a_sphere_is_where_geometry_says():
    """Radius 1 at 5 m: the outline is a circle of 500 tan(asin(1 / 5)) = 102.0621 px, which holds 32,744 centres."""
    with weightless(mesh_tolerance=5e-6) as app:
        add_sphere(app, "/World/Ball", 1.0, ahead(0, 0, 5))
        away, plane, normals = look(app, add_camera(app), "distance_to_camera", "distance_to_image_plane", "normals")
    seen = np.isfinite(plane)
    rows, columns = np.nonzero(seen)
    assert (columns.min(), rows.min(), columns.max(), rows.max()) == (218, 138, 421, 341)
    assert abs(int(seen.sum()) - 32_744) <= 4  # centres within 2e-4 px of the outline
    assert (away[240, 400], plane[240, 400]) == pytest.approx((4.329531, 4.274484), abs=2e-5)
    # In world axes y is up and z backward; a facet of a thousandth of a turn is off by half of that: 3.2e-3 rad.
    np.testing.assert_allclose(normals[240, 400, :3], [0.688192, -0.004274, 0.725516], atol=3.2e-3)


def test_ids_are_those_of_the_geometry():
    """A box of 1 m with its near side 4.5 m ahead covers the columns and rows of +-0.5 x 500 / 4.5 = 55.56 px."""
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 60))
        label(app, "/World/A", "box")
        product = add_camera(app)
        semantic, labelled, every = look(
            *(app, product), "semantic_segmentation", "instance_segmentation", "instance_id_segmentation_fast"
        )
    box = np.zeros((480, 640), bool)
    box[184:296, 264:376] = True
    np.testing.assert_array_equal(semantic["data"], np.where(box, 2, 1))
    np.testing.assert_array_equal(labelled["data"], np.where(box, 2, 1))
    np.testing.assert_array_equal(every["data"], np.where(box, 2, 3))
    assert {found["data"].dtype for found in (semantic, labelled, every)} == {np.dtype(np.uint32)}
    assert semantic["info"]["idToLabels"] == {"1": {"class": "UNLABELLED"}, "2": {"class": "box"}}
    assert labelled["info"]["idToLabels"] == {1: "UNLABELLED", 2: "/World/A"}
    assert labelled["info"]["idToSemantics"] == {1: {"class": "UNLABELLED"}, 2: {"class": "box"}}
    assert every["info"]["idToLabels"] == {2: "/World/A", 3: "/World/Wall"}


def test_a_child_without_label_belongs_to_what_is_labelled_above_it():
    with weightless() as app:
        UsdGeom.Xform.Define(app.stage, "/World/Car")
        add_box(app, "/World/Car/Body", 1.0, ahead(-1, 0, 5))
        add_box(app, "/World/Car/Wheel", 1.0, ahead(1, 0, 5))
        label(app, "/World/Car", "car")
        label(app, "/World/Car/Wheel", "wheel")
        [found] = look(app, add_camera(app), "instance_segmentation")
    assert found["info"]["idToLabels"] == {0: "BACKGROUND", 2: "/World/Car", 3: "/World/Car/Wheel"}
    assert found["info"]["idToSemantics"] == {
        0: {"class": "BACKGROUND"}, 2: {"class": "car"}, 3: {"class": "car, wheel"}
    }  # fmt: skip


@pytest.mark.parametrize(
    ("options", "labels"),
    [
        ({"semanticTypes": ["class"]}, {"1": {"class": "UNLABELLED"}, "2": {"class": "box"}}),
        ({"semanticTypes": "class"}, {"1": {"class": "UNLABELLED"}, "2": {"class": "box"}}),
        ({"semanticTypes": ["shape"]}, {"1": {"class": "UNLABELLED"}, "2": {"shape": "flat"}}),
        ({"semanticFilter": "class:b*|c; shape:none"}, {"1": {"class": "UNLABELLED"}, "2": {"class": "box"}}),
        ({"semanticFilter": "*:*"}, {"2": {"class": "box"}, "3": {"shape": "flat"}}),
        ({"semanticFilter": "class:!box; shape:!box"}, {"1": {"class": "UNLABELLED"}, "2": {"shape": "flat"}}),
        ({"semanticFilter": "class:b* & !bin | none"}, {"1": {"class": "UNLABELLED"}, "2": {"class": "box"}}),
        ({"semanticFilter": "class:none, box, shape:*"}, {"2": {"class": "box"}, "3": {"shape": "flat"}}),
    ],
)
def test_a_filter_decides_which_labels_count(options, labels):
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 60))
        label(app, "/World/A", "box")
        label(app, "/World/Wall", "flat", "shape")
        [found] = look(app, add_camera(app), "semantic_segmentation", **options)
    assert found["info"]["idToLabels"] == labels


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        ("semantic_segmentation", 3, "semanticFilter 3 is not text, such as 'class:car|truck'"),
        ("bounding_box_3d", "car", "semanticFilter 'car': 'car' is not taxonomy:label"),
        (
            "instance_segmentation",
            "!class:car",
            "semanticFilter '!class:car': write ! before a label, as in class:!car",
        ),
    ],
)
def test_a_filter_that_says_nothing_is_reported_when_it_is_attached(kind, text, message):
    with weightless() as app, pytest.raises(ValueError, match=re.escape(f"{kind}: {message}")):
        look(app, add_camera(app), kind, semanticFilter=text)


def test_colours_stand_for_numbers_when_asked_for():
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        label(app, "/World/A", "box")
        [found] = look(app, add_camera(app), "semantic_segmentation", colorize=True)
    colours = {text: labels["class"] for text, labels in found["info"]["idToLabels"].items()}
    middle = str(tuple(found["data"][240, 320].tolist()))
    assert found["data"].shape == (480, 640, 4)
    assert found["data"].dtype == np.uint8
    assert colours == {"(0, 0, 0, 0)": "BACKGROUND", middle: "box"}


@pytest.mark.parametrize(
    ("near", "far", "expected"), [(0.01, 100, 4.5), (5.0, 100, 5.5), (6.0, 100, 10.0), (0.01, 4, np.inf)]
)
def test_only_what_lies_between_the_clipping_distances_is_shown(near, far, expected):
    """The near side of the box is 4.5 m ahead, its far side 5.5 m, the wall 10 m."""
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 60))
        product = add_camera(app, near=near, far=far)
        plane, away, number = look(
            *(app, product), "distance_to_image_plane", "distance_to_camera", "instance_id_segmentation"
        )
    assert plane[240, 320] == pytest.approx(expected, rel=1e-6)
    assert away[240, 320] == pytest.approx(expected * np.sqrt(1 + 2 * 0.001**2), rel=1e-6)
    assert number["data"][240, 320] == {4.5: 2, 5.5: 2, 10.0: 3}.get(expected, 0)


def test_an_aperture_offset_moves_the_centre():
    """2.048 tenths to the right are 64 px of 640: what was in the middle lies 64 px to the left; up moves it down."""
    with weightless() as app:
        product = add_camera(app, horizontalApertureOffset=2.048, verticalApertureOffset=1.024)
        lens = product.sensor.config.lens
    assert (lens.cx, lens.cy) == pytest.approx((320 - 64, 240 + 32), rel=1e-6)


def test_an_orthographic_camera_sees_along_parallel_rays():
    """An aperture of 20 tenths is 2 m wide: 320 px a metre; the box of 1 m covers 320 of 640 columns at any depth."""
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        product = add_camera(app, aperture=20.0, projection="orthographic")
        plane, away = look(app, product, "distance_to_image_plane", "distance_to_camera")
    rows, columns = np.nonzero(np.isfinite(plane))
    assert (columns.min(), rows.min(), columns.max(), rows.max()) == (160, 80, 479, 399)
    np.testing.assert_allclose(plane[rows, columns], 4.5, rtol=1e-6)
    np.testing.assert_array_equal(plane, away)


def test_a_moving_body_is_seen_where_it_is():
    """2 m/s to the right from x = -1: after one update of 1/60 s at -1 + 1 / 30; its right side is seen to 5.5 m."""
    with weightless() as app:
        add_box(app, "/World/Body", 1.0, ahead(-1, 0, 5), velocity=(2.0, 0, 0))
        [plane] = look(app, add_camera(app), "distance_to_image_plane")
    columns = np.flatnonzero(np.isfinite(plane[240]))
    low, high = ((x + 1 / 30 - 1) * FX / z + 320 for x, z in ((-0.5, 4.5), (0.5, 5.5)))
    assert (columns[0], columns[-1]) == (np.ceil(low - 0.5), np.floor(high - 0.5))


def test_depth_is_in_metres_whatever_the_unit_of_the_stage():
    """A stage in centimetres: the box of 100 has its near side 450 ahead."""
    with weightless() as app:
        UsdGeom.SetStageMetersPerUnit(app.stage, 0.01)
        add_box(app, "/World/A", 100.0, ahead(0, 0, 500))
        [plane] = look(app, add_camera(app, near=1.0), "distance_to_image_plane")
    assert plane[240, 320] == pytest.approx(4.5, rel=1e-6)


def test_a_camera_of_a_rate_renders_at_its_ticks_only_and_what_is_asked_for_only():
    with weightless() as app:
        add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        product = add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniSensorAPI")
        prim.GetAttribute("omni:sensor:tickRate").Set(20.0)
        depth = get_annotator("distance_to_camera", app=app).attach(product)
        app.play()
        stamps = []
        for _ in range(12):
            app.update()
            if product.new_frame:
                stamps.append(product.frame.timestamp_ns)
        assert stamps == [50_000_000, 100_000_000, 150_000_000, 200_000_000]
        assert set(product.frame.arrays) == {"distance_to_camera"}
        assert (product.frame.count, product.elements) == (640 * 480, 4 * 640 * 480)
        depth.detach()
        app.update(steps=3)
        assert (product.frames, dict(product.frame.arrays)) == (5, {})


def test_threads_and_other_cameras_change_no_byte():
    def images(threads, others):
        with weightless(settings={"/tickgraph/rayThreads": threads}) as app:
            add_box(app, "/World/Body", 1.0, ahead(-1, 0, 5), velocity=(2.0, 0, 0), spin=(30.0, 20.0, 10.0))
            add_sphere(app, "/World/Ball", 1.0, ahead(1, 0, 5))
            for number in range(others):
                get_annotator("normals", app=app).attach(add_camera(app, f"/World/Other{number}", (64, 48)))
            return [
                each["data"].tobytes() if isinstance(each, dict) else each.tobytes()
                for each in look(app, add_camera(app), "distance_to_camera", "normals", "instance_segmentation")
            ]

    assert images(1, 0) == images(2, 3)


@pytest.mark.parametrize(
    ("attribute", "value", "message"),
    [
        ("focalLength", 0.0, r"/World/Camera.focalLength is 0.0; give a number above 0"),
        ("horizontalAperture", -1.0, r"horizontalAperture is -1.0; give a number above 0"),
        ("exposure:time", -0.5, r"/World/Camera.exposure:time is -0.5; give 0 or more"),
        ("exposure:fStop", -2.0, r"/World/Camera.exposure:fStop is -2.0; give 0 or more"),
        ("exposure:iso", -1.0, r"/World/Camera.exposure:iso is -1.0; give 0 or more"),
        ("focalLength", float("nan"), r"focalLength is nan; give a finite number"),
        ("clippingRange", Gf.Vec2f(2, 1), r"clippingRange is \(2.0, 1.0\); give the nearest and the farthest distance"),
    ],
)
def test_a_prim_that_no_camera_can_be_is_reported_in_a_line(attribute, value, message):
    with App(None) as app:
        add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.GetAttribute(attribute).Set(value)
        with pytest.raises(UserError, match=message):
            read_config(prim, (640, 480), 1.0)


def test_images_are_bounded_and_have_pixels():
    with App(None) as app:
        add_camera(app)
        with pytest.raises(UserError, match="10,000 x 10,000 has 100,000,000 pixels; the limit is 10,000,000 rays"):
            render_product(app, "/World/Camera", (10_000, 10_000))
        with pytest.raises(UserError, match="an image of 0 x 5 has no pixels"):
            render_product(app, "/World/Camera", (0, 5))
        with raised({"camera.rays": 100}), pytest.raises(UserError, match="the limit is 100 rays"):
            render_product(app, "/World/Camera", (11, 10))


def test_an_annotator_of_cameras_says_what_it_reads():
    with App(None) as app:
        app.stage.DefinePrim("/World/Lidar", "OmniLidar")
        lidar = render_product(app, "/World/Lidar")
        with pytest.raises(UserError, match="normals: /World/Lidar is OmniLidar; it reads Camera only"):
            get_annotator("normals", app=app).attach(lidar)
        camera = add_camera(app)
        assert get_annotator("normals", app=app).attach(camera).get_data().shape == (0, 0, 4)
        with pytest.raises(UserError, match="Camera does not measure xyz"):
            sensors.on_frame(camera, print, app=app)
