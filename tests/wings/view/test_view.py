"""`graph view`: the page and the pictures of a recorded run."""

import base64
import json
import re
import resource
import shutil

import numpy as np
import pytest

from graph.cli.main import main
from graph.recording.mcap_sink import McapSink
from graph.recording.run_reader import open_run
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain
from tests.support.browser import browse
from wings.view.clouds import CloudPanel, chosen, some
from wings.view.collecting import collect, points_a_cloud
from wings.view.pictures import top_view
from wings.view.times import Times, clocks
from wings.view.values import Series

RUN = """
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Wall:   {type: Cube, size: 2.0, translate: [6, 0, 1]}
    /World/Lidar:  {type: OmniLidar, config: Example_Rotary, translate: [0, 0, 1]}
    /World/Camera: {type: Camera, translate: [0, 0, 1], rotate: [90, 0, -90]}
    /World/Sun:    {type: DistantLight, attributes: {"inputs:intensity": 3000}}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      once: Once
      turns: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: lidar}}
      images: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 64, height: 48}}
      rgb: {type: ROS2CameraHelper, inputs: {type: rgb, topicName: rgb, frameId: camera}}
    connections:
      - tick.tick -> once.execIn
      - once.once -> turns.execIn
      - turns.execOut -> [cloud.execIn, images.execIn]
      - turns.renderProductPath -> cloud.renderProductPath
      - images.execOut -> rgb.execIn
      - images.renderProductPath -> rgb.renderProductPath
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of half a second."""
    place = tmp_path_factory.mktemp("run")
    (place / "graph.yaml").write_text(RUN)
    assert main(["run", str(place / "graph.yaml"), "--updates", "30", "--out", str(place / "out")]) == 0
    return place / "out"


def embedded(page):
    """The data of a page's script."""
    return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)[1])


def test_the_page_holds_everything_and_names_no_other_place(folder, capsys):
    assert main(["view", str(folder)]) == 0
    assert re.search(r"wrote .*view\.html \(\d+\.\d MB\) and \d+ pictures", capsys.readouterr().out)
    page = (folder / "view" / "view.html").read_text()
    assert len(page) < 25e6
    own = page.replace(re.search(r"<script>(?!\s*\"use strict\").*?</script>", page, re.DOTALL)[0], "")  # plotly's
    assert not re.findall(r"(?:src|href)=\"(?!data:)[^\"]*", own)
    data = embedded(page)
    assert sorted(row[0] for row in data["topics"]) == ["/points", "/rgb"]
    (cloud,) = data["clouds"]
    assert cloud["topic"] == "/points"
    assert len(cloud["frames"]) == cloud["count"] == 5
    assert len(cloud["ranges"]) == 5
    assert len(data["pictures"][0]["frames"]) == 30  # the camera renders in every update
    assert [row["name"] for row in data["rows"]][:3] == [
        "timeline: updates, 60 Hz",
        "physics: steps, 60 Hz",
        "renderer: updates with frames",
    ]


def test_places_in_the_page_are_those_of_the_message_to_a_65535th_of_the_scene(folder):
    with open_run(folder) as run:
        found = collect(run, {"/points": 16.0 * 60_000}, 50_000_000)
    panel = found.clouds["/points"]
    data = panel.data()
    raw = np.frombuffer(base64.b64decode(data["frames"][0]["places"]), "<u2").reshape(-1, 3)
    places = np.array(data["low"]) + raw * np.array(data["steps"])
    assert len(places) == len(panel.frames[0].places) > 50_000
    assert panel.frames[0].total == 271_912  # more than a cloud of the page has
    np.testing.assert_allclose(places, panel.frames[0].places, atol=np.max(data["steps"]) / 2 + 1e-6)


def test_pictures_are_one_a_second_of_each_sensor(folder):
    assert main(["view", str(folder), "--out", str(folder / "pictures")]) == 0
    names = sorted(path.name for path in (folder / "pictures").glob("*.png"))
    assert names == ["points_range_00000100ms.png", "points_top_00000100ms.png", "rgb_00000016ms.png"]


def test_a_topic_can_be_chosen_and_a_name_that_fits_nothing_is_refused(folder, tmp_path, capsys):
    assert main(["view", str(folder), "--topic", "rgb", "--out", str(tmp_path)]) == 0
    data = embedded((tmp_path / "view.html").read_text())
    assert [row[0] for row in data["topics"]] == ["/rgb"]
    assert data["clouds"] == []
    assert main(["view", str(folder), "--topic", "nothing", "--out", str(tmp_path / "new")]) == 2
    assert "no such topic" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_a_warning_cannot_end_the_script_that_holds_it(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "run", ignore=shutil.ignore_patterns("view", "pictures"))
    report = tmp_path / "run" / "report.json"
    found = json.loads(report.read_text())
    found["warnings"] = [{"code": "x", "where": "", "message": "</script><script>alert(1)</script>"}]
    report.write_text(json.dumps(found))
    assert main(["view", str(tmp_path / "run")]) == 0
    page = (tmp_path / "run" / "view" / "view.html").read_text()
    assert "alert(1)</script>" not in page
    assert embedded(page)["warnings"] == [["x", "", "</script><script>alert(1)</script>"]]


