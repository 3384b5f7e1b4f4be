"""The classes that users hold of cameras: authoring, a camera at work, tiles."""

import re

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph.sim import App
from sensors import CameraSensor, RtxCamera, TiledCameraSensor
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
        whole, _ = tiled.get_data("distance_to_image_plane")
        each, _ = tiled.get_data("distance_to_image_plane", tiled=False)
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
