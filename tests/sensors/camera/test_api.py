"""The classes that users hold of cameras: authoring, a camera at work, tiles."""

import re

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from graph.sim import App
from sensors import CameraSensor, CameraView, RtxCamera, TiledCameraSensor
from sensors.camera.sensor import ANNOTATORS, WIDTHS
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead
from tests.support.lidar_worlds import add_box, weightless

CAMERA = "/World/Rig/Camera"


@pytest.fixture
def app():
    with weightless() as app:
        box = add_box(app, "/World/A", 1.0, ahead(0, 0, 5))
        box.AddAppliedSchema("SemanticsLabelsAPI:class")
        box.GetAttribute("semantics:labels:class").Set(["box"])
        yield app


def test_a_new_camera_has_the_schema_of_sensors_and_ticks_in_every_update(app):
    camera = RtxCamera(CAMERA, translations=(1, 2, 3), app=app)
    assert camera.prim.GetTypeName() == "Camera"
    assert "OmniSensorAPI" in camera.prim.GetAppliedSchemas()
    assert camera.tick_rate == 0
    assert camera.get_world_poses()[0].tolist() == [[1, 2, 3]]
    assert not camera.prim.HasAttribute("_replicator:rendervar:GenericModelOutput:channels")


def test_a_path_may_be_one_of_usd_and_nothing_but_a_path(app):
    assert RtxCamera(Sdf.Path(CAMERA), app=app).path == CAMERA
    with pytest.raises(ValueError, match="3 is not the path of a prim, such as /World/Sensor"):
        RtxCamera(3, app=app)


def test_schemas_and_attributes_make_a_lens(app):
    camera = RtxCamera(
        CAMERA,
        tick_rate=15,
        schemas=["OmniLensDistortionOpenCvFisheyeAPI"],
        attributes={"omni:lensdistortion:opencvFisheye:k1": 0.5},
        app=app,
    )
    assert camera.tick_rate == 15
    assert camera.prim.GetAttribute("omni:lensdistortion:opencvFisheye:k1").Get() == 0.5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda app: RtxCamera("/World/Plain", app=app), "/World/Plain has no OmniSensorAPI; apply it"),
        (lambda app: RtxCamera("/World/A", app=app), "/World/A is of type Cube, not Camera"),
        (lambda app: RtxCamera(CAMERA, aux_output_level="NONE", app=app), "a camera has no aux_output_level"),
        (lambda app: RtxCamera.create(CAMERA, config="X", usd_path="y.usda", app=app), "give config or usd_path"),
        (lambda app: RtxCamera.create(CAMERA, config="D435", app=app), "no camera config 'D435'; did you mean"),
        (lambda app: CameraSensor(CAMERA, resolution=(0, 5), app=app), r"resolution \(0, 5\) is not \(height, width\)"),
        (lambda app: TiledCameraSensor("/World/E.*", resolution=(4, 5), app=app), "regular expression .* no prim"),
        (lambda app: CameraSensor(CAMERA, resolution=(4, 5), annotators="hue", app=app), "there is no annotator 'hue'"),
        (lambda app: TiledCameraSensor([], resolution=(4, 5), app=app), "there is no camera to tile"),
        (
            lambda app: TiledCameraSensor(CAMERA, resolution=(4, 5), annotators="pointcloud", app=app),
            "there is no annotator 'pointcloud' of tiles",
        ),
    ],
)
def test_what_cannot_be_is_reported_in_a_line(app, make, message):
    add_camera(app, "/World/Plain", (8, 8))
    with pytest.raises(ValueError, match=message):
        make(app)


def test_the_lens_takes_stage_units_and_authors_tenths(app):
    camera = RtxCamera(CAMERA, app=app)
    lens = camera.camera
    lens.set_focal_lengths(24.0)
    lens.set_apertures(36.0, 24.0)
    lens.set_aperture_offsets(1.0, [2.0])
    lens.set_focus_distances(3.0)
    lens.set_fstops(2.8)
    lens.set_clipping_ranges(0.5)
    get = camera.prim.GetAttribute
    assert [get(name).Get() for name in ("focalLength", "horizontalAperture", "verticalAperture")] == [240, 360, 240]
    assert [get(f"{axis}ApertureOffset").Get() for axis in ("horizontal", "vertical")] == [10, 20]
    assert tuple(get("clippingRange").Get()) == (0.5, 1e6)
    assert lens.get_focal_lengths().tolist() == [[24.0]]
    assert [each.tolist() for each in lens.get_apertures()] == [[[36.0]], [[24.0]]]
    assert [each.tolist() for each in lens.get_aperture_offsets()] == [[[1.0]], [[2.0]]]
    assert [each.tolist() for each in lens.get_clipping_ranges()] == [[[0.5]], [[1e6]]]
    assert (lens.get_focus_distances()[0, 0], lens.get_fstops()[0, 0]) == (3.0, np.float32(2.8))
    with pytest.raises(AssertionError, match="give horizontalAperture or verticalAperture"):
        lens.set_apertures()
    with pytest.raises(AssertionError, match="give a near or a far distance"):
        lens.set_clipping_ranges()


