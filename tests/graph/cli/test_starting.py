"""What helps a new user to start: `graph new`, `graph sensors`, `graph completion`, wrong options."""

import contextlib
import io
import json
import subprocess

import numpy as np
import pytest

from graph.cli.examples import examples
from graph.cli.main import main
from graph.cli.new import KINDS
from sensors import SUPPORTED_CAMERA_CONFIGS, SUPPORTED_LIDAR_CONFIGS, SUPPORTED_RADAR_CONFIGS
from sensors.configs.figures import arc
from tests.support.without_wing import MISSING_EXAMPLES, needs_wing


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_file_is_valid_and_runs(kind, graph, folder):
    made = graph("new", kind, "start.yaml")
    drives = kind == "diffdrive"
    files, play = (
        ("start.yaml and start.commands.yaml", "--play start.commands.yaml ") if drives else ("start.yaml", "")
    )
    lines = (f"wrote {files}; next:", f"  graph run start.yaml {play}--out out/start", "  graph view out/start", "")
    assert (made.code, made.out) == (0, "\n".join(lines))
    assert "FILE" not in (folder / "start.yaml").read_text()
    checked = graph("check", "start.yaml")
    assert (checked.code, checked.err) == (0, "")
    ran = graph("run", "start.yaml", "--updates", 30, "--json" if kind == "diffdrive" else "--strict")
    assert (ran.code, ran.err) == (0, "")


def test_a_new_file_never_replaces_one(graph, folder):
    (folder / "mine.yaml").write_text("mine")
    refused = graph("new", "lidar", "mine.yaml")
    assert (refused.code, refused.err) == (2, "graph: mine.yaml exists; give another name, or remove it first\n")
    assert (folder / "mine.yaml").read_text() == "mine"
    assert graph("new", "lidar", "mine.txt").err == "graph: mine.txt: the file is YAML; give it the ending .yaml\n"
    missing = graph("new", "lidar", "deep/mine.yaml")
    assert missing.err == "graph: deep/mine.yaml: its folder deep does not exist; make it first\n"


def test_the_messages_of_the_new_robot_move_it(graph, folder):
    graph("new", "diffdrive", "robot.yaml")
    ran = graph("run", "robot.yaml", "--play", "robot.commands.yaml", "--duration", 1, "--json", "--out", "out")
    assert (ran.code, json.loads(ran.out)["topics"]["/cmd_vel"]["messages"]) == (0, 1)
    assert "COMMANDS" not in (folder / "robot.yaml").read_text()


def test_every_example_is_listed_and_copied_with_all_that_it_needs(graph, folder):
    names = {row.split("\t")[0] for row in graph("new", "--list").out.splitlines() if row}
    assert names == {*KINDS, *examples()}
    assert {"yard", "quickstart", "arm"} <= names
    for name in {"yard", "arm", "quickstart", "camera"} - MISSING_EXAMPLES:
        made = graph("new", name, name)
        assert made.code == 0, made.err
        assert made.out.splitlines()[1:] == [
            f"  graph run {name}/{name}.yaml --out out/{name}",
            f"  graph view out/{name}",
        ]
        checked = graph("check", f"{name}/{name}.yaml", f"{name}/{name}.test.yaml")
        assert checked.code == 0, checked.err
    assert {file.name for file in (folder / "yard").rglob("*") if file.is_file()} == {
        *("yard.yaml", "yard.test.yaml", "yard.usda", "yard_static.usdc"),
    }


def test_an_example_never_replaces_a_folder_with_files(graph, folder):
    (folder / "yard").mkdir()
    (folder / "yard" / "mine").write_text("mine")
    assert graph("new", "yard", "yard").err == "graph: yard exists; give another name, or remove it first\n"
    assert graph("new", "yrad", "x").err == 'graph: there is no example "yrad"; did you mean "yard"?\n'
    said = 'graph: there is no example "robots"; of that are diffdrive, arm, worlds, yard (graph new --list)\n'
    assert graph("new", "robots", "x").err == said
    said = 'graph: there is no example "semantic"; of that is lidar_semantics (graph new --list)\n'
    assert graph("new", "semantic", "x").err == said
    assert graph("new", "yard").err == "graph: name what to write: graph new yard DIR\n"
    assert graph("new").code == 2
    assert [file.name for file in (folder / "yard").iterdir()] == ["mine"]


def test_the_new_robot_drives_as_commanded(graph, folder):
    """v = 0.5 m/s and w = 0.4 rad/s from t = 0: after 2 s the heading is 0.8 rad, on a circle of radius v/w = 1.25 m.

    x = r sin 0.8 = 0.897 m, y = r (1 - cos 0.8) = 0.379 m. Speeding up takes 0.15 s, in which the motors are at their
    limit and the robot hardly turns: that costs 0.06 rad, and so 0.04 m of x and 0.06 m of y.
    """
    graph("new", "diffdrive", "robot.yaml")
    twist = {"linear": {"x": 0.5}, "angular": {"z": 0.4}}
    (folder / "go.yaml").write_text(
        json.dumps([{"at": 0, "topic": "/cmd_vel", "type": "geometry_msgs/msg/Twist", "message": twist}])
    )
    ran = graph("run", "robot.yaml", "--play", "go.yaml", "--duration", 2, "--out", "out")
    assert ran.code == 0
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with open("out/run.mcap", "rb") as stream:
        last = [message.data for _, _, message in make_reader(stream).iter_messages(topics=["/odom"])][-1]
    pose = store.deserialize_cdr(last, "nav_msgs/msg/Odometry").pose.pose
    assert (pose.position.x, pose.position.y) == pytest.approx((0.86, 0.32), abs=0.03)
    assert 2 * np.arctan2(pose.orientation.z, pose.orientation.w) == pytest.approx(0.74, abs=0.03)


