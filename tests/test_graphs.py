"""The examples cannot rot: each file in graphs/ loads, checks and runs, and the yard is what its script writes."""

import contextlib
import io
import json
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from graph.cli.main import main
from tests.support.places import ROOT
from tests.support.without_wing import MISSING_EXAMPLES, needs_wing

FILES = sorted(
    path
    for path in (ROOT / "graphs").glob("*.yaml")
    if not path.name.endswith(".test.yaml") and path.stem != "worlds"  # it has no graph: `Worlds` drives it
    if path.stem not in MISSING_EXAMPLES
)
YARD = ROOT / "graphs" / "yard.yaml"
TOP = "/World/Robot/Chassis/top_lidar"
FRONT = "/World/Robot/Chassis/front_lidar"


def graph(*arguments):
    """Exit code, output and errors of the command, in this process: the libraries are loaded once for all examples."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([*map(str, arguments)])
    return SimpleNamespace(code=code, out=out.getvalue(), err=err.getvalue())


def test_there_are_examples():
    assert {path.name for path in FILES} >= {"quickstart.yaml", "yard.yaml"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_an_example_checks_without_a_word_of_complaint(path):
    done = graph("check", path)
    assert (done.code, done.err) == (0, "")


EXTENT = {"arm": (150, 0.6), "zero_delay": (30, 0.5), "radar_gate": (122, 122 / 240)}
"""(physics steps, seconds) of 30 updates. The arm: 250 Hz by its model, a loop of 50 Hz; zero delay: one step an
update; the product: 2 steps more."""


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_an_example_runs_and_everything_it_wires_speaks(path, tmp_path):
    done = graph("run", path, "--updates", 30, "--strict", "--json", "--out", tmp_path)
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["updates"] == 30
    steps, seconds = EXTENT.get(path.stem, (120, 0.5))
    assert report["physics_steps"] == steps
    assert report["simulation_time"] == report["external_time"] == seconds
    assert all(sensor["frames"] and sensor["elements"] for sensor in report["sensors"].values())
    assert all(node["computes"] for name, node in report["nodes"].items() if name.endswith("tick"))
    assert (tmp_path / "run.mcap").stat().st_size > 2_000
    assert json.loads((tmp_path / "report.json").read_text()) == report


def test_without_delay_pictures_and_transforms_of_an_update_carry_one_stamp(tmp_path):
    assert graph("run", ROOT / "graphs" / "zero_delay.yaml", "--updates", 5, "--out", tmp_path).code == 0
    stamps: dict[str, list[int]] = {}
    with AnyReader([tmp_path / "run.mcap"], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, _, data in reader.messages():
            message: Any = reader.deserialize(data, connection.msgtype)
            stamp = (message.transforms[0] if connection.topic == "/tf" else message).header.stamp
            stamps.setdefault(connection.topic, []).append(stamp.sec * 10**9 + stamp.nanosec)
    exact = [round(10**9 * (k + 1) / 60) for k in range(5)]  # update k ends at (k + 1) / 60 s
    assert stamps == dict.fromkeys(("/tf", "/depth", "/camera_info"), exact)


@needs_wing("acoustic")
def test_the_script_of_the_acoustic_sensor_prints_the_echoes_of_each_way():
    """A post 1.5 m ahead of mount 0 hides the wall from it. The other way is that of a wall at sqrt(3^2 + 0.25^2) m."""
    done = subprocess.run(
        [sys.executable, ROOT / "graphs" / "acoustic.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    lines = dict(line.split(": ", 1) for line in done.stdout.splitlines())
    assert lines["mount 0 to 0"].startswith("1.50 m")
    assert "3.01 m" in lines["mount 0 to 1"]


def test_the_script_of_annotators_prints_a_line_for_each_and_draws(tmp_path):
    done = subprocess.run(
        [sys.executable, ROOT / "graphs" / "annotators.py", tmp_path],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = dict(line.split(": ", 1) for line in done.stdout.splitlines())
    assert lines["StableIdMap"] == "they hit /World/Barrel, /World/Wall"
    assert lines["IsaacComputeRTXLidarFlatScan"] == "3600 columns, nearest 3.000 m"  # the barrel's side: 4 m less 1 m
    assert len(lines) == 7
    assert done.stderr.count("annotator-deprecated") == 3
    assert [file.name for file in tmp_path.iterdir()] == ["World_Lidar_000000.png"]


def test_the_script_of_structured_light_finds_the_depth_of_the_crate_and_of_the_wall():
    """A column of 256 is 500 / 256 = 1.95 px: at 3 m, of a disparity of 33 px, half of it is 9 cm; the median less."""
    pytest.importorskip("OpenEXR", reason="comes with the extra exr")
    script = ROOT / "graphs" / "structured_light.py"
    done = subprocess.run([sys.executable, script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = {line.split()[0]: float(line.split()[1]) for line in done.stdout.splitlines()}
    assert found == {"crate:": pytest.approx(1.5, abs=0.03), "wall:": pytest.approx(3.0, abs=0.05)}


def test_the_motion_modes_show_a_passing_ball_as_their_comments_say():
    """It crosses at 10 m/s: its width along y is 1 m, in a turn of 0.1 s it moves 1 m more."""
    import numpy as np

    import sensors.replicator as rep
    from graph.sim import App
    from sensors import parse_object_ids

    width = {}
    for mode in ("frozen", "update", "continuous"):
        with App.from_file(ROOT / "graphs" / f"lidar_motion_{mode}.yaml") as app:
            app.settings.set("/rtx-transient/stableIds/enabled", True)
            sensor = rep.create_render_product("/World/Cart/Lidar").sensor
            sensor.require("test", {"xyz", "objId"}, ignore_aux=True)
            app.play()
            app.update(30)
            frame = next(iter(app.rendering.products.values())).frame
            paths = sensor.object_ids()
            on_ball = [paths[number] == "/World/Ball" for number in parse_object_ids(frame.channel("objId"))]
            width[mode] = float(np.ptp(frame.xyz[on_ball, 1]))
    assert width["frozen"] == pytest.approx(0.97, abs=0.03)  # seen from 3 m: sqrt(1 - (0.5 / 3)^2) of 1 m
    # The beam starts straight ahead and turns clockwise: it meets the ball's right side as the turn begins and its left
    # side as the turn ends, when the ball is almost 1 m further on.
    assert 1.6 < width["update"] < 2.0
    assert 1.6 < width["continuous"] < 2.0


def test_the_quickstart_gives_the_fifty_scans_that_its_comments_promise():
    done = graph("run", ROOT / "graphs" / "quickstart.yaml", "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["updates"] == 300
    lidar = report["sensors"]["/World/Lidar"]
    assert (lidar["frames"], lidar["first_frame_ns"], lidar["last_frame_ns"]) == (50, 0, 4_900_000_000)


def test_the_yards_recording_is_the_same_to_the_byte_whatever_the_number_of_ray_threads(tmp_path):
    for threads in (1, 2):
        out = tmp_path / str(threads)
        done = graph("run", YARD, "--updates", 20, "--out", out, f"--/tickgraph/rayThreads={threads}")
        assert done.code == 0, done.err
    first, second = ((tmp_path / name / "run.mcap").read_bytes() for name in ("1", "2"))
    assert first == second
    assert len(first) > 1_000_000


@pytest.fixture(scope="module")
def yard_run(tmp_path_factory):
    """The main example as `make run` runs it, once for all tests below."""
    out = tmp_path_factory.mktemp("yard")
    done = graph("run", YARD, "--out", out, "--json", "--strict")
    assert done.code == 0, done.err
    return json.loads(done.out), out


def test_the_yards_sensors_deliver_what_their_schedules_say(yard_run):
    report, _ = yard_run
    assert report["updates"] == 300
    assert report["physics_steps"] == 1200
    assert {warning["code"] for warning in report["warnings"]} == set()
    top, front = report["sensors"][TOP], report["sensors"][FRONT]
    assert (top["tick_rate"], top["frames"], top["first_frame_ns"], top["last_frame_ns"]) == (10, 50, 0, 4_900_000_000)
    # Countdown 5 finishes in update 5, so the product exists from 5/60 s; the first whole scan starts at 0.1 s.
    assert (front["tick_rate"], front["frames"]) == (20, 98)
    assert (front["first_frame_ns"], front["last_frame_ns"]) == (100_000_000, 4_950_000_000)


def test_the_yards_recording_opens_and_its_clouds_decode(yard_run):
    import numpy as np
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    _, out = yard_run
    recording = out / "run.mcap"
    assert recording.stat().st_size < 100_000_000
    counts, rings = {}, set()
    with AnyReader([recording], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, _, raw in reader.messages():
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
            if connection.topic == "/top/points":
                cloud = reader.deserialize(raw, connection.msgtype)
                names = [field.name for field in cloud.fields]
                kinds = {"x": "<f4", "y": "<f4", "z": "<f4", "intensity": "<f4", "ring": "<u2"}
                layout = np.dtype(
                    {
                        "names": names,
                        "formats": [kinds[name] for name in names],
                        "offsets": [field.offset for field in cloud.fields],
                        "itemsize": cloud.point_step,
                    }
                )
                points = np.frombuffer(cloud.data, layout)
                assert len(points) == cloud.width > 20_000
                rings.update(np.unique(points["ring"]).tolist())
    assert len(rings) == 32
    assert counts["/top/points"] == 50
    assert counts["/front/points"] == counts["/front/scan"] == counts["/front/extracted"] == 98
    assert counts["/clock"] == counts["/tf"] == 300
    assert counts["/radar/points"] == counts["/camera/rgb"] == counts["/camera/camera_info"] == 50
    assert counts["/tf_static"] == 1


def test_the_yards_robot_drives_its_curve_upright_and_the_world_stays_calm():
    import numpy as np

    from graph.sim import App

    with App.from_file(YARD) as app:
        app.play()
        start = app.fabric.world_matrix("/World/Robot/Chassis")
        path = []
        for _ in range(30):
            app.update(steps=10)
            path.append(app.fabric.world_matrix("/World/Robot/Chassis"))
        heights = app.physics.positions[:, 2].copy()
        positions = app.physics.positions.copy()
    moved = path[-1][:2, 3] - start[:2, 3]
    assert 5.0 < np.linalg.norm(moved) < 6.1  # 1.2 m/s for 5 s, along a curve
    assert min(pose[2, 2] for pose in path) > 0.995  # upright within 6 degrees
    assert all(abs(pose[2, 3] - 0.15) < 0.02 for pose in path)
    turned = [float(np.arctan2(pose[1, 0], pose[0, 0])) for pose in path]
    assert min(turned) < np.radians(-5) < np.radians(5) < max(turned)  # it swings to both sides
    assert heights.min() > -0.05  # nothing fell through the ground
    assert np.abs(positions).max() < 40.0  # nothing was flung out


def test_the_yard_is_what_its_script_writes(tmp_path):
    from pxr import Sdf

    scenes = ROOT / "graphs" / "scenes"
    done = subprocess.run(
        [sys.executable, scenes / "make_yard.py", tmp_path], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for name in ("yard.usda", "yard_static.usdc"):
        fresh, kept = (Sdf.Layer.OpenAsAnonymous(str(folder / name)) for folder in (tmp_path, scenes))
        assert fresh.ExportToString() == kept.ExportToString(), f"run graphs/scenes/make_yard.py and commit {name}"