def test_a_view_of_several_lenses_takes_one_value_or_one_for_each(app):
    lenses = CameraView([RtxCamera(f"/World/Eye{number}", app=app).prim for number in range(3)])
    lenses.set_focal_lengths([1.0, 2.0, 3.0])
    lenses.set_clipping_ranges(far_distances=[[10.0], [20.0], [30.0]])
    lenses.set_shutter_times(0.25, close_times=[0.5, 0.75, 1.0])
    lenses.set_projections(["orthographic", "perspective", "orthographic"])
    lenses.set_stereo_roles("left")
    lenses.set_apertures(2.0, 1.0)
    lenses.enforce_square_pixels([(10, 10), (10, 20), (10, 20)], modes=["horizontal", "horizontal", "vertical"])
    assert lenses.get_focal_lengths().tolist() == [[1.0], [2.0], [3.0]]
    assert [each.tolist() for each in lenses.get_clipping_ranges()] == [[[1.0]] * 3, [[10.0], [20.0], [30.0]]]
    assert [each.tolist() for each in lenses.get_shutter_times()] == [[[0.25]] * 3, [[0.5], [0.75], [1.0]]]
    assert lenses.get_projections() == ["orthographic", "perspective", "orthographic"]
    assert lenses.get_stereo_roles() == ["left"] * 3
    assert [each.tolist() for each in lenses.get_apertures()] == [[[2.0]] * 3, [[2.0], [1.0], [1.0]]]


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (lambda lens: lens.set_focal_lengths([1.0, 2.0]), r"\[1.0, 2.0\] is not one finite number"),
        (lambda lens: lens.set_fstops("wide"), "'wide' is not one finite number"),
        (lambda lens: lens.set_projections("fisheye"), "projection 'fisheye' is not one of perspective, orthographic"),
        (lambda lens: lens.set_stereo_roles(["left", "right"]), r"\['left', 'right'\] is not one stereoRole"),
        (lambda lens: lens.enforce_square_pixels((8, 8), "both"), "mode 'both' is not one of horizontal, vertical"),
    ],
)
def test_what_a_lens_does_not_take_is_reported_in_a_line(app, write, message):
    with pytest.raises(ValueError, match=message):
        write(RtxCamera(CAMERA, app=app).camera)


def test_a_view_is_of_cameras_and_sets_something(app):
    with pytest.raises(AssertionError, match="/World/A is not a Camera"):
        CameraView(app.stage.GetPrimAtPath("/World/A"))
    with pytest.raises(AssertionError, match="give shutter:open or shutter:close"):
        RtxCamera(CAMERA, app=app).camera.set_shutter_times()


@pytest.mark.parametrize(
    ("mode", "apertures"), [("horizontal", (20.955, 15.71625)), ("vertical", (15.2908 * 640 / 480, 15.2908))]
)
def test_pixels_are_made_square(app, mode, apertures):
    """f 50 on 640 x 480: the film of 20.955 is 15.71625 high."""
    lens = RtxCamera(CAMERA, app=app).camera
    lens.enforce_square_pixels((480, 640), mode)
    found = [10 * float(each[0, 0]) for each in lens.get_apertures()]
    assert found == pytest.approx(apertures, rel=1e-6)


def test_a_camera_sensor_hands_out_images_of_three_axes(app):
    sensor = CameraSensor(CAMERA, resolution=(48, 64), annotators=[*ANNOTATORS], app=app)
    assert sensor.render_product.path.rpartition("/")[2].startswith("camera_sensor_")
    assert sensor.render_product.resolution == (64, 48)
    assert (sensor.camera.paths, sensor.authoring_object.path) == ([CAMERA], CAMERA)
    assert sensor.get_data("rgb") == (None, {})
    app.play()
    app.update()
    shapes = {name: sensor.get_data(name)[0].shape for name in WIDTHS}
    assert shapes == {name: (48, 64, width) for name, width in WIDTHS.items()}
    out = np.empty((48, 64, 1), np.float32)
    data, info = sensor.get_data("distance_to_camera", out)
    assert data is out
    assert info == {}
    np.testing.assert_allclose(out[24, 32], 4.5, rtol=1e-3)
    boxes, info = sensor.get_data("bounding_box_2d_tight")
    assert (len(boxes), info["resolution"], info["idToLabels"]) == (1, (48, 64), {0: {"class": "box"}})
    cloud, info = sensor.get_data("pointcloud")
    assert cloud.shape[1] == 3
    assert info["resolution"] == (48, 64)
    with pytest.raises(ValueError, match="there is no annotator 'hue'"):
        sensor.get_data("hue")
    sensor.detach_annotators("rgb")
    with pytest.raises(ValueError, match="annotator 'rgb' is not attached"):
        sensor.get_data("rgb")


@pytest.mark.parametrize("kind", [CameraSensor, TiledCameraSensor])
@pytest.mark.parametrize("resolution", [(9,), "9x9", (9.5, 9), 9, (9, float("nan"))])
def test_a_resolution_is_two_whole_numbers(app, kind, resolution):
    with pytest.raises(ValueError, match=re.escape(f"{resolution!r} is not (height, width): give two whole numbers")):
        kind(CAMERA, resolution=resolution, app=app)


