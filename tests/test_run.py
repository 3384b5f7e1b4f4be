"""The command as a user runs it: whole runs of graph files, what they record, and what bad input gets."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from graph.cli.interrupts import between_updates
from graph.cli.main import main
from tests.support.programs import started

TYPES = get_typestore(Stores.ROS2_HUMBLE)

SMALL = """
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Ball: {type: Sphere, radius: 0.25, translate: [3, 0, 2], rigid_body: true, mass: 1.0}
    /World/Lidar: {type: OmniLidar, config: RPLIDAR_S2E, translate: [0, 0, 0.5], rotate: [0, 10, 0]}
clock: {physics_hz: 240, loop_hz: 60}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points}}
    connections:
      - tick.tick -> [clock.execIn, product.execIn]
      - time.simulationTime -> clock.timeStamp
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


@pytest.fixture
def small(tmp_path):
    """A small graph file in a folder of its own."""
    file = tmp_path / "small.yaml"
    file.write_text(SMALL)
    return file


def messages(recording: Path, topic: str) -> list:
    """All messages of a topic, decoded, in order."""
    with AnyReader([recording], default_typestore=TYPES) as reader:
        wanted = [connection for connection in reader.connections if connection.topic == topic]
        return [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections=wanted)]


def test_two_runs_and_any_number_of_ray_threads_record_the_same_bytes(tmp_path, small):
    recordings = []
    for name, options in (
        ("a", []),
        ("b", []),
        ("one", ["--/tickgraph/rayThreads=1"]),
        ("two", ["--/tickgraph/rayThreads=2"]),
    ):
        assert main(["run", str(small), "--updates", "60", "--out", str(tmp_path / name), *options]) == 0
        recordings.append((tmp_path / name / "run.mcap").read_bytes())
    assert recordings[0] == recordings[1] == recordings[2] == recordings[3]


