"""Graph files over MJCF models, by the commands that people use."""

from __future__ import annotations

import json

import pytest

from graph.cli.main import main
from tests.support.places import ROOT

ARM = ROOT / "graphs" / "arm.yaml"
HEAD = "tickgraph: 1\n"


def graph(*arguments):
    return main([str(argument) for argument in arguments])


def test_a_file_converted_to_usd_runs_the_same_and_comes_back(tmp_path, capsys):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "arm.xml").write_text((ARM.parent / "scenes" / "arm.xml").read_text())
    (tmp_path / "arm.yaml").write_text(ARM.read_text())
    assert graph("convert", tmp_path / "arm.yaml", tmp_path / "arm.usda") == 0
    assert graph("convert", tmp_path / "arm.usda", tmp_path / "back.yaml") == 0
    reports = []
    for name in ("arm.yaml", "arm.usda", "back.yaml"):
        capsys.readouterr()
        assert graph("run", tmp_path / name, "--updates", 25, "--json") == 0
        report = json.loads(capsys.readouterr().out)
        reports.append((report["sensors"], report["physics_steps"], report["warnings"]))
    assert reports[0] == reports[1] == reports[2]
    assert reports[0][1] == 125


@pytest.mark.parametrize("command", ["check", "explain", "show"])
def test_the_commands_that_run_nothing_take_it(command, capsys):
    assert graph(command, ARM) == 0
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("scene", "line"),
    [
        ("{mjcf: none.xml}", 'scene.mjcf: there is no file "none.xml" (relative to the graph file)'),
        ("{mjcf: ../arm.xml}", 'scene.mjcf: "../arm.xml" is outside the graph file\'s folder'),
        ("{mjcf: arm.xml, keyframe: up}", "g.yaml:2:1: scene.keyframe: "),
        ("{keyframe: home}", "scene.keyframe: only an MJCF model (scene.mjcf) has any"),
        ("{mjcf: broken.xml}", "broken.xml:2:12: geom: unrecognized attribute: 'sice'"),
        ("{mjcf: arm.xml, prims: {/World/post: {type: Cube}}}", "the scene already has Xform there"),
        ("{mjcf: arm.xml, prims: {/World/Actuators/nod: {attributes: {'mjc:ctrl': on}}}}", "mjc:ctrl"),
    ],
)
def test_each_mistake_is_one_line(tmp_path, capsys, scene, line):
    folder = tmp_path / "graphs"
    folder.mkdir()
    text = (ARM.parent / "scenes" / "arm.xml").read_text()
    for place in (folder, tmp_path):
        (place / "arm.xml").write_text(text)
    (folder / "broken.xml").write_text("<mujoco>\n<worldbody><geom sice='1'/></worldbody></mujoco>")
    (folder / "g.yaml").write_text(f"{HEAD}scene: {scene}\n")
    assert graph("check", folder / "g.yaml") == 2
    told = capsys.readouterr().err
    assert line in told
    assert len(told.strip().splitlines()) == 1
    assert "Traceback" not in told
