"""Images, camera parameters, labels."""

import json

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from sensors import handles


def once(kind, app, **inputs):
    return run_node(kind, inputs=inputs, pulses={"execIn": [0]}, app=app)


def test_an_image_has_rows_without_padding(world, plain):
    app = world()
    once("ROS2PublishImage", app, data=list(range(12)), width=2, height=2, encoding="rgb8", timeStamp=1.5)
    [message] = plain(app, "/rgb")
    assert message["header"] == {"stamp": {"sec": 1, "nanosec": 500_000_000}, "frame_id": "sim_camera"}
    assert (message["height"], message["width"], message["encoding"], message["step"]) == (2, 2, "rgb8", 6)
    assert message["data"] == list(range(12))


def test_an_image_behind_a_handle_is_sent_byte_for_byte(world):
    app = world()
    depth = np.array([[1.5, 2.5, np.inf]], np.float32)
    once("ROS2PublishImage", app, dataPtr=handles.handle(depth), width=3, height=1, encoding="32FC1")
    message = app.sink["/rgb"][0].message
    assert message.step == 12
    assert np.array_equal(message.data.view(np.float32), [1.5, 2.5, np.inf])


def test_before_the_first_frame_there_is_no_image(world, plain):
    app = world()
    once("ROS2PublishImage", app)
    once("ROS2PublishCompressedImage", app)
    assert plain(app, "/rgb") == plain(app, "/image_raw/compressed") == []


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"data": [1, 2, 3], "width": 2, "height": 1}, "2 x 1 pixels of rgb8 are 6 bytes, but there are 3"),
        ({"dataPtr": 10**15, "width": 2, "height": 1}, "refers to no live image"),
        ({"data": [1, 2, 3], "cudaDeviceIndex": 0}, "pixels are in host memory; set it to -1"),
    ],
)
def test_pixels_that_do_not_fit_stop_the_run(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        once("ROS2PublishImage", world(), **inputs)


def test_an_encoded_image_keeps_its_format(world, plain):
    app = world()
    once("ROS2PublishCompressedImage", app, data=[0, 0, 1])
    [message] = plain(app, "/image_raw/compressed")
    assert (message["format"], message["data"]) == ("h264", [0, 0, 1])


K = [500.0, 0, 320, 0, 510, 240, 0, 0, 1]


def test_camera_parameters_with_their_usual_rest(world, plain):
    app = world()
    once("ROS2PublishCameraInfo", app, width=640, height=480, k=K)
    [message] = plain(app, "/camera_info")
    assert (message["width"], message["height"], message["distortion_model"]) == (640, 480, "plumb_bob")
    assert message["d"] == [0.0] * 5
    assert message["k"] == K
    assert message["r"] == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert message["p"] == [500, 0, 320, 0, 0, 510, 240, 0, 0, 0, 1, 0]


def test_given_camera_parameters_are_kept(world, plain):
    app = world()
    p = [500.0, 0, 320, -50, 0, 510, 240, 0, 0, 0, 1, 0]
    once("ROS2PublishCameraInfo", app, k=K, p=p, physicalDistortionModel="equidistant",
         physicalDistortionCoefficients=[0.5, 0.25, 0, 0])  # fmt: skip
    [message] = plain(app, "/camera_info")
    assert (message["distortion_model"], message["d"], message["p"]) == ("equidistant", [0.5, 0.25, 0, 0], p)


@pytest.mark.parametrize(("inputs", "message"), [({}, "k has 0 values; it needs 9"), ({"k": K, "p": K}, "p has 9")])
def test_matrices_of_the_wrong_size_stop_the_run(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        once("ROS2PublishCameraInfo", world(), **inputs)


def labels(app):
    return json.loads(app.sink["/labels"][0].message.data)


def test_labels_are_json_with_their_stamp(world):
    app = world()
    once("ROS2PublishSemanticLabels", app, ids=[1, 7], labels=["class:car", "sky"], timeStamp=2.5)
    stamp = {"sec": 2, "nanosec": 500_000_000}
    assert labels(app) == {"1": {"class": "car"}, "7": "sky", "time_stamp": stamp}


def test_ready_made_labels_win(world):
    app = world()
    once("ROS2PublishSemanticLabels", app, ids=[1], labels=["sky"], idToLabels='{"3": {"class": "road"}}')
    assert labels(app) == {"3": {"class": "road"}, "time_stamp": {"sec": 0, "nanosec": 0}}


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"ids": [1, 2], "labels": ["a"]}, "there are 2 ids and 1 labels"),
        ({"idToLabels": "{"}, "idToLabels is not JSON"),
        ({"idToLabels": "[]"}, "idToLabels is not a JSON object"),
    ],
)
def test_labels_that_do_not_add_up_stop_the_run(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        once("ROS2PublishSemanticLabels", world(), **inputs)


@pytest.mark.parametrize("packed", [False, True])
def test_object_ids_are_published_with_their_prims(world, packed):
    from sensors.surfaces.ids import pack_stable_id_map

    app, paths = world(), {5: "/World/A", 2**100: "/World/B"}
    content = pack_stable_id_map(paths) if packed else paths
    once("ROS2PublishObjectIdMap", app, dataPtr=handles.handle(content), timeStamp=1.0)
    assert labels(app) == {
        "id_to_labels": {"5": "/World/A", str(2**100): "/World/B"},
        "time_stamp": {"sec": 1, "nanosec": 0},
    }


def test_without_a_map_no_object_ids_are_sent(world):
    app = world()
    once("ROS2PublishObjectIdMap", app)
    assert app.sink["/labels"] == []
