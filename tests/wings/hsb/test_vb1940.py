"""Raw frames of the sensor bridge: sizes, Bayer pattern, packing, and where they are sent."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph import ComputeError
from graph.testing import run_node
from sensors import render_product
from wings.hsb.vb1940 import COE, LINUX, bayer, frame_bytes, packed


@pytest.mark.parametrize(("mode", "line", "frame"), [(LINUX, 2400, 2_599_200), (COE, 2560, 2_772_480)])
def test_a_full_hd_frame_has_its_size(mode, line, frame):
    """Four samples are five bytes, three are four; a line of zeros before 1080 and two after."""
    found = frame_bytes(np.full((1080, 1920, 3), 255, np.uint8), mode)
    assert len(found) == frame == line * 1083
    assert not found[:line].any()
    assert not found[-2 * line :].any()
    assert found[line : line + 4].tolist() == ([255] * 4 if mode == LINUX else [255, 255, 255, 63])


def test_the_pattern_is_green_blue_above_red_green_and_ten_bits_round_half_to_even():
    """v 1023 / 255 = 4.0117... v: 100 is 401.18, 200 is 802.35, 50 is 200.59."""
    colours = np.tile(np.array([50, 100, 200], np.uint8), (2, 4, 1))
    assert bayer(colours).tolist() == [[401, 802, 401, 802], [201, 401, 201, 401]]


def test_samples_are_packed_as_their_data_planes_say():
    """Samples 1, 2, 3, 1023: upper bits 0, 0, 0, 255, lower bits 1 + 2 * 4 + 3 * 16 + 3 * 64 = 249; as a word
    1 + 2 * 2^10 + 3 * 2^20 = 3147777 = 0x00300801, then 1023 alone.
    """
    samples = np.array([[1, 2, 3, 1023]], np.uint16)
    assert packed(samples, LINUX).reshape(4, 8)[1].tolist() == [0, 0, 0, 255, 249, 0, 0, 0]
    assert packed(samples, COE).reshape(4, 64)[1, :8].tolist() == [0x01, 0x08, 0x30, 0, 0xFF, 0x03, 0, 0]


def test_the_node_converts_pixels_of_either_encoding_and_refuses_other_sizes(world):
    inputs = {"width": 4, "height": 2, "data": [50, 100, 200, 255] * 8, "encoding": "rgba8"}
    data = run_node("RGBToVB1940", inputs=inputs, pulses={"execIn": [0]}, app=world()).value("data")
    colours = np.tile(np.array([50, 100, 200], np.uint8), (2, 4, 1))
    assert np.array_equal(data, frame_bytes(colours, LINUX))
    with pytest.raises(ComputeError, match="are 24 bytes, but there are 32"):
        run_node("RGBToVB1940", inputs={**inputs, "encoding": "rgb8"}, pulses={"execIn": [0]}, app=world())


def test_bytes_are_sent_on_the_topic_of_their_receiver(world):
    app = world()
    inputs = {"data": [1, 2, 3], "dataPlaneId": 1, "sensorId": 2, "timeStamp": 0.5}
    trace = run_node("HSBSend", inputs=inputs, pulses={"execIn": [0]}, app=app)
    [sent] = app.sink["/hsb/receiver_127_0_0_1/plane_coe_1/sensor_2"]
    assert (sent.message.data.tolist(), sent.stamp_ns) == ([1, 2, 3], 500_000_000)
    assert trace.fired("execOut") == [0]
    with pytest.raises(ComputeError, match='dataPlaneType is "udp"; use coe or linux'):
        run_node("HSBSend", inputs={**inputs, "dataPlaneType": "udp"}, pulses={"execIn": [0]}, app=app)


def test_the_helper_sends_every_picture_of_a_camera_as_a_raw_frame(stage, world):
    """The sky of 1250 nit is 255 after exposure (1250 x 8e-4 = 1), so that every sample is 1023."""
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(0.01, 1000))
    stage.DefinePrim("/World/Sky", "DomeLight").GetAttribute("inputs:intensity").Set(1250.0)
    app = world()
    inputs = {"renderProductPath": render_product(app, "/World/Camera", (8, 4)).path, "type": LINUX}
    run_node("HSBCameraHelper", inputs=inputs, pulses={"execIn": range(3)}, updates=3, app=app)
    sent = app.sink["/hsb/receiver_127_0_0_1/plane_coe_0/sensor_0"]
    assert len(sent) == 3
    white = packed(np.full((4, 8), 1023, np.uint16), LINUX)
    assert np.array_equal(sent[0].message.data, white)