@pytest.mark.skipif(
    shutil.which("chromium") is None or resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY,
    reason="needs the browser chromium, and address space for it",
)
@pytest.mark.parametrize(("width", "dark"), [(1400, False), (390, True)])
def test_a_browser_draws_every_panel_without_an_error(folder, tmp_path, width, dark):
    assert main(["view", str(folder), "--out", str(tmp_path)]) == 0
    with browse(tmp_path / "view.html", tmp_path / "profile", width, dark=dark) as page:
        panels = "[...document.querySelectorAll('.scene, .cloud, .plot')]"
        page.wait_for(f"{panels}.length && {panels}.every((one) => one.querySelector('.main-svg'))")
        page.wait_for("document.body.textContent.match(/at 0\\.\\d+ s, \\d+ (of \\d+ )?points/)")
        page.value("show(clock.end)")
        assert page.value("document.getElementById('now').textContent") == "0.500 s"
        assert page.value("document.documentElement.scrollWidth") == width  # nothing is cut off at the right
        if width > 1100:  # two columns of cards end at one height, so that no gap is left beside a tall card
            last = "[...one.children].map((side) => Math.round(side.lastElementChild.getBoundingClientRect().bottom))"
            ends = page.value(f"[...document.querySelectorAll('.columns')].map((one) => {last})")
            assert [left == right for left, right in ends] == [True]
        back = page.value("getComputedStyle(document.body).backgroundColor")
        assert (max(map(int, re.findall(r"\d+", back))) < 60) == dark
        assert (page.complaints(), page.requests()) == ([], [])


def test_few_of_many_are_spread_evenly_with_both_ends():
    assert chosen(3, 5) == (0, 1, 2)
    assert chosen(101, 5) == (0, 25, 50, 75, 100)
    assert chosen(9, 1) == (8,)
    assert chosen(9, 0) == ()
    assert chosen(0, 4) == ()


def test_some_points_are_in_order_without_repeats_and_the_same_each_time():
    drawn = some(1000, 100)
    assert len(drawn) == len(np.unique(drawn)) == 100
    assert (np.diff(drawn) > 0).all()
    assert (drawn == some(1000, 100)).all()
    assert (some(7, 9) == np.arange(7)).all()


def test_small_clouds_leave_their_share_to_large_ones():
    # 10 frames of 1,000 points take 120,000 bytes of 6,120,000: 6,000,000 / 12 / 10 = 50,000 points of the large one
    sizes, frames = {"small": 1_000, "large": 200_000}, {"small": 10, "large": 10}
    assert abs(points_a_cloud(sizes, frames, 6_120_000) - 50_000) <= 1


def test_ticks_without_a_message_are_found():
    times = Times("/t", {"tickgraph_rate_hz": "10"})
    for tick in (1, 2, 5):
        times.add(tick * 100_000_000, 0)
    assert [float(one) for one in times.missing()] == [0.3, 0.4]
    assert Times("/t", {}).missing() == []


def test_clocks_of_a_report_tick_at_their_rates():
    rows = clocks({"loop_hz": "60", "physics_hz": "240", "updates": 6, "physics_steps": 24}, {})
    assert [len(row["t"]) for row in rows] == [6, 24]
    assert rows[0]["t"][-1] == rows[1]["t"][-1] == 0.1


def test_values_of_lists_carry_the_names_of_the_message():
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE).types
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    header = types["std_msgs/msg/Header"](stamp, "")
    empty = np.zeros(0)
    message = types["sensor_msgs/msg/JointState"](header, ["hip", "knee"], np.array([0.5, -1.0]), empty, empty)
    series = Series("/joint_states")
    series.add(10**9, "sensor_msgs/msg/JointState", message)
    lines = [{"name": "hip", "y": [0.5]}, {"name": "knee", "y": [-1.0]}]
    assert series.data() == {
        "topic": "/joint_states",
        "holds": False,
        "t": [1.0],
        "quantities": [{"name": "position", "unit": "rad or m", "lines": lines, "more": 0}],
    }


def test_few_points_are_drawn_as_squares_and_many_as_pixels():
    """10 m are 700 pixels. 30 points: sqrt(2000 / 30) = 8, at most 7 pixels wide; 2,000 and more: 1."""
    low, high = np.array([0.0, 0.0, 0.0]), np.array([10.0, 10.0, 1.0])
    grid = np.stack(np.meshgrid(np.arange(1.0, 7.0), np.arange(2.0, 7.0)), -1).reshape(-1, 2)
    few = np.column_stack([grid, np.full(30, 0.5)])
    assert np.count_nonzero(np.asarray(top_view(few, low, high))) == 30 * 7 * 7
    many = np.column_stack([np.arange(2000) % 50 / 5 + 0.05, np.arange(2000) // 50 / 5 + 0.05, np.ones(2000)])
    assert np.count_nonzero(np.asarray(top_view(many, low, high))) == 2000


def test_an_empty_cloud_has_a_panel_without_points():
    assert CloudPanel("/points").data()["frames"] == []


def test_a_page_does_not_take_the_place_of_another_recordings(tmp_path):
    for name in ("a.mcap", "b.mcap"):
        bus, sink = MessageBus(), McapSink(tmp_path / name)
        bus.subscribe(sink)
        bus.publish("/x", "std_msgs/msg/String", from_plain("std_msgs/msg/String", {"data": name}), 0)
        bus.close()
        assert main(["view", str(tmp_path / name)]) == 0
    assert sorted(one.parent.name for one in (tmp_path / "view").rglob("view.html")) == ["a.mcap", "b.mcap"]