def test_the_paths_of_tiles_may_be_regular_expressions(app):
    for number in range(3):
        app.stage.DefinePrim(f"/World/env_{number}/Eye", "Camera")
    with App(app.stage) as same:
        tiled = TiledCameraSensor(["/World/env_[12]/Eye", "/World/env_0/Eye"], resolution=(8, 10), app=same)
    assert tiled.paths == ["/World/env_1/Eye", "/World/env_2/Eye", "/World/env_0/Eye"]


def test_tiles_share_their_labels_and_change_annotators_together(app):
    """The second camera, 100 m to the right, sees nothing of the box; pixels of 16 x 8 are square at 20.955 / 2."""
    for name, place in (("A", 0.0), ("B", 100.0)):
        prim = app.stage.DefinePrim(f"/World/Eye{name}", "Camera")
        prim.GetAttribute("clippingRange").Set((0.01, 50.0))
        UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(place, 0, 0))
    tiled = TiledCameraSensor("/World/Eye.", resolution=(8, 16), annotators="semantic_segmentation", app=app)
    assert len(tiled) == 2
    assert tiled.camera.paths == tiled.paths == ["/World/EyeA", "/World/EyeB"]
    np.testing.assert_allclose(tiled.camera.get_apertures()[1], [[2.0955 / 2]] * 2, rtol=1e-6)
    app.play()
    app.update()
    images, info = tiled.get_data("semantic_segmentation")
    assert info == {"idToLabels": {"0": {"class": "BACKGROUND"}, "2": {"class": "box"}}}
    assert [sorted(set(image.flat)) for image in images] == [[0, 2], [0]]
    out = np.zeros((8, 32, 1), np.uint32)
    assert tiled.get_data("semantic_segmentation", tiled=True, out=out)[0] is out
    np.testing.assert_array_equal(out[:, :16], images[0])
    with pytest.raises(ValueError, match=r"out has the shape \(8, 32, 1\); the data have \(2, 8, 16, 1\)"):
        tiled.get_data("semantic_segmentation", out=out)
    tiled.attach_annotators(["rgb", "normals"])
    tiled.detach_annotators("semantic_segmentation")
    assert tiled.annotators == ["normals", "rgb"]
    with pytest.raises(ValueError, match="there is no annotator 'pointcloud' of tiles"):
        tiled.get_data("pointcloud")


def test_five_tiles_are_two_rows_of_three_with_one_spare(app):
    """Camera k, k / 10 m off, has the image that it has alone, in row k // 3 and column k % 3."""
    paths = []
    for number in range(5):
        prim = app.stage.DefinePrim(f"/World/Eye{number}", "Camera")
        prim.GetAttribute("clippingRange").Set((0.01, 1000.0))
        UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(number / 10, 0, 0))
        paths.append(str(prim.GetPath()))
    with App(app.stage) as same:
        tiled = TiledCameraSensor(paths, resolution=(8, 10), annotators="distance_to_image_plane", app=same)
        assert (tiled.rows, tiled.columns, tiled.tiled_resolution) == (2, 3, (16, 30))
        assert tiled.get_data("distance_to_image_plane") == (None, {})
        same.play()
        same.update()
        whole, _ = tiled.get_data("distance_to_image_plane", tiled=True)
        each, _ = tiled.get_data("distance_to_image_plane")
        alone = get_annotator("distance_to_image_plane", app=same).attach(
            same.rendering.products[tiled.sensors[2].render_product.path]
        )
        np.testing.assert_array_equal(alone.get_data(), each[2, :, :, 0])
    assert len({image.tobytes() for image in each}) == 5
    assert whole.shape == (16, 30, 1)
    assert each.shape == (5, 8, 10, 1)
    for number in range(5):
        row, column = divmod(number, 3)
        np.testing.assert_array_equal(whole[row * 8 : row * 8 + 8, column * 10 : column * 10 + 10], each[number])
    assert not whole[8:, 20:].any()


@pytest.mark.parametrize("kind", ["camera", "tiles"])
def test_data_asked_for_again_are_the_same_array_until_the_next_frame_and_nobody_elses(app, kind):
    """At 10 Hz a frame comes in every sixth update of 60 Hz: what was written on it is gone with it."""

    def make():
        RtxCamera(CAMERA, tick_rate=10, app=app)
        if kind == "tiles":
            return TiledCameraSensor([CAMERA], resolution=(24, 32), annotators="rgb", app=app)
        return CameraSensor(CAMERA, resolution=(24, 32), annotators="rgb", app=app)

    mine, other = make(), make()
    app.play()
    app.update(steps=6)
    held, plain = mine.get_data("rgb")[0], other.get_data("rgb")[0].copy()
    for _ in range(5):
        assert mine.get_data("rgb")[0] is held
        app.update()
    held[...] = 7
    np.testing.assert_array_equal(other.get_data("rgb")[0], plain)
    app.update()
    assert mine.get_data("rgb")[0] is not held
    np.testing.assert_array_equal(mine.get_data("rgb")[0], plain)
    assert (held == 7).all()
