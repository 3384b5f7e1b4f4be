"""Robots that ship stand: each drives forwards and back, turns and stops level, at the commanded speed."""

import re
from math import degrees

import numpy as np
import pytest
from ruamel.yaml import YAML

import sensors.replicator as rep
from graph.cli.new import KINDS, text
from graph.sim import App
from tests.support.driving import DRIVES, controllers, drive
from tests.support.places import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "graph" / "manual").glob("*.md"))]
EXAMPLES = [path for path in sorted((ROOT / "graphs").glob("*.yaml")) if not path.name.endswith(".test.yaml")]
FILES = {
    **{path.name: path.read_text(encoding="utf-8") for path in EXAMPLES},
    **{f"graph new {kind}": text(kind, "FILE") for kind in KINDS},
    **{
        f"{page.name}, block {number}": block
        for page in PAGES
        for number, block in enumerate(re.findall(r"^```yaml\n(.*?)^```$", page.read_text("utf-8"), re.M | re.S))
    },
}
"""Every graph file that the project ships or prints."""
ROBOTS = {
    name: content
    for name, content in FILES.items()
    if "DifferentialController" in content and "randomize:" not in content  # crates may stand in its way
}


def test_the_robots_are_found():
    assert ROBOTS.keys() >= {"yard.yaml", "graph new diffdrive"}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_stays_level_and_moves_as_its_wheels_say(name, tmp_path):
    """Forwards, stop, back, stop, turns both ways, a curve, stop: each for a second, from one straight to the next."""
    path = ROOT / "graphs" / name
    if not path.exists():
        path = tmp_path / "robot.yaml"
        path.write_text(ROBOTS[name], encoding="utf-8")
    with App.from_file(path) as app:
        (controller,) = controllers(app)
        driven = drive(app, controller)
    assert degrees(driven.tilt) < 1.0
    assert driven.rolled == pytest.approx(np.array(DRIVES), abs=0.005)  # the drives hold their speed
    assert driven.moved == pytest.approx(np.array(DRIVES), abs=0.015)  # the wheels roll, they do not slip


@pytest.fixture
def diffdrive(tmp_path):
    """The robot of `graph new diffdrive` with a planar lidar 0.2 m above its axle."""
    yaml = YAML(typ="safe")
    content = yaml.load(text("diffdrive", "FILE"))
    mount = {"type": "OmniLidar", "config": "picoScan150", "translate": [0.1, 0, 0.2], "exclude": ["/World/Robot"]}
    content["scene"]["prims"]["/World/Robot/chassis/lidar"] = mount
    path = tmp_path / "robot.yaml"
    with path.open("w", encoding="utf-8") as out:
        yaml.dump(content, out)
    return path


def test_what_is_mounted_on_the_chassis_stands_where_it_is_written(diffdrive):
    with App.from_file(diffdrive) as app:
        app.play()
        app.update()
        place = app.fabric.world_matrix("/World/Robot/chassis/lidar")
    assert place[:3, :3] == pytest.approx(np.eye(3), abs=0.01)
    assert place[:3, 3] == pytest.approx((0.1, 0, 0.3), abs=0.002)  # the axle is at 0.1 m


def test_its_lidar_does_not_scan_the_floor(diffdrive):
    """It tilts by 1 degree at the most, when it brakes: a beam at 0.3 m then meets the floor at 17 m."""
    with App.from_file(diffdrive) as app:
        nearest = [np.inf]
        product = rep.create_render_product("/World/Robot/chassis/lidar")
        product.sensor.require("test", {"distance"}, ignore_aux=True)

        def look():
            if product.frame is not None:
                nearest.append(product.frame.channel("distance").min(initial=np.inf))

        app.on("post_render_graphs", look)
        drive(app, *controllers(app))
        frames = product.frames
    assert frames > 100
    assert min(nearest) > 17
