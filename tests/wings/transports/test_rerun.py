"""A run in a Rerun viewer of its own process, which saves what it gets; and messages as archetypes."""

import hashlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from graph.sim.messages.ros_fields import from_plain
from graph.sim.messages.ros_types import deserialize
from tests.support.live_rig import CLOUDS, POINTS, free_port, recorded, run_rig, write_rig
from tests.support.programs import started
from wings.transports.rerun_archetypes import archetypes, points

rerun = pytest.importorskip("rerun", reason="pip install 'tickgraph[rerun]'")


def logged(type_name, **fields):
    """Entity path to archetypes, by their names, of a message on /t."""
    found = {}
    for path, archetype in archetypes(rerun, "/t", type_name, from_plain(type_name, fields)):
        found.setdefault(path, []).append(type(archetype).__name__)
    return found


def field(name, offset, datatype):
    return {"name": name, "offset": offset, "datatype": datatype, "count": 1}


def test_each_type_becomes_its_own_archetype():
    header = {"frame_id": "lidar"}
    assert logged("sensor_msgs/msg/LaserScan", header=header) == {"/t": ["Points3D", "CoordinateFrame"]}
    rgb = {"encoding": "rgb8", "height": 1, "width": 2, "step": 6, "data": [0] * 6}
    assert logged("sensor_msgs/msg/Image", **rgb) == {"/t": ["Image"]}
    depth = {"encoding": "32FC1", "height": 1, "width": 2, "step": 8, "data": [0] * 8}
    assert logged("sensor_msgs/msg/Image", **depth) == {"/t": ["DepthImage"]}
    labels = {"encoding": "32SC1", "height": 1, "width": 2, "step": 8, "data": [0] * 8}
    assert logged("sensor_msgs/msg/Image", **labels) == {"/t": ["SegmentationImage"]}
    camera = {"k": [9.0, 0, 1, 0, 9, 1, 0, 0, 1], "width": 2, "height": 2}
    assert logged("sensor_msgs/msg/CameraInfo", **camera) == {"/t": ["Pinhole"]}
    assert logged("std_msgs/msg/String", data="a") == {"/t": ["TextLog"]}
    assert logged("rosgraph_msgs/msg/Clock") == {}
    transform = {"header": {"frame_id": "world"}, "child_frame_id": "base"}
    assert logged("tf2_msgs/msg/TFMessage", transforms=[transform]) == {"/t/base": ["Transform3D"]}
    assert logged("geometry_msgs/msg/Twist") == {
        f"/t/{part}/{axis}": ["Scalars"] for part in ("linear", "angular") for axis in "xyz"
    }
    assert logged("sensor_msgs/msg/JointState", name=["a", "b"], position=[1.0, 2.0]) == {"/t/position": ["Scalars"]}


def test_points_are_read_by_their_fields_whatever_their_order_size_and_byte_order():
    # Two points of 20 bytes, big-endian: y as float64 at 0, 4 bytes unused, z as int16 at 12, x as float32 at 16.
    layout = np.dtype({"names": ["y", "z", "x"], "formats": [">f8", ">i2", ">f4"], "offsets": [0, 12, 16]})
    cloud = np.array([(2.0, 3, 1.0), (5.0, -6, 4.0)], layout)
    message = from_plain(
        "sensor_msgs/msg/PointCloud2",
        {
            "height": 1,
            "width": 2,
            "is_bigendian": True,
            "point_step": 20,
            "fields": [field("y", 0, 8), field("z", 12, 3), field("x", 16, 7)],
            "data": np.frombuffer(cloud.tobytes(), np.uint8),
        },
    )
    assert points(message).tolist() == [[1, 2, 3], [4, 5, -6]]


