"""Frames of cameras as ROS 2 messages: every type of the camera helper, and what the lens is like.

The camera looks along +x from (0, 0, 1): a box of 1 m with its near side 3.5 m ahead, a wall 9 m ahead.
"""

import json

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph import ComputeError
from graph.base.exact import nanoseconds
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from graph.testing import run_node
from sensors import render_product
from tests.support.without_wing import needs_wing

CAMERA = "/World/Camera"
SIZE = (64, 48)
FX = 64 * 20 / 20.48
"""62.5 px"""


@pytest.fixture
def app(stage, world):
    camera = UsdGeom.Camera.Define(stage, CAMERA)
    camera.GetFocalLengthAttr().Set(20.0)
    camera.GetHorizontalApertureAttr().Set(20.48)
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(0.01, 1000))
    camera.AddTranslateOp().Set((0, 0, 1))
    camera.AddRotateXYZOp().Set((90, 0, -90))
    for name, size, place in (("Box", 1.0, (4, 0, 1)), ("Wall", 100.0, (59, 0, 1))):
        cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
        cube.GetSizeAttr().Set(size)
        cube.AddTranslateOp().Set(place)
    box = stage.GetPrimAtPath("/World/Box")
    box.AddAppliedSchema("SemanticsLabelsAPI:class")
    box.GetAttribute("semantics:labels:class").Set(["Crate"])
    UsdGeom.Cube(box).GetDisplayColorAttr().Set([(1, 0, 0)])
    sky = stage.DefinePrim("/World/Sky", "DomeLight")
    sky.GetAttribute("inputs:intensity").Set(1250.0)
    return world(physics_hz=240)


