"""Clouds as lidar drivers publish them."""

import numpy as np
import pytest

from graph import ComputeError
from graph.cli.main import main
from graph.testing import run_node
from sensors import render_product

LAYOUTS = {
    # velodyne_pointcloud, PointXYZIRT: packed fields
    "velodyne": (22, "x f4 0, y f4 4, z f4 8, intensity f4 12, ring u2 16, time f4 18"),
    # ouster_ros, Point: 16 bytes of PCL_ADD_POINT4D, then C's alignment, and 16 for the whole
    "ouster": (
        48,
        "x f4 0, y f4 4, z f4 8, intensity f4 16, t u4 20, reflectivity u2 24, ring u2 26, ambient u2 28, range u4 32",
    ),
    # autoware_point_types, PointXYZIRCAEDT
    "autoware": (
        32,
        "x f4 0, y f4 4, z f4 8, intensity u1 12, return_type u1 13, channel u2 14, azimuth f4 16, elevation f4 20, "
        "distance f4 24, time_stamp u4 28",
    ),
}
FORMATS = {2: "u1", 4: "u2", 6: "u4", 7: "f4"}


def clouds(app, **inputs):
    path = render_product(app, "/World/Lidar").path
    inputs = {"renderProductPath": path, "topicName": "points", "type": "point_cloud", **inputs}
    run_node("ROS2RtxLidarHelper", inputs=inputs, pulses={"execIn": range(13)}, updates=13, app=app)
    return [one.message for one in app.sink["/points"]]


def points(cloud):
    names = [field.name for field in cloud.fields]
    formats = [f"<{FORMATS[field.datatype]}" for field in cloud.fields]
    offsets = [field.offset for field in cloud.fields]
    layout = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": cloud.point_step})
    return np.frombuffer(cloud.data.tobytes(), layout)


@pytest.mark.parametrize("driver", LAYOUTS)
def test_names_offsets_and_types_are_those_of_the_driver(lidar, world, driver):
    lidar()
    cloud = clouds(world(physics_hz=240), fields=driver)[0]
    step, said = LAYOUTS[driver]
    found = ", ".join(f"{one.name} {FORMATS[one.datatype]} {one.offset}" for one in cloud.fields)
    assert (cloud.point_step, found) == (step, said)
    assert all(one.count == 1 for one in cloud.fields)
    assert cloud.data.size == cloud.row_step == step * cloud.width
    assert not cloud.is_bigendian


def test_times_count_from_the_stamp_of_the_header(lidar, world):
    lidar()
    app = world(physics_hz=240)
    cloud = clouds(app, fields="ouster")[0]
    # The turn [0, 0.1 s): stamped with its first firing, the last one just before 0.1 s.
    # Never 0, by which tf2 means the latest transform.
    assert (cloud.header.stamp.sec, cloud.header.stamp.nanosec) == (0, 1)
    times = points(cloud)["t"]
    assert times.min() < 1_000_000
    assert 90_000_000 < times.max() < 100_000_000


def test_velodyne_counts_seconds_from_the_start_of_the_scan(lidar, world):
    """As LIO-SAM takes it: the scan begins at the header and ends at the header plus the last point's time."""
    lidar()
    second = clouds(world(physics_hz=240), fields="velodyne")[1]
    assert second.header.stamp.nanosec == 100_000_000
    times = points(second)["time"]
    assert 0 <= times.min() < 0.001
    assert 0.09 < times.max() < 0.1


def test_ranges_and_angles_agree_with_the_coordinates(lidar, world):
    lidar()
    found = points(clouds(world(physics_hz=240), fields="autoware")[0])
    x, y, z = (found[axis].astype(float) for axis in "xyz")
    np.testing.assert_allclose(found["distance"], np.sqrt(x * x + y * y + z * z), rtol=1e-6)
    np.testing.assert_allclose(found["distance"] * np.cos(found["elevation"]) * np.cos(found["azimuth"]), x, atol=1e-4)
    assert set(found["return_type"]) == {1}  # SINGLE_STRONGEST
    assert found["intensity"].max() > 0


def test_ouster_ranges_are_millimetres_and_reflectivity_is_up_to_255(lidar, world):
    lidar()
    found = points(clouds(world(physics_hz=240), fields="ouster")[0])
    distance = np.sqrt(sum(found[axis].astype(float) ** 2 for axis in "xyz"))
    np.testing.assert_allclose(found["range"], distance * 1000, atol=1)
    np.testing.assert_allclose(found["reflectivity"], found["intensity"], atol=0.5)
    assert 0 < found["reflectivity"].max() <= 255


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"fields": "ouster", "selectedMetadata": ["Ring"]}, "fields ouster fixes the fields of the cloud"),
        ({"fields": "ouster", "type": "laser_scan"}, "fields is for clouds"),
    ],
)
def test_contradictions_are_one_line(lidar, world, inputs, said):
    lidar()
    with pytest.raises(ComputeError, match=said):
        clouds(world(), **inputs)


def test_check_finds_a_misspelt_driver(tmp_path, capsys):
    file = tmp_path / "g.yaml"
    file.write_text(
        "tickgraph: 1\ngraphs:\n  /World/G:\n    nodes:\n"
        "      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, fields: outser}}\n"
    )
    assert main(["check", str(file)]) == 2
    assert "outser" in capsys.readouterr().err


def test_an_organised_cloud_is_an_image_of_lines_by_firings(lidar, world):
    """XT32 at 10 Hz: 32 lines of 2000 firings, a row for each line from the lowest up, as Ouster's drivers have it."""
    lidar("XT32")
    app = world(physics_hz=240)
    clouds(app, fields="ouster", topicName="image", organized=True)
    image = app.sink["/image"][0].message
    [flat, *_] = clouds(world(physics_hz=240), fields="ouster")
    assert (image.height, image.width, image.row_step) == (32, 2000, 48 * 2000)
    assert not image.is_dense
    grid = points(image).reshape(32, 2000)
    seen = np.isfinite(grid["x"])
    assert seen.sum() == flat.width
    rows = np.broadcast_to(np.arange(32)[:, None], grid.shape)
    np.testing.assert_array_equal(grid["ring"][seen], rows[seen])
    heights = np.rad2deg(np.arctan2(grid["z"], np.hypot(grid["x"], grid["y"])))
    np.testing.assert_allclose(heights[seen], rows[seen] - 16, atol=1e-3)  # -16 to 15 deg, a degree apart
    # Columns follow each other as they fire: 50 us apart, clockwise.
    columns = np.broadcast_to(np.arange(2000), grid.shape)
    assert np.abs(grid["t"][seen].astype(float) - columns[seen] * 50e3).max() < 50e3


def test_an_organised_cloud_without_fields_has_the_chosen_ones(lidar, world):
    lidar()
    [image, *_] = clouds(world(), organized=True, selectedMetadata=["Ring", "Intensity"])
    assert (image.height, image.width) == (1, 3600)
    assert [field.name for field in image.fields] == ["x", "y", "z", "intensity", "ring"]


def test_a_laser_scan_is_not_an_image(tmp_path, capsys):
    file = tmp_path / "g.yaml"
    file.write_text(
        "tickgraph: 1\ngraphs:\n  /World/G:\n    nodes:\n"
        "      cloud: {type: ROS2RtxLidarHelper, inputs: {type: laser_scan, organized: true}}\n"
    )
    assert main(["check", str(file)]) == 2
    assert "organized is for clouds" in capsys.readouterr().err
