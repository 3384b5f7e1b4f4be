"""Images and depth: every byte by hand."""

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from sensors.handles import handle, resolve


def once(node, **inputs):
    return run_node(node, inputs=inputs, pulses={"execIn": [0]})


@pytest.mark.parametrize("kind", ["IsaacConvertRGBAToRGB", "IsaacConvertDepthToPointCloud"])
def test_no_image_yet_is_nothing_to_convert_and_no_source_is_reported(kind):
    trace = run_node(kind, pulses={"execIn": [0]}, connect={"dataPtr": "uint64"}, inputs={"dataPtr": 0})
    assert (trace.fired("execOut"), trace.warnings) == ([], [])
    trace = run_node(kind, pulses={"execIn": [0]})
    assert [(one.code, one.message.partition(",")[0]) for one in trace.warnings] == [
        ("image-missing", "input dataPtr is 0")
    ]


def test_an_image_of_one_colour():
    trace = run_node("IsaacGenerateRGBA", inputs={"color": [1, 0.5, 0, 1], "width": 2, "height": 1})
    assert trace.value("data").tolist() == [255, 127, 0, 255] * 2
    assert [trace.value(name) for name in ("width", "height", "encoding")] == [2, 1, "rgba8"]


def test_the_size_of_an_image_is_100_by_100_unless_given():
    assert run_node("IsaacGenerateRGBA", inputs={"color": [0, 0, 0, 0]}).value("data").size == 40000


def test_an_image_of_one_number():
    trace = run_node("IsaacGenerate32FC1", inputs={"value": 1.5, "width": 1, "height": 2})
    assert trace.value("data").tolist() == [0, 0, 0xC0, 0x3F] * 2  # 1.5 is 0x3fc00000
    assert trace.value("encoding") == "32FC1"


@pytest.mark.parametrize("node", ["IsaacGenerateRGBA", "IsaacGenerate32FC1"])
def test_an_image_that_fits_no_memory_is_refused(node):
    with pytest.raises(ComputeError, match="4000000000 x 4000000000 pixels are too many"):
        run_node(node, inputs={"width": 4_000_000_000, "height": 4_000_000_000})


def test_alpha_is_left_out():
    image = np.arange(16, dtype=np.uint8)
    trace = once("IsaacConvertRGBAToRGB", dataPtr=handle(image), width=2, height=2)
    made = resolve(trace.value("dataPtr"))
    assert made.reshape(-1).tolist() == [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14]
    assert [trace.value(name) for name in ("bufferSize", "encoding", "width", "height")] == [12, "rgb8", 2, 2]
    assert trace.fired("execOut") == [0]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"width": 3}, "the buffer has 16 bytes; an image of 3 x 2 pixels has 24"),
        ({"dataPtr": 12345}, "dataPtr is not a handle of a buffer"),
        ({"cudaDeviceIndex": 0}, "cudaDeviceIndex is 0; buffers are in host memory"),
        ({"encoding": "rgb8"}, 'encoding is "rgb8"; only rgba8 can be converted'),
    ],
)
def test_what_cannot_be_converted_is_reported(inputs, message):
    given = {"dataPtr": handle(np.zeros(16, np.uint8)), "width": 2, "height": 2, **inputs}
    with pytest.raises(ComputeError, match=message):
        once("IsaacConvertRGBAToRGB", **given)


def test_an_image_is_passed_on_as_it_is():
    given = {"dataPtr": 7, "cudaDeviceIndex": 2, "width": 4, "height": 3, "bufferSize": 48, "format": 11}
    trace = once("IsaacPassthroughImagePtr", **given)
    assert {name: trace.value(f"outputs:{name}") for name in given} == given
    assert trace.fired("execOut") == [0]


FILM = {"focalLength": 20.0, "horizontalAperture": 40.0, "verticalAperture": 20.0}


def test_depths_become_points_that_look_along_z():
    # 4 x 2 pixels: 4 * 20 / 40 = 2 pixels of focal length each way; the axis is at pixel (2, 1).
    depths = np.array([[2, 2, 2, 2], [4, np.inf, 4, 4]], dtype=np.float32)
    trace = once("IsaacConvertDepthToPointCloud", dataPtr=handle(depths), width=4, height=2, **FILM)
    points = resolve(trace.value("dataPtr"))
    assert points.dtype == np.float32
    nowhere = [np.nan] * 3
    wanted = [[-2, -1, 2], [-1, -1, 2], [0, -1, 2], [1, -1, 2], [-4, 0, 4], nowhere, [0, 0, 4], [2, 0, 4]]
    np.testing.assert_array_equal(points, wanted)
    assert [trace.value(f"outputs:{name}") for name in ("width", "height", "bufferSize")] == [8, 1, 96]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"focalLength": 0.0}, "focalLength and horizontalAperture must be above 0"),
        ({"format": 11}, "format is 11; only 33"),
    ],
)
def test_depths_that_cannot_be_placed_are_refused(inputs, message):
    given = {"dataPtr": handle(np.zeros((2, 4), np.float32)), "width": 4, "height": 2, **FILM, **inputs}
    with pytest.raises(ComputeError, match=message):
        once("IsaacConvertDepthToPointCloud", **given)
