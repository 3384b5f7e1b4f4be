"""Recordings in other formats, read back by the readers of these formats or by their definition."""

import csv
import json
import math

import numpy as np
import pytest
from PIL import Image

from graph.base.errors import UserError
from graph.cli.main import main
from graph.recording.contents.file_names import file_names
from graph.recording.contents.poses import TransformLog
from graph.recording.exporting import export
from graph.recording.mcap_sink import McapSink
from graph.recording.run_reader import open_run
from graph.sim.libraries import import_open3d
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain
from nodes.isaac.transform_trees import FrameTransform
from nodes.ros2.messages import transforms
from nodes.ros2.point_clouds import point_cloud
from tests.support.without_wing import needs_wing

CLOUD, TF, IMAGE = "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/Image"
STRING, INFO, SCAN = "std_msgs/msg/String", "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/LaserScan"
SECOND = 10**9
POINTS = np.array([[1, 0, 0], [0, 2, 0], [0, 0, 3]], np.float32)
HALF = math.sqrt(0.5)


def header(ns, frame):
    return {"stamp": {"sec": ns // SECOND, "nanosec": ns % SECOND}, "frame_id": frame}


def cloud(ns):
    """Three points, of which the first was measured 0.1 s before the stamp, the others at it."""
    values = {
        "Intensity": np.array([0.25, 0.5, 1.0], np.float32),
        "Ring": np.array([0, 1, 2]),
        "Time": np.array([-SECOND // 10, 0, 0]),
        "ClassId": np.array([7, 7, 9], np.uint32),
        "ObjectId": np.array([[1, 0, 0, 0], [1, 0, 0, 0], [5, 0, 0, 1]], np.uint32),
    }
    return point_cloud(POINTS, values, ns, "lidar")


def picture(ns):
    data = np.arange(2 * 3 * 3, dtype=np.uint8)
    return from_plain(
        IMAGE,
        {"header": header(ns, "camera"), "height": 2, "width": 3, "encoding": "rgb8", "step": 9, "data": data.tolist()},
    )


@pytest.fixture
def run(tmp_path):
    """A lidar 1 m above a base that drives along x at 1 m/s and looks to the left (+90 degrees about z), for 0.3 s."""
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap", {"file": "drive.yaml"}))
    turned = (0.0, 0.0, HALF, HALF)
    static = [
        FrameTransform("base", "lidar", (0, 0, 1), (0, 0, 0, 1)),
        FrameTransform("base", "camera", (0.5, 0, 1), (-0.5, 0.5, -0.5, 0.5)),
    ]
    bus.publish("/tf_static", TF, transforms(static, 0), 0)
    for step in range(31):
        at = step * SECOND // 100
        bus.publish("/tf", TF, transforms([FrameTransform("world", "base", (step / 100, 0, 0), turned)], at), at)
        if step in (10, 20, 30):
            bus.publish("/points", CLOUD, cloud(at), at)
            classes = {"7": {"class": "car"}, "9": {"class": "tree"}}
            bus.publish("/points_labels", STRING, from_plain(STRING, {"data": json.dumps(classes)}), at)
            ids = {"id_to_labels": {"1": "/World/Car", str(5 + (1 << 96)): "/World/Tree"}}
            bus.publish("/object_id_map", STRING, from_plain(STRING, {"data": json.dumps(ids)}), at)
            bus.publish("/rgb", IMAGE, picture(at + 1000), at + 1000)
            k = [100, 0, 1.5, 0, 100, 1, 0, 0, 1]
            p = [100, 0, 1.5, 0, 0, 100, 1, 0, 0, 0, 1, 0]
            info = {"header": header(at, "camera"), "k": k, "p": p, "height": 2, "width": 3}
            bus.publish("/camera_info", INFO, from_plain(INFO, info), at)
    bus.close()
    with open_run(tmp_path / "run.mcap") as reader:
        yield reader


WORLD = np.array([[0.1, 1, 1], [-1.8, 0, 1], [0.2, 0, 4]])
"""The points of the second cloud in the world: the base is at x = 0.2 (for the first point 0.1), x ahead is world y."""


def test_a_pcd_file_has_every_field_and_the_pose_as_its_viewpoint(run, tmp_path):
    export(run, "pcd", tmp_path / "out", ["/points"])
    data = (tmp_path / "out/points/000001.pcd").read_bytes()
    head, _, body = data.partition(b"DATA binary\n")
    lines = dict(line.split(" ", 1) for line in head.decode().splitlines()[1:])
    assert lines["FIELDS"].split()[:4] == ["x", "y", "z", "intensity"]
    assert (lines["WIDTH"], lines["HEIGHT"], lines["POINTS"]) == ("3", "1", "3")
    viewpoint = np.array(lines["VIEWPOINT"].split(), float)  # tx ty tz qw qx qy qz
    np.testing.assert_allclose(viewpoint, [0.2, 0, 1, HALF, 0, 0, HALF], atol=1e-12)
    sizes, types = lines["SIZE"].split(), lines["TYPE"].split()
    dtype = [(n, f"<{t.lower()}{s}") for n, t, s in zip(lines["FIELDS"].split(), types, sizes, strict=True)]
    found = np.frombuffer(body, dtype)
    np.testing.assert_array_equal(found["y"], [0, 2, 0])
    np.testing.assert_array_equal(found["ring"], [0, 1, 2])
    np.testing.assert_array_equal(found["class_id"], [7, 7, 9])


def test_open3d_reads_pcd_and_ply_alike(run, tmp_path):
    open3d = import_open3d()
    export(run, "pcd", tmp_path / "pcd", ["/points"])
    export(run, "ply", tmp_path / "ply", ["/points"])
    for path in ("pcd/points/000000.pcd", "ply/points/000000.ply"):
        found = open3d.t.io.read_point_cloud(str(tmp_path / path))
        np.testing.assert_array_equal(found.point.positions.numpy(), POINTS)
        np.testing.assert_allclose(found.point["intensity"].numpy().ravel(), [0.25, 0.5, 1.0])


def test_the_index_has_stamp_and_pose_of_every_scan(run, tmp_path):
    lines = export(run, "ply", tmp_path / "out", ["points"])
    assert lines == [f"wrote 3 scans of /points into {tmp_path}/out/points, with the poses in scans.csv"]
    with (tmp_path / "out/points/scans.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["file"], row["stamp_ns"], row["points"]) for row in rows] == [
        ("000000.ply", "100000000", "3"), ("000001.ply", "200000000", "3"), ("000002.ply", "300000000", "3"),
    ]  # fmt: skip
    pose = [float(rows[1][name]) for name in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    np.testing.assert_allclose(pose, [0.2, 0, 1, 0, 0, HALF, HALF], atol=1e-12)


def test_points_go_to_the_world_by_the_pose_of_their_own_time(run, tmp_path):
    export(run, "npz", tmp_path / "out", ["/points"])
    found = np.load(tmp_path / "out/points/000001.npz")
    np.testing.assert_allclose(found["world"], WORLD, atol=1e-7)
    # The field time is float32: 0.1 s to some nanoseconds.
    np.testing.assert_allclose(found["time_ns"], [SECOND // 10, SECOND // 5, SECOND // 5], rtol=0, atol=5)
    np.testing.assert_allclose(found["pose_at"][:, :3], [[0.1, 0, 1], [0.2, 0, 1], [0.2, 0, 1]], atol=1e-9)
    assert int(found["stamp_ns"]) == 200_000_000
    export(run, "pcd", tmp_path / "pcd", ["/points"], world=True)
    body = (tmp_path / "pcd/points/000001.pcd").read_bytes().partition(b"DATA binary\n")[2]
    np.testing.assert_allclose(np.frombuffer(body[:24], "<f8"), WORLD[0], atol=1e-7)


def test_las_holds_times_classes_and_extra_dimensions(run, tmp_path):
    laspy = pytest.importorskip("laspy")
    export(run, "las", tmp_path / "out", ["/points"])
    las = laspy.read(tmp_path / "out/points/000001.las")
    np.testing.assert_allclose(las.xyz, POINTS, atol=1e-5)
    np.testing.assert_allclose(las.gps_time, [0.1, 0.2, 0.2], atol=1e-9)
    assert las.classification.tolist() == [7, 7, 9]
    assert las.intensity.tolist() == [16384, 32768, 65535]  # of 65535
    assert las["ring"].tolist() == [0, 1, 2]
    before = (tmp_path / "out/points/000001.las").read_bytes()
    export(run, "las", tmp_path / "again", ["/points"])
    assert (tmp_path / "again/points/000001.las").read_bytes() == before


def test_las_without_its_library_is_one_line(run, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "laspy", None)
    with pytest.raises(UserError, match=r"--format las needs laspy\. Run: .*pip install"):
        export(run, "las", tmp_path / "out")


def test_kitti_has_scans_labels_times_poses_and_calibration(run, tmp_path):
    assert export(run, "kitti", tmp_path / "out") == [f"wrote /points into {tmp_path}/out (kitti)"]
    sequence = tmp_path / "out/sequences/00"
    scan = np.fromfile(sequence / "velodyne/000001.bin", "<f4").reshape(-1, 4)
    np.testing.assert_array_equal(scan, np.column_stack([POINTS, [0.25, 0.5, 1.0]]))
    labels = np.fromfile(sequence / "labels/000001.label", "<u4")
    assert (labels & 0xFFFF).tolist() == [7, 7, 9]
    assert (labels >> 16).tolist() == [1, 1, 2]
    names = json.loads((sequence / "labels.json").read_text())
    assert names["objects"] == {"1": "/World/Car", "2": "/World/Tree"}
    assert names["classes"] == {"7": {"class": "car"}, "9": {"class": "tree"}}
    assert np.loadtxt(sequence / "times.txt").tolist() == pytest.approx([0, 0.1, 0.2])
    calib = {key: np.array(row.split(), float) for key, row in
             (line.split(": ") for line in (sequence / "calib.txt").read_text().splitlines())}  # fmt: skip
    # The camera stands 0.5 m ahead of the lidar: a point 1.5 m ahead is 1 m deep.
    np.testing.assert_allclose(calib["Tr"].reshape(3, 4) @ [1.5, 0.25, 0, 1], [-0.25, 0, 1], atol=1e-9)
    np.testing.assert_allclose(calib["P0"], [100, 0, 1.5, 0, 0, 100, 1, 0, 0, 0, 1, 0])
    poses = np.loadtxt(tmp_path / "out/poses/00.txt").reshape(-1, 3, 4)
    np.testing.assert_allclose(poses[0], np.eye(4)[:3], atol=1e-9)
    # The base looks along world y and drives along world x: the camera moves to its right, which is its x.
    np.testing.assert_allclose(poses[2][:, 3], [0.2, 0, 0], atol=1e-9)


def test_nuscenes_tables_lead_from_sample_to_sample_and_to_the_world(run, tmp_path):
    assert export(run, "nuscenes", tmp_path / "out") == [f"wrote /points, /rgb into {tmp_path / 'out'} (nuscenes)"]
    folder = tmp_path / "out/v1.0-tickgraph"
    tables = {path.stem: json.loads(path.read_text()) for path in folder.iterdir()}
    by_token = {row["token"]: row for rows in tables.values() for row in rows}
    scene = tables["scene"][0]
    first = by_token[scene["first_sample_token"]]
    second, last = by_token[first["next"]], by_token[scene["last_sample_token"]]
    assert (first["prev"], last["next"], by_token[second["next"]]) == ("", "", last)
    assert [row["timestamp"] for row in tables["sample"]] == [100_000, 200_000, 300_000]
    lidar = [row for row in tables["sample_data"] if row["fileformat"] == "pcd"]
    points = np.fromfile(tmp_path / "out" / lidar[1]["filename"], "<f4").reshape(-1, 5)
    np.testing.assert_array_equal(points, np.column_stack([POINTS, [0.25, 0.5, 1.0], [0, 1, 2]]))
    calibrated = by_token[lidar[1]["calibrated_sensor_token"]]
    assert calibrated["translation"] == pytest.approx([0, 0, 1])
    assert by_token[calibrated["sensor_token"]]["channel"] == "LIDAR_TOP"
    # Of one row sample_data and ego_pose share the token, as in the original.
    (ego,) = (row for row in tables["ego_pose"] if row["token"] == lidar[1]["ego_pose_token"])
    assert ego["translation"] == pytest.approx([0.2, 0, 0])
    assert ego["rotation"] == pytest.approx([HALF, 0, 0, HALF])
    camera = [row for row in tables["sample_data"] if row["fileformat"] == "png"]
    assert [row["sample_token"] for row in camera] == [row["sample_token"] for row in lidar]
    assert (camera[0]["width"], camera[0]["height"]) == (3, 2)
    matrix = by_token[camera[0]["calibrated_sensor_token"]]["camera_intrinsic"]
    assert matrix == [[100, 0, 1.5], [0, 100, 1], [0, 0, 1]]
    labels = np.fromfile(tmp_path / "out" / tables["lidarseg"][1]["filename"], np.uint8)
    assert labels.tolist() == [7, 7, 9]
    assert {row["index"]: row["name"] for row in tables["category"]} == {7: "car", 9: "tree"}


def test_nuscenes_names_the_pictures_that_it_does_not_hold(tmp_path):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    frames = [FrameTransform("world", frame, (0, 0, 1), (0, 0, 0, 1)) for frame in ("lidar", "camera")]
    bus.publish("/tf_static", TF, transforms(frames, 0), 0)
    bus.publish("/points", CLOUD, cloud(0), 0)
    depth = {"header": header(0, "camera"), "height": 1, "width": 1, "encoding": "32FC1", "step": 4, "data": [0] * 4}
    bus.publish("/depth", IMAGE, from_plain(IMAGE, depth), 0)
    bus.close()
    with open_run(tmp_path / "run.mcap") as recording:
        left_out, wrote = export(recording, "nuscenes", tmp_path / "out")
    assert left_out == "/depth: left out: nuscenes holds pictures of rgb8, bgr8, mono8, not 32FC1"
    assert wrote == f"wrote /points into {tmp_path / 'out'} (nuscenes)"


def test_a_data_set_leaves_out_images_that_contradict_themselves(tmp_path):
    """A recording may be damaged: a wrong width leaves that picture out, and its topic if there is no other."""
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "damaged.mcap"))
    frames = [FrameTransform("world", frame, (0, 0, 1), (0, 0, 0, 1)) for frame in ("lidar", "camera")]
    bus.publish("/tf_static", TF, transforms(frames, 0), 0)
    info = {"header": header(0, "camera"), "k": [9, 0, 1, 0, 9, 1, 0, 0, 1], "height": 2, "width": 3}
    bus.publish("/camera_info", INFO, from_plain(INFO, info), 0)
    for at, widths in ((0, (3, 9)), (SECOND, (2**32 - 1, 9))):
        bus.publish("/points", CLOUD, cloud(at), at)
        for topic, width in zip(("/one", "/none"), widths, strict=True):
            image = picture(at)
            image.width = width
            bus.publish(topic, IMAGE, image, at)
    bus.close()
    with open_run(tmp_path / "damaged.mcap") as recording:
        *notes, wrote = export(recording, "nuscenes", tmp_path / "out")
    assert notes == [
        "/one: images are left out: 18 bytes are too few for 4294967295 x 2 pixels",
        "/none: images are left out: 18 bytes are too few for 9 x 2 pixels",
    ]
    assert wrote == f"wrote /points, /one into {tmp_path / 'out'} (nuscenes)"
    tables = {path.stem: json.loads(path.read_text()) for path in (tmp_path / "out/v1.0-tickgraph").iterdir()}
    assert [row["channel"] for row in tables["sensor"]] == ["LIDAR_TOP", "CAM_FRONT"]
    assert len([row for row in tables["sample_data"] if row["fileformat"] == "png"]) == 1


def test_pictures_keep_their_pixels_and_depth_is_in_millimetres(tmp_path):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    depth = np.array([[1.0, np.inf], [0.0015, 70.0]], "<f4")
    fields = {"height": 2, "width": 2, "encoding": "32FC1", "step": 8, "data": [*depth.tobytes()]}
    bus.publish("/depth", IMAGE, from_plain(IMAGE, {"header": header(5, "c"), **fields}), 5)
    bus.publish("/rgb", IMAGE, picture(5), 5)
    bus.close()
    with open_run(tmp_path / "run.mcap") as run:
        export(run, "png", tmp_path / "out")
    assert np.array(Image.open(tmp_path / "out/depth/000000.png")).tolist() == [[1000, 0], [2, 0]]
    found = np.array(Image.open(tmp_path / "out/rgb/000000.png"))
    np.testing.assert_array_equal(found, np.arange(18).reshape(2, 3, 3))


def test_tables_have_a_row_for_each_message_and_each_transform(run, tmp_path):
    export(run, "csv", tmp_path / "out", ["/tf", "/camera_info"])
    with (tmp_path / "out/tf.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 31
    assert (rows[10]["stamp_ns"], rows[10]["parent"], rows[10]["child"], rows[10]["x"]) == (
        "100000000", "world", "base", "0.1",
    )  # fmt: skip
    with (tmp_path / "out/camera_info.csv").open() as file:
        row = next(csv.DictReader(file))
    assert json.loads(row["k"])[:3] == [100, 0, 1.5]
    assert row["header:frame_id"] == "camera"


def test_a_laser_scan_is_points_in_its_plane(tmp_path):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    scan = {
        "header": header(SECOND, "laser"), "angle_min": 0.0, "angle_increment": math.pi / 2, "time_increment": 0.01,
        "range_min": 0.1, "range_max": 10.0, "ranges": [1.0, math.inf, 3.0], "intensities": [4.0, 5.0, 6.0],
    }  # fmt: skip
    bus.publish("/scan", SCAN, from_plain(SCAN, scan), SECOND)
    bus.close()
    with open_run(tmp_path / "run.mcap") as run:
        export(run, "npz", tmp_path / "out")
    found = np.load(tmp_path / "out/scan/000000.npz")
    np.testing.assert_allclose(found["x"], [1, -3], atol=1e-6)
    assert found["intensity"].tolist() == [4, 6]
    assert found["time_ns"].tolist() == [SECOND, SECOND + 20_000_000]


@pytest.mark.parametrize("command", [["export", "--format", "csv"], pytest.param(["view"], marks=needs_wing("view"))])
def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_read(run, tmp_path, capsys, command):
    taken = tmp_path / "taken"
    taken.write_text("mine")
    assert main([*command, str(tmp_path / "run.mcap"), "--out", str(taken)]) == 2
    assert (
        capsys.readouterr().err == f"graph: --out {taken}: {taken} is not a folder that can be written; name another\n"
    )
    assert taken.read_text() == "mine"


def test_without_transforms_scans_have_no_pose_and_world_is_refused(tmp_path, capsys):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    bus.publish("/points", CLOUD, cloud(SECOND), SECOND)
    bus.close()
    file, out = str(tmp_path / "run.mcap"), str(tmp_path / "out")
    assert main(["export", file, "--format", "pcd", "--out", out]) == 0
    assert "/points: 1 scan without a pose: no transform of its frame" in capsys.readouterr().out
    assert main(["export", file, "--format", "pcd", "--out", out, "--world"]) == 1
    assert "no transforms of frame 'lidar'" in capsys.readouterr().err
    assert main(["export", file, "--format", "nuscenes", "--out", out]) == 1
    assert "needs the pose of frame 'lidar'" in capsys.readouterr().err
    assert main(["export", file, "--format", "kitti", "--out", out]) == 0
    assert "there is no poses/00.txt" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--format", "pcd", "--topic", "/nix"], "--topic /nix: the recording has no such topic; it has /tf_static"),
        (["--format", "pcd", "--topic", "/tf"], "--format pcd fits no topic of the recording: /tf (tf2_msgs/msg/TF"),
        (["--format", "doc"], "invalid choice: 'doc'"),
    ],
)
def test_what_cannot_be_exported_is_one_line(run, tmp_path, capsys, options, said):
    assert main(["export", run.name, "--out", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


def test_a_cloud_that_contradicts_itself_is_one_line(tmp_path, capsys):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    message = cloud(SECOND)
    message.width = 1000
    bus.publish("/points", CLOUD, message, SECOND)
    bus.close()
    assert main(["export", str(tmp_path / "run.mcap"), "--format", "ply", "--out", str(tmp_path / "out")]) == 1
    assert "/points at 1.000000000 s: 126 bytes of data are too few for 1 x 1000 points" in capsys.readouterr().err


def test_frames_that_hang_on_each_other_end_and_are_no_endless_chain():
    log = TransformLog()
    log.add(transforms([FrameTransform("a", "b", (1, 0, 0), (0, 0, 0, 1))], 0), "/tf")
    log.add(transforms([FrameTransform("b", "a", (1, 0, 0), (0, 0, 0, 1))], 0), "/tf")
    assert log.chain("a") == ["a", "b"]
    assert log.poses("c", np.array([0])) is None


def test_a_frame_has_a_pose_in_every_frame_of_its_tree_and_in_no_other():
    # a stands at x = 1, turned by +90 degrees about z; b at x = 3 is 2 m to its right: y = -2.
    log = TransformLog()
    log.add(transforms([FrameTransform("w", "a", (1, 0, 0), (0, 0, HALF, HALF))], 0), "/tf")
    log.add(transforms([FrameTransform("w", "b", (3, 0, 0), (0, 0, 0, 1))], 0), "/tf")
    log.add(transforms([FrameTransform("elsewhere", "c", (0, 0, 0), (0, 0, 0, 1))], 0), "/tf")
    at = np.array([0])
    np.testing.assert_allclose(log.poses("b", at, "a")[0, :3, 3], [0, -2, 0], atol=1e-12)
    np.testing.assert_array_equal(log.poses("w", at)[0], np.eye(4))
    assert log.poses("c", at, "a") is None


def test_turns_between_two_transforms_take_the_shorter_arc():
    log = TransformLog()
    log.add(transforms([FrameTransform("w", "f", (0, 0, 0), (0, 0, 0, 1))], 0), "/tf")
    log.add(transforms([FrameTransform("w", "f", (2, 0, 0), (0, 0, -HALF, -HALF))], SECOND), "/tf")
    pose = log.poses("f", np.array([SECOND // 2]))[0]
    angle = math.pi / 4
    np.testing.assert_allclose(pose[:2, :2], [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    np.testing.assert_allclose(pose[:3, 3], [1, 0, 0])
    assert log.poses("f", np.array([2 * SECOND])) is None


@pytest.mark.parametrize(
    ("place", "turn"),
    [((math.nan, 0, 0), (0, 0, 0, 1)), ((0, -math.inf, 0), (0, 0, 0, 1)), ((0, 0, 1e300), (0, 0, 0, 1)),
     ((5, 0, 0), (0, 0, 0, 0)), ((5, 0, 0), (0, math.nan, 0, 1))],
)  # fmt: skip
def test_a_transform_that_is_not_finite_is_left_out(place, turn):
    """As tf2 does; the pose between the transforms on its sides is right."""
    log = TransformLog()
    for step, (at, rotation) in enumerate([((0, 0, 0), (0, 0, 0, 1)), (place, turn), ((2, 0, 0), (0, 0, 0, 1))]):
        log.add(transforms([FrameTransform("world", "f", at, rotation)], step * SECOND), "/tf")
    np.testing.assert_allclose(log.poses("f", np.array([SECOND]))[0][:3, 3], [1, 0, 0], atol=1e-9)


def test_an_image_without_pixels_and_a_step_beyond_memory_are_one_line(tmp_path, capsys):
    bus = MessageBus()
    bus.subscribe(McapSink(tmp_path / "run.mcap"))
    bus.publish("/rgb", IMAGE, from_plain(IMAGE, {"header": header(0, "c"), "encoding": "rgb8"}), 0)
    message = point_cloud(np.zeros((0, 3), np.float32), {}, 0, "lidar")
    message.point_step = 2**32 - 1
    bus.publish("/points", CLOUD, message, 0)
    bus.close()
    for form, said in (("png", "/rgb: the image has no pixels"), ("pcd", "/points at 0.000000000 s: ")):
        file = str(tmp_path / "run.mcap")
        assert main(["export", file, "--format", form, "--out", str(tmp_path / "out")]) == 1
        error = capsys.readouterr().err
        assert said in error
        assert len(error.splitlines()) == 1


def test_topics_that_would_share_a_file_get_names_of_their_own():
    assert file_names(["/a/b", "/a_b", "/A_b", "/front/points", "/a/b"]) == {
        "/a/b": "a_b",
        "/a_b": "a_b_2",
        "/A_b": "A_b_3",
        "/front/points": "front_points",
    }


def test_names_of_files_are_short_and_all_different_with_their_endings():
    names = file_names(["/a", "/a.csv", "/A", "/" + "x" * 300, "/" + "x" * 301, "/../..", "/a_2", "/\n"])
    assert list(names.values())[:3] == ["a", "a.csv_2", "A_2"]
    used = [f"{name}{ending}".lower() for name in names.values() for ending in ("", ".csv")]
    assert len(set(used)) == len(used)
    assert max(map(len, names.values())) <= 110
    assert all("/" not in name and name not in (".", "..") for name in names.values())
