"""`--set NODE.ATTR=VALUE` and `--set /PRIM.ATTR=VALUE`, for prims of the file, of a USD scene and of an MJCF model."""

from __future__ import annotations

import pytest

from graph.base.errors import UserError
from graph.files import loads
from graph.session.open import build_parts
from graph.session.overrides import apply_overrides
from graph.sim import App
from tests.support.without_wing import needs_wing

FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Box: {type: Cube, size: 1.0, orient: [1, 0, 0, 0], mass: 2.0, rigid_body: true}
    /World/Lidar: {type: OmniLidar, config: OS1, attributes: {"omni:sensor:tickRate": 5}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5, period: 1}}
    connections:
      - tick.tick -> wait.execIn
"""
USD = """\
#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def Sphere "Ball" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
    {
        double radius = 0.5
        double3 xformOp:translate = (0, 0, 5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def OmniLidar "Lidar" (prepend apiSchemas = ["OmniSensorAPI"])
    {
        double omni:sensor:tickRate = 10
    }
}
"""
MJCF = '<mujoco><worldbody><body name="ball" pos="0 0 3"><freejoint/><geom size=".1"/></body></worldbody></mujoco>'
SENSOR = "tickgraph: 1\nscene: {FILE, prims: {/World/Eye: {type: Camera}}}\n"


@pytest.fixture
def file(tmp_path):
    """A graph file with inline prims and a graph."""
    path = tmp_path / "file.yaml"
    path.write_text(FILE)
    return path


@pytest.fixture
def over_usd(tmp_path):
    """A graph file over a USD scene."""
    (tmp_path / "scene.usda").write_text(USD)
    path = tmp_path / "over.yaml"
    path.write_text(SENSOR.replace("FILE", "usd: scene.usda"))
    return path


def attribute(parts, path, name):
    assert parts.problems == []
    return parts.stage.GetPrimAtPath(path).GetAttribute(name).Get()


def said(path, **overrides):
    return [problem.message for problem in build_parts(path, **overrides).problems]


def test_an_attribute_of_a_prim_gets_the_type_of_its_schema(file):
    parts = build_parts(file, overrides={"/World/Lidar.omni:sensor:tickRate": "20"})
    assert attribute(parts, "/World/Lidar", "omni:sensor:tickRate") == 20.0
    flag = {"/World/Lidar.omni:sensor:Core:accumulateOutputs": "false"}
    assert attribute(build_parts(file, overrides=flag), "/World/Lidar", "omni:sensor:Core:accumulateOutputs") is False


def test_values_that_are_no_text_are_taken_as_they_are(file):
    with App.from_file(file, overrides={"/World/Box.translate": [1, 2, 3], "wait.duration": 7}) as app:
        assert [*app.stage.GetPrimAtPath("/World/Box").GetAttribute("xformOp:translate").Get()] == [1, 2, 3]
        assert app.graphs["/World/G"].node("wait").get("duration") == 7


def test_a_key_replaces_the_one_that_it_excludes(file):
    scene = apply_overrides(loads(FILE), {"/World/Box.rotate": "[0, 0, 90]", "/World/Box.density": "1000"}).scene
    assert scene.prims["/World/Box"] == {
        **{"type": "Cube", "size": 1.0, "rigid_body": True},
        **{"rotate": [0, 0, 90], "density": 1000},
    }
    assert build_parts(file, overrides={"/World/Box.rotate": "[0, 0, 90]"}).problems == []


def test_a_later_setting_of_a_prim_keeps_the_earlier_ones(over_usd):
    both = {"/World/Ball.translate": "[0, 0, 9]", "/World/Ball.radius": "2", "/World/Ball.visibility": "invisible"}
    parts = build_parts(over_usd, overrides=both)
    assert [*attribute(parts, "/World/Ball", "xformOp:translate")] == [0, 0, 9]
    assert attribute(parts, "/World/Ball", "radius") == 2
    assert attribute(parts, "/World/Ball", "visibility") == "invisible"


def test_prims_of_a_usd_scene_take_attributes_and_the_file_on_disk_stays(over_usd, tmp_path):
    parts = build_parts(over_usd, overrides={"/World/Lidar.omni:sensor:tickRate": "20"})
    assert attribute(parts, "/World/Lidar", "omni:sensor:tickRate") == 20
    assert (tmp_path / "scene.usda").read_text() == USD
    assert attribute(build_parts(over_usd), "/World/Lidar", "omni:sensor:tickRate") == 10


@needs_wing("mjcf")
def test_prims_of_an_mjcf_model_take_attributes(tmp_path):
    (tmp_path / "model.xml").write_text(MJCF)
    path = tmp_path / "file.yaml"
    path.write_text(SENSOR.replace("FILE", "mjcf: model.xml"))
    parts = build_parts(path)
    ball = next(str(prim.GetPath()) for prim in parts.stage.Traverse() if prim.GetName() == "ball")
    parts = build_parts(path, overrides={f"{ball}.visible": "false"})
    assert attribute(parts, ball, "visibility") == "invisible"


RATE = "omni:sensor:tickRate"
TRANSLAT = "Cube has no attribute 'translat'; did you mean the prim's own key \"translate\"?"


@pytest.mark.parametrize(
    ("target", "value", "line"),
    [
        ("/World/Lidar.tickRate", "20", f"OmniLidar has no attribute 'tickRate'; did you mean \"{RATE}\"?"),
        (f"/World/Lidar/{RATE}", "20", f"the attribute stands behind a dot: /World/Lidar.{RATE}"),
        ("/World/Box/size", "5", "the attribute stands behind a dot: /World/Box.size"),
        ("Lidar.omni:sensor:tickRate", "20", "a prim is named by its whole path: /World/Lidar.omni:sensor:tickRate"),
        ("/World/Lidr.translate", "[0, 0, 1]", 'there is no such prim; did you mean "/World/Lidar"?'),
        ("/World/Box.translat", "[0, 0, 1]", TRANSLAT),
        ("/World/Box.translate", "5", "5 is not a list of 3 numbers"),
        ("/World/Box.radius", "5", "Cube has no radius; it has size"),
        ("/World/Lidar.omni:sensor:tickRate", "fast", "'fast' is not a number"),
        ("/World/G/wiat.duration", "5", 'no node has that name; did you mean "/World/G/wait"?'),
        ("wiat.duration", "5", 'no node has that name; did you mean "wait"?'),
        ("wait.execIn", "5", "a connection feeds this input; set the attribute at its source"),
        ("tickRate", "5", "write NODE.ATTR=VALUE for a node's input, or /PRIM/PATH.ATTR=VALUE for a prim of the scene"),
    ],
)  # fmt: skip
def test_a_wrong_target_is_one_line_that_names_the_right_one(file, target, value, line):
    assert said(file, overrides={target: value}) == [f"--set {target}: {line}"]


def test_a_prim_may_be_spelled_with_the_mapping_that_files_write(file):
    parts = build_parts(file, overrides={"/World/Lidar.attributes.omni:sensor:tickRate": "20"})
    assert attribute(parts, "/World/Lidar", "omni:sensor:tickRate") == 20.0


def test_all_wrong_targets_are_told_together():
    with pytest.raises(UserError) as caught:
        apply_overrides(loads(FILE), {"a.b": "1", "c": "2"})
    assert len(caught.value.problems) == 2


@pytest.mark.parametrize(
    "command", ["run", "check", "explain", "inspect", pytest.param("trade", marks=needs_wing("trade"))]
)
def test_every_command_with_set_refuses_a_wrong_prim(command, file, capsys):
    from graph.cli.main import main

    more = ["--vary", "physics.hz=60"] if command == "trade" else []
    assert main([command, str(file), "--set", "/World/Lidar.tickRat=20", *more]) == 2
    [line] = capsys.readouterr().err.splitlines()
    hint = f"OmniLidar has no attribute 'tickRat'; did you mean \"{RATE}\"?"
    assert line == f"graph: --set /World/Lidar.tickRat: {hint}"


def test_keys_of_the_clock_and_the_scene_are_set_as_the_file_writes_them(over_usd):
    (over_usd.parent / "other.usda").write_text(USD)
    given = {"clock.loop_hz": "30", "clock.parity": "isaacsim-6.0.1", "scene.usd": "other.usda"}
    spec = build_parts(over_usd, overrides=given).spec
    assert (spec.clock.loop_hz, spec.clock.parity, spec.scene.usd.name) == (30, "isaacsim-6.0.1", "other.usda")


@pytest.mark.parametrize(
    ("target", "value", "problem"),
    [
        ("clock.parity", "old", "--set clock.parity: 'old' cannot be; choose one of documented, isaacsim-6.0.1"),
        ("clock.rate", "5", '--set clock.rate: there is no key "rate"'),
        ("scene.usd", "../s.usda", '--set scene.usd: "../s.usda" is outside the graph file\'s folder'),
    ],
)
def test_a_key_of_a_section_that_cannot_be_is_refused(over_usd, target, value, problem):
    (found,) = (one.message for one in build_parts(over_usd, overrides={target: value}).problems)
    assert found.startswith(problem)
