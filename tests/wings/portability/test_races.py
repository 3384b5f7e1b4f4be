"""`graph check --target isaacsim-6.0`: faults of the product in files that run here."""

import json

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

RACE = "fif-race"
OFF = "it is rendered while Motion BVH is off: no frames of it arrive"


def file_of(tmp_path, *, bvh=True, lidar=True, wait=None, rate=0, parity="documented", rendered=True):
    nodes = {
        "tick": "OnPlaybackTick",
        "radar": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": "/World/Radar"}},
        "lidar": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": "/World/Lidar"}},
        "wait": {"type": "omni.graph.action.Countdown", "inputs": {"duration": wait or 5}},
    }
    start = ["wait.finished -> radar.execIn", "tick.tick -> wait.execIn"] if wait else ["tick.tick -> radar.execIn"]
    if not lidar:
        del nodes["lidar"]
    if not rendered:
        del nodes["radar"]
        start = []
    connections = [*start, *(["tick.tick -> lidar.execIn"] if lidar else [])]
    radar = {"type": "OmniRadar", "attributes": {"omni:sensor:tickRate": rate}}
    prims = {"/World/Radar": radar, "/World/Lidar": {"type": "OmniLidar", "config": "Example_Rotary"}}
    content = {
        "tickgraph": 1,
        "scene": {"prims": prims},
        "clock": {"parity": parity},
        "settings": {"/renderer/raytracingMotion/enabled": bvh},
        "graphs": {"/World/G": {"nodes": nodes, "connections": connections}},
    }
    file = tmp_path / "race.json"
    file.write_text(json.dumps(content))
    return file


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({}, True),
        ({"wait": 4}, True),
        ({"wait": 5}, False),
        ({"bvh": False}, False),
        ({"lidar": False}, False),
    ],
)
def test_a_radar_that_is_rendered_at_once_beside_a_lidar_is_told(tmp_path, capsys, options, told):
    assert main(["check", str(file_of(tmp_path, **options)), "--target", "isaacsim-6.0"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if RACE in line]
    assert len(lines) == told
    if told:
        assert "/World/G/radar: /World/Radar is rendered beside a lidar in the first 5 updates" in lines[0]
        assert "make the radar's product after a Countdown of 5" in lines[0]


def test_without_a_target_nobody_is_told(tmp_path, capsys):
    assert main(["check", str(file_of(tmp_path))]) == 0
    assert RACE not in capsys.readouterr().err


def test_the_example_with_the_remedy_is_fine(capsys):
    assert main(["check", str(ROOT / "graphs" / "radar_countdown.yaml"), "--target", "isaacsim-6.0"]) == 0
    assert RACE not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("code", "options", "told"),
    [
        ("radar-motion-bvh-off", {"bvh": False}, OFF),
        ("radar-motion-bvh-off", {"bvh": False, "parity": "isaacsim-6.0.1"}, OFF),
        ("radar-motion-bvh-off", {}, None),
        ("radar-motion-bvh-off", {"bvh": False, "rendered": False}, None),
        ("radar-tick-rate-ignored", {"rate": 20}, "it does not render at 20 Hz there"),
        ("radar-tick-rate-ignored", {"rate": 20, "parity": "isaacsim-6.0.1"}, "it does not render at 20 Hz there"),
        ("radar-tick-rate-ignored", {"rate": 0}, None),
    ],
)
def test_what_a_radar_does_otherwise_there_is_told_once(tmp_path, capsys, code, options, told):
    assert main(["check", str(file_of(tmp_path, lidar=False, **options)), "--target", "isaacsim-6.0"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if code in line]
    assert len(lines) == bool(told)
    if told:
        assert ": /World/Radar" in lines[0]
        assert told in lines[0]