def helper(app, kind="rgb", updates=3, node="ROS2CameraHelper", size=SIZE, **inputs):
    path = render_product(app, CAMERA, size).path
    inputs = {"renderProductPath": path, **({"type": kind} if node == "ROS2CameraHelper" else {}), **inputs}
    return run_node(node, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def messages(app, topic):
    return [one.message for one in app.sink[topic]]


def pixels(message, dtype, width=1):
    found = np.frombuffer(message.data.tobytes(), dtype).reshape(message.height, message.width, width)
    return found if width > 1 else found[..., 0]


def test_colours_are_rgb8_with_the_time_of_the_update(app):
    helper(app)
    found = messages(app, "/rgb")
    assert [one.header.stamp.nanosec for one in found] == [16_666_667, 33_333_333, 50_000_000]
    picture = found[0]
    assert (picture.encoding, picture.width, picture.height, picture.step) == ("rgb8", 64, 48, 192)
    assert (picture.header.frame_id, picture.is_bigendian) == ("sim_camera", 0)
    colours = pixels(picture, np.uint8, 3)
    assert colours[24, 32].tolist() == [255, 0, 0]  # the sky's pi x 1250 nit on red: 1250 x 8e-4 = 1
    assert colours[2, 2].tolist() == [118, 118, 118]  # on the grey wall 0.18


def stereo(stage, **values):
    """Sets the stereo depth of the camera: f b = 62.5 x 0.1 = 6.25 px m, in this image of 64 px."""
    camera = stage.GetPrimAtPath(CAMERA)
    camera.ApplyAPI("OmniSensorDepthSensorSingleViewAPI")
    values = {"baselineMM": 100, "focalLengthPixel": FX, "sensorSizePixel": 64, "noiseSigma": 0, **values}
    for name, value in values.items():
        camera.GetAttribute(f"omni:rtx:post:depthSensor:{name}").Set(value)


def test_stereo_depth_has_steps_of_disparity_and_nan_where_one_imager_sees_nothing(app, stage):
    """Box: 6.25 / 3.5 = 1.786, step 1.75, 3.571 m. Wall: 6.25 / 9 = 0.694, step 0.75, 8.333 m, off the second imager
    in column 0. Left of the box 1.786 - 0.694 = 1.09 columns are hidden from it."""
    stereo(stage)
    helper(app, "stereo_depth", topicName="depth")
    found = messages(app, "/depth")[0]
    depth = pixels(found, np.float32)
    assert (found.encoding, found.header.frame_id) == ("32FC1", "sim_camera")
    assert depth[24, 32] == pytest.approx(6.25 / 1.75)
    assert depth[2, 40] == pytest.approx(6.25 / 0.75)
    assert np.isnan(depth[2]).nonzero()[0].tolist() == [0]
    left = (depth[24] < 4).nonzero()[0][0]
    assert np.isnan(depth[24, left - 1])
    assert not np.isnan(depth[24, left - 3])


def test_a_stereo_cloud_is_its_depth_along_the_optical_axis(app, stage):
    stereo(stage)
    helper(app, "stereo_depth", topicName="depth")
    helper(app, "stereo_depth_pcl", topicName="cloud")
    depth = pixels(messages(app, "/depth")[-1], np.float32)
    points = np.frombuffer(messages(app, "/cloud")[-1].data.tobytes(), "<f4").reshape(48, 64, 3)
    np.testing.assert_allclose(points[..., 2], depth, rtol=1e-6)
    np.testing.assert_allclose(points[..., 0], depth * (np.arange(64) + 0.5 - 32) / FX, rtol=1e-4, atol=1e-5)


STEREO = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [4, 0, 0]}
    /World/Camera:
      type: Camera
      rotate: [90, 0, -90]
      attributes: {"omni:rtx:post:depthSensor:baselineMM": 95, "omni:rtx:post:depthSensor:noiseSigma": 0.2}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 64, height: 48}}
      depth: {type: ROS2CameraHelper, inputs: {type: stereo_depth, topicName: depth}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> depth.execIn
      - product.renderProductPath -> depth.renderProductPath
"""


def test_a_graph_file_publishes_stereo_depth_whose_noise_is_that_of_the_seed(tmp_path):
    from graph.session.open import open_session

    (tmp_path / "a.yaml").write_text(STEREO)

    def run(seed):
        with open_session(tmp_path / "a.yaml", seed=seed).app as app:
            sink = MemorySink()
            app.bus.subscribe(sink)
            app.play()
            app.update(3)
            return [one.message.data.tobytes() for one in sink["/depth"]]

    first, again, other = run(1), run(1), run(2)
    assert len(set(first)) == len(first) >= 2
    assert first == again
    assert not set(first) & set(other)


def test_the_cloud_of_an_orthographic_camera_starts_each_ray_at_its_pixel(app, stage):
    """An aperture of 20.48 tenths is 2.048 m wide: 31.25 px a metre. The box, 1 m wide, is 3.5 m away, the wall 9 m."""
    UsdGeom.Camera.Get(stage, CAMERA).GetProjectionAttr().Set("orthographic")
    helper(app, "depth_pcl", topicName="cloud")
    cloud = messages(app, "/cloud")[0]
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(48, 64, 3)
    x, y = (np.arange(64) + 0.5 - 32) / 31.25, (np.arange(48) + 0.5 - 24) / 31.25
    np.testing.assert_allclose(points[..., 0], np.broadcast_to(x, (48, 64)), atol=1e-6)
    np.testing.assert_allclose(points[..., 1], np.broadcast_to(y[:, None], (48, 64)), atol=1e-6)
    on_box = (np.abs(x) < 0.5) & (np.abs(y) < 0.5)[:, None]
    np.testing.assert_allclose(points[..., 2], np.where(on_box, 3.5, 9.0), rtol=1e-6)


def test_depth_is_metres_along_the_view_axis(app):
    helper(app, "depth", topicName="depth")
    depth = messages(app, "/depth")[0]
    assert (depth.encoding, depth.step) == ("32FC1", 256)
    values = pixels(depth, "<f4")
    assert values[24, 32] == pytest.approx(3.5, rel=1e-6)
    assert values[0, 0] == pytest.approx(9.0, rel=1e-6)


def test_a_cloud_of_depth_is_in_the_optical_frame_pixel_by_pixel(app):
    helper(app, "depth_pcl", topicName="cloud")
    cloud = messages(app, "/cloud")[0]
    assert (cloud.height, cloud.width, cloud.point_step) == (1, 64 * 48, 12)
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(48, 64, 3)
    assert points[24, 32] == pytest.approx([3.5 * 0.5 / FX, 3.5 * 0.5 / FX, 3.5], rel=1e-5)
    assert points[0, 0] == pytest.approx([-9 * 31.5 / FX, -9 * 23.5 / FX, 9.0], rel=1e-5)


def test_what_a_camera_does_not_hit_is_not_a_number_in_clouds_and_infinite_in_depth(app):
    app.stage.RemovePrim("/World/Wall")
    helper(app, "depth_pcl", topicName="cloud")
    cloud = messages(app, "/cloud")[0]
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(48, 64, 3)
    assert np.isnan(points[0, 0]).all()
    assert not cloud.is_dense


@pytest.mark.parametrize(("of_corners", "column"), [(False, 32.5), (True, 32)])
def test_points_are_seen_through_the_middles_of_pixels_unless_a_setting_says_corners(app, of_corners, column):
    """The front at 3.5 m, f = 62.5 px: pixel (32, 24) is 28 mm off the axis at its middle, on it at its corner."""
    app.settings.set("/tickgraph/cameraCloudOfCorners", of_corners)
    helper(app, "depth_pcl", topicName="cloud")
    [cloud] = messages(app, "/cloud")[:1]
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(48, 64, 3)
    away = (column - 32) * 3.5 / 62.5
    np.testing.assert_allclose(points[24, 32], [away, away, 3.5], atol=1e-5)


@pytest.mark.parametrize(
    ("kind", "labels"),
    [
        ("semantic_segmentation", {"1": {"class": "UNLABELLED"}, "2": {"class": "crate"}}),
        ("instance_segmentation", {"1": "UNLABELLED", "2": "/World/Box"}),
    ],
)
def test_segmentations_are_32sc1_with_their_labels_when_wanted(app, kind, labels):
    helper(app, kind, topicName="ids", enableSemanticLabels=True)
    image, text = messages(app, "/ids")[0], messages(app, "/semantic_labels")[0]
    assert image.encoding == "32SC1"
    numbers = pixels(image, "<i4")
    assert (numbers[24, 32], numbers[0, 0]) == (2, 1)
    stamp = {"sec": image.header.stamp.sec, "nanosec": image.header.stamp.nanosec}
    assert json.loads(text.data) == {**labels, "time_stamp": stamp}


def test_boxes_in_the_image_are_detections(app):
    """+-0.5 x 62.5 / 3.5 = 8.93 px about (32, 24): columns 24 to 40."""
    helper(app, "bbox_2d_tight", topicName="boxes", enableSemanticLabels=True)
    [detection] = messages(app, "/boxes")[0].detections
    box = detection.bbox
    low, high = np.ceil(32 - 62.5 / 7 - 0.5), np.floor(32 + 62.5 / 7 - 0.5)
    assert (box.center.position.x, box.size_x) == ((low + high) / 2, high - low)
    assert (box.center.position.y, box.size_y) == ((low + high) / 2 - 8, high - low)
    assert (detection.results[0].hypothesis.class_id, detection.results[0].hypothesis.score) == ("0", 1.0)
    assert json.loads(messages(app, "/semantic_labels")[0].data)["0"] == {"class": "crate"}


@pytest.mark.parametrize(("in_world", "centre"), [(False, (0, 0, 4)), (True, (4, 0, 1))])
def test_boxes_in_space_are_in_the_optical_frame_unless_a_setting_says_world(app, in_world, centre):
    app.settings.set("/tickgraph/cameraBoxesInWorld", in_world)
    helper(app, "bbox_3d", topicName="boxes")
    [detection] = messages(app, "/boxes")[0].detections
    position, size = detection.bbox.center.position, detection.bbox.size
    assert (position.x, position.y, position.z) == pytest.approx(centre, abs=1e-6)
    assert (size.x, size.y, size.z) == pytest.approx((1, 1, 1), abs=1e-6)


@pytest.mark.parametrize(("in_world", "centre"), [(False, (0.5, 0, 4)), (True, (4, 0, 1))])
def test_a_box_is_centred_on_its_mesh_or_as_the_product_does_on_its_prim(app, in_world, centre):
    """A prim at the box's place whose mesh reaches from y = -1 to 0: its middle is 0.5 m to the right."""
    app.stage.RemovePrim("/World/Box")
    mesh = UsdGeom.Mesh.Define(app.stage, "/World/Side")
    mesh.CreatePointsAttr([(0, 0, -0.5), (0, -1, -0.5), (0, -1, 0.5), (0, 0, 0.5)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.AddTranslateOp().Set((4, 0, 1))
    mesh.GetPrim().AddAppliedSchema("SemanticsLabelsAPI:class")
    mesh.GetPrim().GetAttribute("semantics:labels:class").Set(["side"])
    app.settings.set("/tickgraph/cameraBoxesInWorld", in_world)
    helper(app, "bbox_3d", topicName="boxes")
    [detection] = messages(app, "/boxes")[0].detections
    position = detection.bbox.center.position
    assert (position.x, position.y, position.z) == pytest.approx(centre, abs=1e-6)


def test_without_a_subscriber_nothing_is_computed(stage, app):
    with App(stage) as silent:
        helper(silent)
        product = silent.rendering.products[render_product(silent, CAMERA, SIZE).path]
        assert (product.frames, product.sensor.consumers(), product.frame.arrays) == (3, {}, {})
    helper(app)
    assert list(app.rendering.products[render_product(app, CAMERA, SIZE).path].sensor.consumers()) == ["rgb"]


def test_frames_can_be_left_out(app):
    trace = helper(app, updates=6, frameSkipCount=2)
    assert len(messages(app, "/rgb")) == 2
    assert [warning.code for warning in trace.warnings] == ["frame-skip-deprecated"]


def decoded(found):
    """(n, height, width, 3) uint8 pictures of compressed messages."""
    import av

    codec = av.CodecContext.create("h264", "r")
    packets = [av.Packet(one.data.tobytes()) for one in found]
    frames = [frame for packet in (*packets, None) for frame in codec.decode(packet)]
    return np.stack([frame.to_ndarray(format="rgb24") for frame in frames])


def test_video_has_a_message_for_each_picture_and_shows_the_same(app):
    pytest.importorskip("av")
    helper(app, "rgb_h264", updates=4, topicName="video")
    found = messages(app, "/video")
    assert [one.format for one in found] == ["h264"] * 4
    assert [one.header.stamp.nanosec for one in found] == [16_666_667, 33_333_333, 50_000_000, 66_666_667]
    pictures = decoded(found)
    helper(app)
    plain = pixels(messages(app, "/rgb")[0], np.uint8, 3)
    assert pictures.shape == (4, 48, 64, 3)
    assert np.abs(pictures.mean(axis=(0, 1, 2)) - plain.mean(axis=(0, 1))).max() < 5
    assert pictures[0, 24, 32] == pytest.approx([255, 0, 0], abs=15)


def test_video_is_the_same_bytes_in_every_run(stage, app):
    pytest.importorskip("av")
    helper(app, "rgb_h264", updates=3, topicName="video")
    with App(stage, physics_hz=240) as again:
        again.sink = type(app.sink)()
        again.bus.subscribe(again.sink)
        helper(again, "rgb_h264", updates=3, topicName="video")
        assert [one.data.tobytes() for one in messages(again, "/video")] == [
            one.data.tobytes() for one in messages(app, "/video")
        ]


def test_video_of_an_odd_size_is_refused_in_one_line(app):
    pytest.importorskip("av")
    with pytest.raises(ComputeError, match=r"needs an even width and height; .* has 63 x 48 pixels"):
        helper(app, "rgb_h264", size=(63, 48))


def test_video_without_its_package_is_refused_in_one_line(app, monkeypatch):
    monkeypatch.setattr("nodes.ros2.camera_helper.has_encoder", lambda: False)
    with pytest.raises(ComputeError, match=r"needs the package av; use type rgb, or run: .*pip install .*\[video\]'"):
        helper(app, "rgb_h264")


def test_a_product_of_a_lidar_is_reported_and_publishes_nothing(app):
    app.stage.DefinePrim("/World/Lidar", "OmniLidar")
    path = render_product(app, "/World/Lidar").path
    trace = run_node("ROS2CameraHelper", inputs={"renderProductPath": path}, pulses={"execIn": [0]}, app=app)
    assert [warning.code for warning in trace.warnings] == ["not-a-camera"]
    assert not messages(app, "/rgb")


def test_camera_info_has_the_matrix_of_focal_length_and_aperture(app):
    helper(app, node="ROS2CameraInfoHelper")
    info = messages(app, "/camera_info")
    assert len(info) == 3
    first = info[0]
    assert (first.width, first.height, first.distortion_model) == (64, 48, "plumb_bob")
    assert first.k.tolist() == pytest.approx([FX, 0, 32, 0, FX, 24, 0, 0, 1], rel=1e-6)
    assert first.p.tolist() == pytest.approx([FX, 0, 32, 0, 0, FX, 24, 0, 0, 0, 1, 0], rel=1e-6)
    assert (first.d.tolist(), first.r.tolist()) == ([0.0] * 5, [1.0, 0, 0, 0, 1, 0, 0, 0, 1])
    assert first.header.stamp.nanosec == 16_666_667


def test_camera_info_follows_a_lens_that_changes_while_playing(stage, app):
    """The camera is read again in the update after a change: 40 mm for 20 double K, as the picture does."""

    def zoomed(update):
        if update == 2:
            UsdGeom.Camera(stage.GetPrimAtPath(CAMERA)).GetFocalLengthAttr().Set(40.0)
        return True

    helper(app, node="ROS2CameraInfoHelper", updates=5, enabled=zoomed)
    assert [one.k[0] for one in messages(app, "/camera_info")] == pytest.approx([FX, FX, FX, 2 * FX, 2 * FX])


@pytest.mark.parametrize(
    ("schema", "model", "values", "distortion", "coefficients"),
    [
        ("OpenCvPinhole", "opencvPinhole", {"k1": 0.1, "p2": 0.02, "k3": 0.3}, "plumb_bob", [0.1, 0, 0, 0.02, 0.3]),
        (
            *("OpenCvPinhole", "opencvPinhole", {"k1": 0.1, "k6": 0.6, "s1": 0.01}, "rational_polynomial"),
            [0.1, 0, 0, 0, 0, 0, 0, 0.6, 0.01, 0, 0, 0],
        ),
        ("OpenCvFisheye", "opencvFisheye", {"k1": 0.05, "k4": 0.01}, "equidistant", [0.05, 0, 0, 0.01]),
        ("Ftheta", "ftheta", {}, "plumb_bob", [0, 0, 0, 0, 0]),
    ],
)
def test_a_lens_schema_gives_the_distortion_model(app, schema, model, values, distortion, coefficients):
    prim = app.stage.GetPrimAtPath(CAMERA)
    prim.AddAppliedSchema(f"OmniLensDistortion{schema}API")
    for name, value in values.items():
        prim.GetAttribute(f"omni:lensdistortion:{model}:{name}").Set(value)
    trace = helper(app, node="ROS2CameraInfoHelper")
    info = messages(app, "/camera_info")[0]
    assert info.distortion_model == distortion
    assert info.d.tolist() == pytest.approx(coefficients, abs=1e-6)
    focal = (900 * 64 / 2048, 800 * 48 / 1024) if model.startswith("opencv") else (FX, FX)
    assert info.k.tolist() == pytest.approx([focal[0], 0, 32, 0, focal[1], 24, 0, 0, 1])
    assert [warning.code for warning in trace.warnings] == (["lens-without-model"] if model == "ftheta" else [])


@pytest.mark.parametrize(("parity", "fy"), [("documented", 37.5), ("isaacsim-6.0.1", 28.125)])
def test_two_focal_lengths_are_told_as_they_are_or_as_the_product_does(stage, app, parity, fy):
    """At 64 x 48: fx = 900 x 64 / 2048 = 28.125, fy = 800 x 48 / 1024 = 37.5; the product writes fx for it."""
    with App(stage, parity=parity) as app:
        app.bus.subscribe(sink := MemorySink())
        app.stage.GetPrimAtPath(CAMERA).AddAppliedSchema("OmniLensDistortionOpenCvPinholeAPI")
        trace = helper(app, node="ROS2CameraInfoHelper", updates=4)
        info = sink["/camera_info"][0].message
    assert info.k.tolist() == pytest.approx([28.125, 0, 32, 0, fy, 24, 0, 0, 1])
    assert info.p.tolist() == pytest.approx([28.125, 0, 32, 0, 0, fy, 24, 0, 0, 0, 1, 0])
    said = [warning.message for warning in trace.warnings if warning.code == "camera-info-square"]
    assert len(said) == (fy == 28.125)
    assert all("fx 28.125 for fy 37.5" in one for one in said)


def played(stage, parity, **inputs):
    """The stamps [ns] of pictures, simulation time [ns] -> wall time [s] of each physics step, and the warnings."""
    steps = {}
    with App(stage, parity=parity, physics_hz=60, loop_hz=60) as app:
        app.bus.subscribe(sink := MemorySink())
        times = app.simulation
        app.on("physics_post_step", lambda: steps.setdefault(nanoseconds(times.time), times.system_time))
        trace = helper(app, updates=5, **inputs)
    stamps = [one.message.header.stamp for one in sink["/rgb"]]
    return [one.sec * 10**9 + one.nanosec for one in stamps], steps, [one.code for one in trace.warnings]


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_system_time_is_the_wall_time_of_the_step_that_a_picture_shows(stage, app, parity):
    """Without useSystemTime the same pictures have the simulation time of that step: one step of 1/60 s an update."""
    plain, _, said = played(stage, parity)
    assert len(plain) > 2
    assert said == []
    walls, steps, said = played(stage, parity, useSystemTime=True)
    assert walls == [round(steps[moment] * 1e9) for moment in plain]
    assert said == ["system-time-never-resets"]


def right_product(app):
    """The path of a second camera's product, 0.15 m to the right of the first."""
    right = UsdGeom.Camera.Define(app.stage, "/World/Right")
    for name in ("focalLength", "horizontalAperture", "clippingRange"):
        right.GetPrim().GetAttribute(name).Set(app.stage.GetPrimAtPath(CAMERA).GetAttribute(name).Get())
    right.AddTranslateOp().Set((0, -0.15, 1))
    right.AddRotateXYZOp().Set((90, 0, -90))
    return render_product(app, "/World/Right", SIZE).path


def test_a_stereo_pair_has_its_baseline_in_the_right_projection(app):
    """0.15 m to the right: P[3] = -62.5 x 0.15 = -9.375."""
    path = right_product(app)
    helper(app, node="ROS2CameraInfoHelper", renderProductPathRight=path)
    left, right = messages(app, "/camera_info")[0], messages(app, "/camera_info_right")[0]
    assert left.p.tolist()[3] == 0
    assert right.p.tolist()[3] == pytest.approx(-FX * 0.15, rel=1e-6)
    assert right.header.frame_id == "sim_camera_right"
    assert left.r.tolist() == pytest.approx([1, 0, 0, 0, 1, 0, 0, 0, 1], abs=1e-9)


def test_cameras_of_different_lenses_are_rectified_to_one(app):
    """Half the film: f is 62.5 px and 125 px, in the mean 93.75. A point 6 m ahead of the left camera, 1 m above it, is
    93.75 / 6 = 15.625 px above the middle in both, and 93.75 x 0.15 / 6 = 2.34375 px further left in the right one.
    """
    path = right_product(app)
    aperture = app.stage.GetPrimAtPath("/World/Right").GetAttribute("horizontalAperture")
    aperture.Set(aperture.Get() / 2)
    helper(app, node="ROS2CameraInfoHelper", renderProductPathRight=path)
    left, right = messages(app, "/camera_info")[0], messages(app, "/camera_info_right")[0]
    assert (left.k[0], right.k[0]) == pytest.approx((FX, 2 * FX), rel=1e-6)
    seen = [one.p.reshape(3, 4) @ [0.0, -1.0, 6.0, 1.0] / 6 for one in (left, right)]
    np.testing.assert_allclose(seen, [[32, 24 - 15.625, 1], [32 - 2.34375, 24 - 15.625, 1]], rtol=1e-6)


def test_a_right_camera_that_comes_later_makes_a_pair_of_both(app):
    path = right_product(app)
    helper(app, node="ROS2CameraInfoHelper", renderProductPathRight=lambda update: path if update else "", updates=4)
    assert [one.header.stamp.nanosec for one in messages(app, "/camera_info")] == [
        *(16_666_667, 33_333_333, 50_000_000, 66_666_667)
    ]
    right = messages(app, "/camera_info_right")
    assert [one.header.stamp.nanosec for one in right] == [33_333_333, 50_000_000, 66_666_667]
    assert right[0].p.tolist()[3] == pytest.approx(-FX * 0.15, rel=1e-6)


def test_switching_a_pair_off_silences_both_cameras(app):
    path = right_product(app)
    on = {"renderProductPathRight": path, "enabled": lambda update: update < 2}
    helper(app, node="ROS2CameraInfoHelper", updates=4, **on)
    assert [len(messages(app, topic)) for topic in ("/camera_info", "/camera_info_right")] == [2, 2]


def test_a_pair_of_two_sizes_is_reported_and_publishes_nothing(app):
    path = render_product(app, CAMERA, (32, 24)).path
    trace = helper(app, node="ROS2CameraInfoHelper", renderProductPathRight=path)
    assert "stereo-unlike" in {warning.code for warning in trace.warnings}
    assert not messages(app, "/camera_info")


@needs_wing("ucx")
def test_the_ucx_helper_sends_pictures(app):
    helper(app, node="UCXCameraHelper")
    found = messages(app, "/ucx/port_13337/tag_270059627")
    assert [one.encoding for one in found] == ["rgb8"] * 3
    assert pixels(found[0], np.uint8, 3)[24, 32].tolist() == [255, 0, 0]