def test_the_list_of_sensors_has_a_line_for_every_config(graph):
    rows = [line.split("\t") for line in graph("sensors").out.splitlines()]
    assert len(rows) == len(SUPPORTED_LIDAR_CONFIGS) + len(SUPPORTED_CAMERA_CONFIGS) + len(SUPPORTED_RADAR_CONFIGS)
    by_name = {row[0]: row[1:] for row in rows}
    assert by_name["OS1"] == ["10", "32,768", "0..360", "-22.1..22.1", "0.3..120", "15"]
    assert by_name["TIM781"] == ["15", "811", "-225..45", "0..0", "0.05..25", "1"]
    assert by_name["ZED X"][:2] == ["60", "2,304,000"]
    # 140 by 120 degrees at 4 rays a degree; a radar has no rate of its own.
    assert by_name["IWRL6432AOP"] == ["-", "268,800", "-70..70", "-60..60", "0..25", "1"]


def test_a_sensor_is_described_by_any_spelling_with_its_variants(graph):
    page = graph("sensors", "os1").out
    assert page == graph("sensors", "/Isaac/Sensors/Ouster/OS1/OS1.usd").out
    assert "variant: OS1_REV6_32ch10hz1024res" in page
    assert "variants (15):" in page
    found = json.loads(graph("sensors", "OS1", "--json").out)
    assert found["variants"] == SUPPORTED_LIDAR_CONFIGS[found["asset"]]
    assert found["scan_rate_hz"] * found["rays_per_scan"] == 327_680  # 32 channels at 10,240 firings a second


def test_a_radar_is_described_with_what_to_write_in_a_graph_file(graph):
    page = graph("sensors", "iwrl6432aop").out
    assert "/World/Radar: {type: OmniRadar, config: IWRL6432AOP, translate: [0, 0, 1]}" in page
    assert "folds at 8 and 9 m/s, resolution 0.2 m/s" in page


def test_an_unknown_sensor_is_refused_with_a_near_name(graph):
    refused = graph("sensors", "TIM718")
    assert (refused.code, refused.err) == (2, 'graph: no sensor config "TIM718"; did you mean "TIM781"?\n')
    for series in ("OS", "os"):
        assert graph("sensors", series).err == f'graph: no sensor config "{series}"; there are OS0, OS1, OS2\n'


@pytest.mark.parametrize(
    ("azimuths", "expected"),
    [
        ([0.0], (0.0, 0.0)),
        ([350.0, 0.0, 10.0], (-10.0, 10.0)),
        ([170.0, 180.0, 190.0], (-190.0, -170.0)),
        (np.arange(0, 360, 0.5), (0.0, 360.0)),
        (np.arange(-225, 46), (-225.0, 45.0)),
    ],
)
def test_the_arc_of_emitters_is_the_smallest_that_holds_them(azimuths, expected):
    assert arc(np.array(azimuths)) == pytest.approx(expected)


def test_a_misspelt_option_is_named_with_the_near_one(graph):
    refused = graph("run", "--fidelty", "lidar.motion=frozen", "some.yaml")
    assert refused.code == 2
    assert refused.err == 'graph run: there is no option "--fidelty"; did you mean "--fidelity"; see graph run --help\n'


def test_the_completion_script_is_read_by_bash_and_knows_commands_and_options(graph):
    script = graph("completion", "bash").out
    done = subprocess.run(
        ["bash", "-c", f"{script}\nCOMP_WORDS=(graph exp); COMP_CWORD=1; _shtab_graph; echo ${{COMPREPLY[@]}}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["export", "explain"]
    assert "--fidelity" in script


@pytest.mark.parametrize(
    ("words", "completed"),
    [
        ("node IsaacReadSimulationT", ["IsaacReadSimulationTime", "IsaacReadSimulationTimeAnnotator"]),
        ("sensors XT", ["XT32"]),
        ("help lid", ["lidar"]),
        ("run --fidelity lidar.mot", [f"lidar.motion={value}" for value in ("frozen", "update", "continuous")]),
        pytest.param("trade --vary lidar.mot", ["lidar.motion=frozen,update,continuous"], marks=needs_wing("trade")),
        ("new diff", ["diffdrive"]),
    ],
)
def test_completion_knows_node_types_sensors_knobs_and_topics(completions, words, completed):
    assert completions(words) == completed


@pytest.fixture(scope="module")
def completions():
    """What bash completes for a command line."""
    with contextlib.redirect_stdout(io.StringIO()) as script:
        assert main(["completion", "bash"]) == 0

    def complete(words):
        line = f"COMP_WORDS=(graph {words}); COMP_CWORD={len(words.split())}; _shtab_graph; echo ${{COMPREPLY[@]}}"
        text = f"{script.getvalue()}\n{line}\n"
        done = subprocess.run(["bash"], input=text, capture_output=True, text=True, check=True)
        return done.stdout.split()

    return complete