def test_the_report_names_updates_nodes_and_timing(tmp_path, small, capsys):
    assert main(["run", str(small), "--updates", "30", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["updates"] == 30
    assert report["physics_steps"] == 120
    assert report["nodes"]["/World/Graph/tick"] == {"computes": 30}
    assert set(report["timing_s"]) == {"physics", "render", "graph", "io", "compile"}
    assert report["topics"]["/clock"]["messages"] == 30


def test_a_sensor_counts_the_frames_of_all_its_render_products(tmp_path, small, capsys):
    twice = tmp_path / "twice.yaml"
    text = small.read_text().replace("    connections:", "      second: {type: IsaacCreateRenderProduct, inputs: "
                                     "{cameraPrim: /World/Lidar, width: 64}}\n    connections:", 1)  # fmt: skip
    twice.write_text(text.replace("product.execIn]", "product.execIn, second.execIn]"))
    counts = []
    for file in (small, twice):
        assert main(["run", str(file), "--updates", "30", "--json"]) == 0
        counts.append(json.loads(capsys.readouterr().out)["sensors"]["/World/Lidar"])

    assert (counts[0]["frames"], counts[1]["frames"]) == (5, 10)  # 10 Hz for 0.5 s
    for name in ("first_frame_ns", "last_frame_ns", "tick_rate"):
        assert counts[0][name] == counts[1][name]


def test_a_duration_is_rounded_up_to_whole_updates(small, capsys):
    # 0.51 s x 60 Hz = 30.6
    assert main(["run", str(small), "--duration", "0.51", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["updates"] == 31


def test_set_overrides_an_input(tmp_path, small):
    assert (
        main(["run", str(small), "--updates", "30", "--set", "cloud.topicName=other", "--out", str(tmp_path / "o")])
        == 0
    )
    assert "/other" in json.loads((tmp_path / "o" / "report.json").read_text())["topics"]


def test_strict_fails_a_run_in_which_a_wired_sensor_stayed_silent(small, capsys):
    # The first tick of a 10 Hz lidar comes with update 6.
    assert main(["run", str(small), "--updates", "5", "--strict"]) == 1
    error = capsys.readouterr().err
    assert "sensor /World/Lidar rendered no frame" in error
    assert "publisher /World/Graph/cloud sent no message" in error
    assert main(["run", str(small), "--updates", "6", "--strict"]) == 0


SILENCERS = {
    "a closed gate": (
        "tick.tick -> [clock.execIn, product.execIn]",
        "tick.tick -> [clock.execIn, gate.enter]\n      - gate.exit -> product.execIn",
    ),
    "a product without a trigger": ("[clock.execIn, product.execIn]", "clock.execIn"),
    "a helper without a trigger": ("      - product.execOut -> cloud.execIn\n", ""),
    "a disabled product": ("cameraPrim: /World/Lidar", "cameraPrim: /World/Lidar, enabled: false"),
}


@pytest.mark.parametrize("silencer", SILENCERS)
def test_strict_fails_a_run_whose_wired_parts_were_never_reached(silencer, small, capsys):
    text = SMALL.replace("      cloud:", "      gate: {type: Gate, inputs: {startClosed: true}}\n      cloud:")
    assert SILENCERS[silencer][0] in text
    small.write_text(text.replace(*SILENCERS[silencer]))
    assert main(["run", str(small), "--updates", "20", "--strict"]) == 1
    told = capsys.readouterr()
    assert "publisher /World/Graph/cloud sent no message" in told.err
    assert "silent: " in told.out
    assert "/World/Lidar" in told.out


BAD_EDITS = {
    "unknown node type": ("type: ROS2RtxLidarHelper", "type: ROS2RtxLidarHelpr", 'did you mean "ROS2RtxLidarHelper"'),
    "unknown attribute": ("topicName: points", "topicNam: points", 'did you mean "topicName"'),
    "unknown prim": ("cameraPrim: /World/Lidar", "cameraPrim: /World/Lydar", "there is no prim /World/Lydar"),
    "unknown config": ("config: RPLIDAR_S2E", "config: RPLIDAR_S3", "RPLIDAR_S2E"),
    "unknown prim key": ("radius: 0.25", "radios: 0.25", "radius"),
    "type mismatch": ("time.simulationTime -> clock.timeStamp", "tick.tick -> clock.timeStamp", "timeStamp"),
    "zero rate": ("loop_hz: 60", "loop_hz: 0", "loop_hz"),
    "negative rate": ("physics_hz: 240", "physics_hz: -1", "physics_hz"),
    "nan rate": ("physics_hz: 240", "physics_hz: .nan", "physics_hz"),
    "nan position": ("translate: [3, 0, 2]", "translate: [.nan, 0, 2]", "translate"),
    "missing scene": ("scene:\n", "scene:\n  usd: nowhere.usda\n", "nowhere.usda"),
    "path outside": ("scene:\n", "scene:\n  usd: ../../../etc/scene.usda\n", "outside"),
    "a graph where a prim is": ("  /World/Graph:", "  /World/Ball:", "/World/Ball is a Sphere"),
    "more rays than memory": (
        "rotate: [0, 10, 0]",
        'attributes: {"omni:sensor:Core:patternFiringRateHz": 4000000000}',
        "rays a scan",
    ),
    "negative tick rate": ("rotate: [0, 10, 0]", 'attributes: {"omni:sensor:tickRate": -1}', "tickRate is -1"),
    "rate no clock can keep": ("loop_hz: 60", "loop_hz: 1.0e-30", "loop_hz"),
    "recording over the report": ("tickgraph: 1", "tickgraph: 1\nrecord: {mcap: report.json}", "report.json"),
    "half a character": ("topicName: points", 'topicName: "\\ud800"', "surrogate"),
    "absurd speed": ("mass: 1.0", "mass: 1.0, velocity: [1.0e+200, 0, 0]", "faster"),
    "malformed": ("tickgraph: 1", "tickgraph: [1", "small.yaml:"),
}


@pytest.mark.parametrize("mistake", BAD_EDITS)
def test_a_users_mistake_is_reported_with_its_place_and_nothing_is_written(mistake, tmp_path, small, capsys):
    old, new, expected = BAD_EDITS[mistake]
    assert old in SMALL
    small.write_text(SMALL.replace(old, new, 1))
    assert main(["run", str(small), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert expected in error
    assert "Traceback" not in error
    assert f"{small}:" in error
    assert not (tmp_path / "out").exists()


def test_all_mistakes_of_a_file_are_reported_at_once(small, capsys):
    text = SMALL
    for mistake in ("unknown node type", "unknown config", "unknown prim key"):
        old, new, _ = BAD_EDITS[mistake]
        text = text.replace(old, new, 1)
    small.write_text(text)
    assert main(["check", str(small)]) == 2
    error = capsys.readouterr().err
    assert all(word in error for word in ("ROS2RtxLidarHelpr", "RPLIDAR_S3", "radios"))


def test_a_size_without_a_finite_mass_is_refused_before_anything_is_written(tmp_path, small, capsys):
    small.write_text(SMALL.replace("radius: 0.25", "radius: 1.0e+300").replace(", mass: 1.0", ""))
    assert main(["run", str(small), "--out", str(tmp_path / "out")]) == 2
    assert "/World/Ball" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_set_on_a_connected_input_is_refused(small, capsys):
    assert main(["run", str(small), "--set", "cloud.renderProductPath=/x"]) == 2
    assert "a connection feeds this input" in capsys.readouterr().err


def test_a_topic_that_ros_does_not_allow_is_found_before_anything_is_written(tmp_path, small, capsys):
    small.write_text(SMALL.replace("topicName: points", 'topicName: "a b!"'))
    assert main(["run", str(small), "--updates", "3", "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    line = next(n for n, text in enumerate(SMALL.splitlines(), 1) if "topicName: points" in text)
    assert f"{small}:{line}:" in error
    assert "cloud.inputs:topicName: '/a b!' is not a ROS 2 topic name" in error
    assert not (tmp_path / "out").exists()


def test_a_namespace_that_ros_does_not_allow_is_found_where_a_bad_topic_is(small, capsys):
    small.write_text(SMALL.replace("topicName: points", 'topicName: points, nodeNamespace: "1abc"'))
    line = next(n for n, text in enumerate(SMALL.splitlines(), 1) if "topicName: points" in text)
    for command in ("check", "explain", "run"):
        assert main([command, str(small)]) == 2
        error = capsys.readouterr().err
        assert f"{small}:{line}:" in error
        assert "cloud.inputs:nodeNamespace: '1abc' is not a ROS 2 namespace" in error


def test_an_invalid_path_gives_one_line_of_ours_and_no_line_of_usd(small, capfd):
    small.write_text(SMALL.replace("cameraPrim: /World/Lidar", 'cameraPrim: "/Wo-rld/a b"'))
    for command in ("check", "explain", "run"):
        assert main([command, str(small)]) == 2
        [line] = capfd.readouterr().err.splitlines()
        assert line.endswith(
            "inputs:cameraPrim: /Wo-rld/a b is not a path of a prim; write / and names of letters, digits and _"
        )


def test_a_camera_prim_that_is_not_a_sensor_is_found_before_anything_is_written(tmp_path, small, capsys):
    small.write_text(SMALL.replace("cameraPrim: /World/Lidar", "cameraPrim: /World/Ball"))
    assert main(["run", str(small), "--updates", "3", "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    line = next(n for n, text in enumerate(SMALL.splitlines(), 1) if "cameraPrim: /World/Lidar" in text)
    assert f"{small}:{line}:" in error
    assert "inputs:cameraPrim: /World/Ball: a Sphere is not a sensor; give the path of an OmniLidar" in error
    assert not (tmp_path / "out").exists()


def test_an_empty_scene_runs(tmp_path):
    file = tmp_path / "empty.yaml"
    file.write_text("tickgraph: 1\n")
    assert main(["run", str(file), "--updates", "3"]) == 0


def test_a_failing_node_ends_the_run_with_1_and_keeps_the_recording(tmp_path, small, capsys):
    # The helper is asked for a message it does not know once the first 0.5 s are recorded: Countdown 30 updates.
    text = SMALL.replace(
        "      cloud:",
        "      wait: {type: Countdown, inputs: {duration: 30}}\n"
        "      bad:\n"
        "        type: IsaacArticulationController\n"
        "        inputs: {targetPrim: /World/Ball, velocityCommand: [1.0, 2.0]}\n"
        "      cloud:",
    ).replace(
        "    connections:\n",
        "    connections:\n      - tick.tick -> wait.execIn\n      - wait.finished -> bad.execIn\n",
    )
    small.write_text(text)
    assert main(["run", str(small), "--out", str(tmp_path / "out")]) == 1
    error = capsys.readouterr().err
    assert "/World/Graph/bad" in error
    assert "Traceback" not in error
    assert len(messages(tmp_path / "out" / "run.mcap", "/clock")) == 30
    assert json.loads((tmp_path / "out" / "report.json").read_text())["updates"] == 30


def test_transforms_of_the_update_in_which_a_node_fails_are_recorded(tmp_path, capsys):
    file = tmp_path / "g.yaml"
    file.write_text("""
tickgraph: 1
scene: {prims: {/World/Ball: {type: Sphere}}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      tf: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/Ball]}}
      radius: {type: ConstantDouble, inputs: {value: .nan}}
      bad: {type: DifferentialController, inputs: {wheelDistance: 1.0}}
    connections:
      - tick.tick -> [tf.execIn, bad.execIn]
      - radius.value -> bad.wheelRadius
""")
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("graph:")]
    assert "wheelRadius is nan" in line
    (message,) = messages(tmp_path / "out" / "run.mcap", "/tf")
    assert message.transforms[0].child_frame_id == "Ball"


def test_a_diverging_simulation_ends_the_run_with_1_and_keeps_the_recording(tmp_path, small, capsys):
    text = SMALL.replace("mass: 1.0", "mass: 1.0, velocity: [1.0e+12, 0, 0]", 1)
    small.write_text(text)
    assert main(["run", str(small), "--out", str(tmp_path / "out"), "--updates", "60"]) == 1
    error = capsys.readouterr().err
    assert "/World/Ball" in error
    assert "Traceback" not in error
    assert (tmp_path / "out" / "report.json").exists()


def test_a_terminal_that_closes_twice_over_lets_the_update_in_progress_finish():
    """The system and the shell may both say so; then nothing is left that could end the process before its report."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        with between_updates() as received:
            signal.raise_signal(signal.SIGHUP)
            signal.raise_signal(signal.SIGHUP)
        assert received == [signal.SIGHUP] * 2
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_run_under_nohup_goes_on_when_the_terminal_closes():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with between_updates() as received:
            signal.raise_signal(signal.SIGHUP)
        assert received == []
    finally:
        signal.signal(signal.SIGHUP, before)


def test_what_an_earlier_run_left_does_not_stand_beside_a_run_that_records_nothing(tmp_path, small):
    out = tmp_path / "out"
    assert main(["run", str(small), "--updates", "6", "--out", str(out)]) == 0
    assert (out / "run.mcap").exists()
    small.write_text("tickgraph: 1\n")
    assert main(["run", str(small), "--updates", "6", "--out", str(out)]) == 0
    assert sorted(file.name for file in out.iterdir()) == ["report.json"]
    assert json.loads((out / "report.json").read_text())["topics"] == {}


def test_input_that_is_wrong_leaves_an_earlier_run_as_it_was(tmp_path, small):
    out = tmp_path / "out"
    assert main(["run", str(small), "--updates", "6", "--out", str(out)]) == 0
    before = (out / "run.mcap").read_bytes(), (out / "report.json").read_bytes()
    small.write_text(SMALL.replace("radius: 0.25", "radios: 0.25"))
    assert main(["run", str(small), "--updates", "6", "--out", str(out)]) == 2
    assert ((out / "run.mcap").read_bytes(), (out / "report.json").read_bytes()) == before


@pytest.mark.parametrize("played", ["out/run.mcap", "out"])
def test_a_recording_that_is_being_played_is_not_written_over(tmp_path, small, capsys, played):
    out = tmp_path / "out"
    assert main(["run", str(small), "--updates", "6", "--out", str(out)]) == 0
    before = (out / "run.mcap").read_bytes()
    assert main(["run", str(small), "--updates", "6", "--out", str(out), "--play", str(tmp_path / played)]) == 2
    assert "run.mcap and would write over it; name another folder" in capsys.readouterr().err
    assert (out / "run.mcap").read_bytes() == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupt_ends_with_130_and_a_readable_recording(number, tmp_path, small):
    out = tmp_path / "out"
    arguments = ("-m", "graph", "run", str(small), "--duration", "3600", "--out", str(out))
    env = {**os.environ, "COLUMNS": "200"}
    recording = out / "run.mcap"
    with started(*arguments, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while not (recording.exists() and recording.stat().st_size > 100_000) and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(number)
        _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert "Traceback" not in error
    report = json.loads((out / "report.json").read_text())
    assert len(messages(recording, "/clock")) == report["updates"] > 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_output_that_cannot_be_written_is_one_line():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "graph", "nodes"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (1, "graph: No space left on device\n")


def test_a_sensor_that_sees_nothing_is_reported_so(tmp_path, capsys):
    nothing_to_see = [line for line in SMALL.splitlines() if "Ground" not in line and "Ball" not in line]
    file = tmp_path / "empty.yaml"
    file.write_text("\n".join(nothing_to_see))

    assert main(["run", str(file), "--updates", "12"]) == 0

    assert "sensor-saw-nothing: /World/Lidar: no return in any of its 2 frames" in capsys.readouterr().err
    assert main(["run", str(file), "--updates", "12", "--strict"]) == 1
    assert "strict: sensor /World/Lidar rendered 2 frames without a single return" in capsys.readouterr().err