@pytest.mark.skipif(sys.platform == "win32", reason="ends a process group")
def test_a_viewer_gets_the_points_of_every_cloud(tmp_path):
    from rerun.chunk import RrdReader

    file, out, saved, port = write_rig(tmp_path), tmp_path / "out", tmp_path / "saved.rrd", free_port()
    command = [str(Path(rerun.__file__).parents[1] / "rerun_cli" / "rerun"), "--port", str(port)]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    with subprocess.Popen([*command, "--bind", "127.0.0.1", "--save", str(saved)], **options) as viewer:
        try:
            run_rig(file, out, "--live", f"rerun:{port}")
            wanted = [digest(deserialize(data, "sensor_msgs/msg/PointCloud2")) for data in recorded(out, "/points")]
            end = time.monotonic() + 120
            while len(found := saved_clouds(RrdReader, saved)) < len(wanted) and time.monotonic() < end:
                time.sleep(0.1)
        finally:
            os.killpg(viewer.pid, signal.SIGKILL)
    assert len(wanted) >= CLOUDS
    assert found == wanted


def digest(message):
    found = points(message)
    assert len(found) == POINTS
    return hashlib.sha256(found.tobytes()).hexdigest()


def saved_clouds(reader, path):
    """The digests of the points in a file of Rerun, in the order of simulation time."""
    clouds = []
    for chunk in reader(str(path)).stream().to_chunks() if path.exists() else ():
        batch = chunk.to_record_batch()
        if chunk.entity_path == "/points" and "Points3D:positions" in batch.schema.names:
            times = batch.column("sim_time").to_pylist()
            for when, row in zip(times, batch.column("Points3D:positions"), strict=True):
                values = row.values.flatten().to_numpy(zero_copy_only=False).astype(np.float32)
                clouds.append((when, hashlib.sha256(values.tobytes()).hexdigest()))
    return [digest for _, digest in sorted(clouds)]


def test_without_a_viewer_the_run_is_as_it_is_and_says_so(tmp_path):
    report = run_rig(write_rig(tmp_path), tmp_path / "out", "--live", f"rerun:{free_port()}")
    assert report["updates"] == 192
    assert "live-no-viewer" in {warning["code"] for warning in report["warnings"]}


@pytest.fixture
def silent():
    """The port of a viewer that accepts connections and never reads: the system accepts them, no program does."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(8)
        yield listener.getsockname()[1]


def test_a_viewer_that_accepts_and_says_nothing_does_not_hold_the_process(tmp_path, silent):
    report = run_rig(write_rig(tmp_path), tmp_path / "out", "--live", f"rerun:{silent}")
    assert report["updates"] == 192
    assert len(recorded(tmp_path / "out", "/points")) == 32


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGSTOP")
def test_a_viewer_that_stops_at_the_end_does_not_hold_the_process(tmp_path):
    """A real one, stopped as a debugger stops it once the first points have come; its last window stays full."""
    out, saved, port = tmp_path / "out", tmp_path / "saved.rrd", free_port()
    command = [str(Path(rerun.__file__).parents[1] / "rerun_cli" / "rerun"), "--port", str(port)]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    with subprocess.Popen([*command, "--bind", "127.0.0.1", "--save", str(saved)], **options) as viewer:
        try:
            stopper = threading.Thread(target=lambda: (grown(saved, 1_000_000), os.killpg(viewer.pid, signal.SIGSTOP)))
            stopper.start()
            report = run_rig(write_rig(tmp_path), out, "--live", f"rerun:{port}")
            stopper.join()
        finally:
            os.killpg(viewer.pid, signal.SIGKILL)
    assert report["updates"] == 192
    assert len(recorded(out, "/points")) == 32


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_a_run_whose_viewer_says_nothing(tmp_path, silent, number):
    out = tmp_path / "out"
    options = ["--realtime", "--duration", "3600", "--out", str(out), "--live", f"rerun:{silent}"]
    arguments = ("-m", "graph", "run", str(write_rig(tmp_path)), *options)
    with started(*arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        grown(out / "run.mcap", 5_000_000)
        process.send_signal(number)
        _, error = process.communicate(timeout=300)
    assert process.returncode == 130, error
    report = json.loads((out / "report.json").read_text())
    assert len(recorded(out, "/points")) == report["topics"]["/points"]["messages"] > 0


def grown(file, size):
    """Waits until a file has this size [bytes]."""
    end = time.monotonic() + 120
    while not (file.exists() and file.stat().st_size > size) and time.monotonic() < end:
        time.sleep(0.05)
