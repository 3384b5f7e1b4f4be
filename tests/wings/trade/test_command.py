"""`graph trade` as a user meets it: what it refuses, what it writes, how it ends."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import time

import pytest
from PIL import Image

from graph.base.errors import RunError
from tests.support.programs import started
from wings.trade.command import write_files

BALL = """\
# a ball in the air
tickgraph: 1
scene:
  prims:
    /World/Ball: {type: Sphere, radius: 0.1, translate: [0, 0, 100], rigid_body: true, mass: 2.0} # kept
clock: {physics_hz: 60, loop_hz: 60}

# what runs
duration: 2
"""


@pytest.fixture
def ball(folder):
    file = folder / "ball.yaml"
    file.write_text(BALL)
    return file


def test_every_mistake_is_a_line_and_nothing_is_written(graph, ball, folder):
    result = graph(
        *("trade", ball, "--vary", "physics.hz=0", "--vary", "motion=1", "--reference", "lidar.bins=x"),
        *("--budget", "body.position=1", "--budget", "body.position_max=-1", "--duration", "-1", "--repeat", "0"),
        *("--out", "out"),
    )
    assert result.code == 2
    assert result.err.splitlines() == [
        "graph: --vary physics.hz=0: '0' is not above 0",
        'graph: --vary motion=1: there is no such knob; did you mean "lidar.motion"?',
        "graph: --reference lidar.bins=x: 'x' is not a number",
        'graph: --budget body.position=1: there is no such metric; did you mean "body.position_rms"?',
        "graph: --budget body.position_max=-1: give a number of m, 0 or more",
        "graph: --duration -1: give simulated seconds, more than 0",
        "graph: --repeat 0: give a number of runs, 1 or more",
    ]
    assert [*folder.iterdir()] == [ball]


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ((), "give a knob to vary: --vary KEY=V1,V2,... (graph trade --list)"),
        (("--vary", "physics.hz=60", "--fidelity", "physics.hz=60"), "--fidelity physics.hz: --vary has this knob too"),
        (("--vary", "physics.hz=60", "--write"), "--write writes the cheapest setting within a budget"),
        (("--vary", "physics.hz=60", "--out", "ball.yaml"), "--out ball.yaml: ball.yaml is not a folder"),
    ],
)
def test_what_is_missing_is_told(graph, ball, options, line):
    result = graph("trade", ball, *options)
    assert result.code == 2
    assert line in result.err


def test_a_budget_of_a_metric_that_the_scene_cannot_give_is_refused(graph, ball, folder):
    result = graph("trade", ball, "--vary", "physics.hz=60,120", "--budget", "lidar.range_p99=1", "--out", "out")
    assert result.code == 2
    assert result.err == (
        "graph: --budget lidar.range_p99: this scene does not give it in 1 s; it needs a lidar that something in the "
        "graphs reads\n"
    )
    assert not (folder / "out").exists()


def test_the_list_names_every_knob_and_metric(graph):
    told = json.loads(graph("trade", "--list", "--json").out)
    assert told["knobs"]["lidar.motion"]["finer"] == "continuous"
    assert {"body.position_max", "lidar.range_p99", "radar.recall", "cost.casts"} <= told["metrics"].keys()
    lines = graph("trade", "--list").out.splitlines()
    assert {line.partition("\t")[0] for line in lines if line} == {*told["knobs"], *told["metrics"]}


def test_it_finds_the_cheapest_setting_writes_everything_and_the_block_into_the_file(graph, ball, folder):
    """Off by g dt t / 2 (`test_errors_by_paper`): against 480 Hz, 60 Hz by 0.0715 m after 1 s, 120 Hz by 0.031 m."""
    result = graph(
        *("trade", ball, "--vary", "physics.hz=60,120,480", "--budget", "body.position_max=0.05"),
        *("--repeat", "2", "--out", "out", "--write"),
    )
    assert result.code == 0, result.err
    told = json.loads((folder / "out/trade.json").read_text())
    errors = {one["setting"]["physics.hz"]: one["errors"]["body.position_max"] for one in told["settings"]}
    assert errors == {"60": pytest.approx(0.0715, abs=1e-4), "120": pytest.approx(0.0307, abs=1e-4), "480": 0}
    assert told["reference"]["moved"]["body.position_max"] == pytest.approx(9.81 / 480 / 4, rel=1e-3)
    assert told["reference"]["horizon"] == 1.0
    assert all(len(one["cost"]["runs"]) == 2 for one in told["settings"])
    best = told["recommended"]["physics.hz"]
    assert best in ("120", "480")  # the faster one on this machine at this moment
    assert f"fidelity:\n  physics.hz: {best}" in result.out
    assert len([*csv.DictReader((folder / "out/trade.csv").open())]) == 3
    for name in ("trade.png", "trade_parts.png"):
        with Image.open(folder / "out" / name) as picture:
            assert min(picture.size) > 200
    page = (folder / "out/trade.html").read_text()
    assert page.count("data:image/png;base64,") == 3
    assert "http:" not in page
    assert "https:" not in page
    block = f"fidelity:\n  physics.hz: {best}\n"
    assert ball.read_text() == BALL.replace("loop_hz: 60}\n", f"loop_hz: 60}}\n{block}")
    again = graph(
        *("trade", ball, "--vary", "fabric=on", "--reference", "physics.hz=480"),  # as the file is now
        *("--budget", "body.position_max=0.05", "--json"),
    )
    assert again.code == 0
    assert json.loads(again.out)["settings"][0]["errors"]["body.position_max"] == errors[best] <= 0.05


def test_without_a_setting_in_the_budget_it_names_the_nearest(graph, ball):
    result = graph("trade", ball, *("--vary", "physics.hz=60,120", "--reference", "physics.hz=480", "--repeat", "1"),
                   *("--budget", "body.position_max=0.02"))  # fmt: skip
    assert result.code == 1
    assert result.out.splitlines()[-4:] == [
        "no setting keeps body.position_max <= 0.02 m",
        "the nearest is physics.hz=120: body.position_max 0.0307 m",
        "fidelity:",
        "  physics.hz: 120",
    ]


def test_no_setting_keeps_a_budget_finer_than_the_reference_is_known_not_even_the_reference(graph, ball):
    """480 Hz is g dt t / 2 = 9.81 / 960 = 10.2 mm ahead of the parabola after 1 s."""
    result = graph("trade", ball, "--vary", "physics.hz=60,480", "--repeat", "1", "--budget", "body.position_max=0.001")
    assert result.code == 1
    assert result.out.splitlines()[-4:] == [
        "no setting is known to keep body.position_max <= 0.001 m: the reference's own error may be 0.0102 m; "
        "give a wider budget, a finer --reference or a shorter --duration",
        "as near as is known, the cheapest is physics.hz=480: body.position_max 0 m",
        "fidelity:",
        "  physics.hz: 480",
    ]
    assert "~ less than the reference's own error" in result.out


def test_the_reference_of_the_integrator_is_the_one_that_converges_not_the_first_typed(graph, ball):
    """In a free fall rk4 is exact, so that refining moves it by nothing; the others are g dt t / 2 ahead: 9.81 / 120 =
    81.75 mm at 60 Hz after 1 s, half of that at 120 Hz.
    """
    result = graph("trade", ball, "--vary", "physics.integrator=euler,rk4,implicitfast", "--repeat", "1", "--json")
    assert result.code == 0, result.err
    told = json.loads(result.out)
    assert told["reference"]["setting"] == {"physics.integrator": "rk4"}
    assert told["reference"]["refined"] == {"physics.integrator": "rk4", "physics.hz": "120"}
    errors = {one["setting"]["physics.integrator"]: one["errors"]["body.position_max"] for one in told["settings"]}
    late = pytest.approx(9.81 / 60 / 2, rel=1e-6)
    assert errors == {"rk4": 0, "euler": late, "implicitfast": late}


SCAN = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 1.0, translate: [-10.5, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
graphs:
  /Graph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: lidar}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


def test_settings_that_read_the_same_knobs_are_run_once_and_knobs_without_effect_are_named(graph, folder):
    """A frozen scan reads no bins: of four settings three are runs. Nothing moves: neither knob changes a range."""
    (folder / "scan.yaml").write_text(SCAN)
    result = graph(
        *("trade", "scan.yaml", "--vary", "lidar.motion=frozen,continuous", "--vary", "lidar.bins=4,8"),
        *("--duration", "0.2", "--repeat", "1", "--json"),
    )
    assert result.code == 0, result.err
    told = json.loads(result.out)
    frozen = [{"lidar.motion": "frozen", "lidar.bins": one} for one in ("4", "8")]
    assert [one["setting"] for one in told["settings"]][:2] == frozen
    assert [one["same_as"] for one in told["settings"]] == [None, frozen[0], None, None]
    assert told["no_effect"] == ["lidar.motion", "lidar.bins"]
    assert 0 < told["leverage"]["lidar"] <= 1


def test_a_budget_of_costs_asks_for_the_least_error_within_it(graph, ball):
    result = graph("trade", ball, "--vary", "physics.hz=60,120", "--repeat", "1", "--budget", "cost.cpu=1000", "--json")
    assert result.code == 0
    told = json.loads(result.out)
    assert (told["least"], told["recommended"]) == ("body.position_max", {"physics.hz": "120"})


def test_a_knob_that_nothing_reads_is_refused(graph, ball):
    options = ("--vary", "physics.hz=60", "--vary", "camera.samples=1,4", "--vary", "radar.rays=1,2")
    result = graph("trade", ball, *options)
    assert result.code == 2
    assert result.err.splitlines() == [
        f"graph: --vary {knob}: nothing in this file reads this knob at physics.hz=60 camera.samples=4 radar.rays=2; "
        "leave it out"
        for knob in ("camera.samples", "radar.rays")
    ]


def test_a_knob_of_the_reference_that_nothing_reads_is_refused_too(graph, ball):
    result = graph("trade", ball, "--vary", "physics.hz=60", "--reference", "lidar.bins=16")
    assert result.code == 2
    assert result.err == (
        "graph: --reference lidar.bins: nothing in this file reads this knob at physics.hz=60 lidar.bins=16; leave it "
        "out\n"
    )


def test_a_setting_that_diverges_is_a_row(graph, folder):
    (folder / "plate.yaml").write_text(
        "tickgraph: 1\nscene:\n  prims:\n    /World/Plate: {type: Cube, size: 1, scale: [2, 1, 0.1], mass: 1, "
        "rigid_body: true, angular_velocity: [5000, 20, 3000]}\n"
    )
    result = graph(
        *("trade", "plate.yaml", "--vary", "physics.integrator=implicitfast,euler", "--reference"),
        *("physics.integrator=implicitfast", "--reference", "physics.hz=480", "--repeat", "1"),
    )
    assert result.code == 0, result.err
    assert "unstable: physics.integrator=euler: /World/Plate: the simulation diverged" in result.out
    assert "errors count up to" in result.out


def test_a_setting_that_is_refused_is_a_row_and_a_refinement_that_is_leaves_the_reference_unchecked(graph, folder):
    """In the experience zero_delay updates and physics steps are one."""
    (folder / "one.yaml").write_text(BALL.replace("loop_hz: 60", "loop_hz: 60, experience: zero_delay"))
    result = graph(
        "trade", "one.yaml", *("--vary", "physics.hz=60,120", "--reference", "physics.hz=60", "--repeat", "1")
    )
    assert result.code == 0, result.err
    assert "refused: physics.hz=120: " in result.out
    assert "the reference is unchecked: it does not run at physics.hz=120" in result.out
    result = graph("trade", "one.yaml", *("--vary", "physics.hz=60,120", "--repeat", "1"))
    assert (result.code, result.out) == (2, "")
    assert "zero_delay" in result.err


@pytest.mark.parametrize(
    ("name", "text"), [("a.json", b'{"tickgraph": 1, '), ("a.yaml", b"a: ["), ("a.yaml", b"\xff\xfe")]
)
def test_a_broken_file_is_a_line_with_its_place_whether_or_not_it_is_to_be_written(graph, folder, name, text):
    (folder / name).write_bytes(text)
    options = ("--vary", "physics.hz=60", "--budget", "body.position_max=1", "--write")
    result = graph("trade", name, *options)
    assert result.code == 2
    assert result.err.startswith(f"{name}:1:")
    assert "internal error" not in result.err


def test_what_never_ends_is_refused(graph, ball):
    """1e12 s at 60 Hz."""
    result = graph("trade", ball, "--vary", "physics.hz=60", "--duration", "1e12")
    assert result.code == 2
    assert result.err.startswith(
        "graph: --duration 1000000000000: 60,000,000,000,000 updates; the limit is 1,000,000,000"
    )


def test_an_option_that_is_given_twice_is_refused(graph, ball):
    options = ("--budget", "body.position_max=1", "--budget", "body.position_max=2")
    result = graph("trade", ball, "--vary", "physics.hz=60", *options)
    assert result.code == 2
    assert result.err == "graph: --budget body.position_max=2: the metric is given twice; leave one of them out\n"


DEPTH = """\
tickgraph: 1
scene: {prims: {/Camera: {type: Camera}, /Wall: {type: Cube, translate: [0, 0, -5]}}}
graphs:
  /Graph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /Camera, width: 16, height: 8}}
      depth: {type: ROS2CameraHelper, inputs: {type: depth, topicName: depth, frameId: camera}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> depth.execIn
      - product.renderProductPath -> depth.renderProductPath
"""


def test_a_camera_whose_depth_alone_is_read_does_not_read_the_samples_of_its_colours(graph, folder):
    (folder / "depth.yaml").write_text(DEPTH)
    result = graph("trade", "depth.yaml", "--vary", "camera.samples=1,4", "--duration", "0.1", "--repeat", "1")
    assert result.code == 2
    assert result.err.startswith("graph: --vary camera.samples: nothing in this file reads this knob")
    (folder / "colours.yaml").write_text(DEPTH.replace("type: depth,", "type: rgb,"))
    result = graph("trade", "colours.yaml", "--vary", "camera.samples=1,4", "--duration", "0.1", "--repeat", "1")
    assert result.code == 0, result.err


def test_a_folder_that_cannot_be_written_in_the_end_costs_no_figure(graph, ball, folder):
    (folder / "out/trade.json").mkdir(parents=True)
    options = ("--vary", "physics.hz=60,120", "--repeat", "1", "--duration", "0.1", "--out", "out")
    result = graph("trade", ball, *options)
    assert result.code == 1
    assert "position_max" in result.out
    assert result.err == "graph: --out out: Is a directory; the figures are above\n"


def test_a_reference_that_diverges_is_an_error(graph, folder):
    (folder / "wild.yaml").write_text(
        "tickgraph: 1\nscene:\n  prims:\n    /Wild: {type: Sphere, rigid_body: true, velocity: [1e11, 0, 0]}\n"
    )
    result = graph("trade", "wild.yaml", "--vary", "physics.hz=60,120")
    assert result.code == 1
    assert result.err.startswith("graph: the reference (physics.hz=120) fails: /Wild: the simulation diverged")


def test_ctrl_c_keeps_what_was_measured(ball, folder):
    options = ["--vary", "physics.hz=60,120", "--repeat", "100000", "--out", str(folder / "out")]
    with started("-m", "graph", "trade", str(ball), *options, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(6)  # long enough for the reference, on a machine that does much else
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    if "graph: interrupted" not in said:  # otherwise there was not yet anything to keep
        assert "this is what was measured by then" in said
        assert json.loads((folder / "out/trade.json").read_text())["complete"] is False


def test_ctrl_c_after_the_last_run_writes_everything(graph, ball, folder, monkeypatch):
    from wings.trade import outputs

    listed = outputs.as_csv

    def interrupted(outcome):
        os.kill(os.getpid(), signal.SIGINT)
        return listed(outcome)

    monkeypatch.setattr(outputs, "as_csv", interrupted)
    options = ("--vary", "physics.hz=60,120", "--repeat", "1", "--duration", "0.1", "--out", "out")
    result = graph("trade", ball, *options)
    assert (result.code, result.err) == (0, "")
    told = json.loads((folder / "out/trade.json").read_text())
    assert told["complete"]
    assert all(one["cost"]["runs"] for one in told["settings"])
    assert (folder / "out/trade.html").exists()


@pytest.mark.parametrize("runs", [2, 4])
def test_ctrl_c_after_any_run_writes_what_was_measured_by_then(graph, ball, folder, monkeypatch, runs):
    """The first two are the reference and its refinement, then come two for errors (the reference's own are known) and
    two timed ones.
    """
    from wings.trade import conduct

    measured = conduct.conduct

    def interrupted(study, pool, progress):
        def count(done, total):
            progress(done, total)
            if done == runs:
                os.kill(os.getpid(), signal.SIGINT)

        return measured(study, pool, count)

    monkeypatch.setattr(conduct, "conduct", interrupted)
    options = ("--vary", "physics.hz=60,120", "--repeat", "1", "--duration", "0.1", "--out", "out")
    result = graph("trade", ball, *options)
    told = json.loads((folder / "out/trade.json").read_text())
    assert told["complete"] is False
    assert result.code == 130, result.err
    assert [one["status"] for one in told["settings"]][1] == "ok"  # the reference
    assert "interrupted" in result.err


RATES = "/World/Eye.omni:sensor:tickRate"
EYE = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 1.0, translate: [0, 0, -3]}
    /World/Eye: {type: Camera}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Eye, width: 32, height: 16}}
      image: {type: ROS2CameraHelper, inputs: {type: depth, topicName: depth, frameId: eye}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> image.execIn
      - product.renderProductPath -> image.renderProductPath
"""


def test_a_sensors_rate_is_varied_with_its_price(graph, folder):
    """A camera of 5, 10 and 20 Hz for 1 s: against 20 Hz, 15 and 10 of 20 frames are missing; the rest are equal."""
    (folder / "eye.yaml").write_text(EYE)
    options = ("--vary", f"{RATES}=5,10,20", "--repeat", "1", "--budget", "frames.missing=0.5", "--json")
    result = graph("trade", "eye.yaml", *options)
    assert result.code == 0, result.err
    told = json.loads(result.out)
    found = {one["setting"][RATES]: (one["frames"], one["errors"]["frames.missing"]) for one in told["settings"]}
    assert found == {"5": (5, 0.75), "10": (10, 0.5), "20": (20, 0)}
    assert {one["errors"]["frames.stamp_max"] for one in told["settings"]} == {0}
    assert told["reference"]["setting"] == {RATES: "20"}
    assert all(one["cost"]["cpu"] > 0 for one in told["settings"])
    for options, line in (
        (("--budget", "cost.cpu=9", "--write"), f"--write writes fidelity knobs, not {RATES}; set it by hand"),
        (("--set", f"{RATES}=3"), f"--set {RATES}: --vary has this attribute too; leave it out of one of them"),
    ):
        result = graph("trade", "eye.yaml", "--vary", f"{RATES}=5,10", *options)
        assert (result.code, result.err) == (2, f"graph: {line}\n")


def test_a_full_disk_leaves_the_files_of_an_earlier_trade_whole(tmp_path, monkeypatch):
    """The third of five files does not fit: it stays as it was, and no part of it is left."""
    resource = pytest.importorskip("resource")
    for name, small in {
        "outputs.as_dict": {},
        "outputs.as_csv": "",
        "diagrams.overview": bytes(100_000),
        "diagrams.parts": b"",
        "page.page": "",
    }.items():
        monkeypatch.setattr(f"wings.trade.{name}", lambda outcome, small=small: small)
    (tmp_path / "trade.png").write_bytes(b"earlier")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, before[1]))
    try:
        with pytest.raises(RunError, match="the figures are above"):
            write_files(None, tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert sorted(os.listdir(tmp_path)) == ["trade.csv", "trade.json", "trade.png"]
    assert (tmp_path / "trade.png").read_bytes() == b"earlier"
