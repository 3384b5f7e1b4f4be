"""`graph check --fix`: safe changes to the text of a graph file; every other byte stays."""

import json
import re

import pytest

from graph.cli.main import main
from tests.wings.portability.test_rules import PLANTED, written
from wings.portability.fixing import DROP, changed_text
from wings.portability.rules import RULES

FILE = """# A comment at the top.
tickgraph: 1
scene:
  prims:
    # The lidar.
    /World/Lidar: {type: OmniLidar, config: Example_Rotary, attributes: {"omni:sensor:tickRate": 5}} # on the mast
clock: {physics_hz: 60, loop_hz: 24}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud:
        type: ROS2RtxLidarHelper
        inputs:
          type: point_cloud
          fullScan: true # as in older files
          topicName: points
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""
FIXED = (
    FILE.replace('tickRate": 5', 'tickRate": 10')
    .replace("          fullScan: true # as in older files\n", "")
    .replace("tickgraph: 1\n", 'tickgraph: 1\nsettings: {"/persistent/simulation/minFrameRate": 0}\n')
)


def test_safe_fixes_change_their_values_and_nothing_else(tmp_path, capsys):
    file = tmp_path / "graph.yaml"
    file.write_text(FILE)
    assert main(["check", str(file), "--target", "isaacsim-6.0", "--fix"]) == 0
    assert file.read_text() == FIXED
    lines = capsys.readouterr().err.splitlines()
    assert [re.sub(".*fixed ", "", line) for line in lines] == [
        "lidar-partial-scan: scene.prims./World/Lidar.attributes.omni:sensor:tickRate = 10",
        "full-scan-deprecated: graphs./World/G.nodes.cloud.inputs.fullScan removed",
        "catch-up-cap: settings./persistent/simulation/minFrameRate = 0",
    ]


def test_a_second_fix_changes_nothing(tmp_path, capsys):
    file = tmp_path / "graph.yaml"
    file.write_text(FIXED)
    assert main(["check", str(file), "--target", "isaacsim-6.0", "--fix"]) == 0
    assert file.read_text() == FIXED
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("code", [code for code, rule in RULES.items() if rule.fixable])
def test_a_fixable_finding_is_gone_after_the_fix(tmp_path, capsys, code):
    parts, _ = PLANTED[code]
    if "usd" in parts:
        pytest.skip("what a USD scene says is not changed")
    file = written(tmp_path, **parts)
    assert main(["check", str(file), "--target", RULES[code].targets[0], "--fix", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["files"][0]["warnings"]
    assert code not in {one["code"] for one in found}


@pytest.mark.parametrize(
    ("text", "key", "value", "after"),
    [
        ("a: 1\n", ("b",), 2, "a: 1\nb: 2\n"),
        ("a: {}\n", ("a", "x"), True, 'a: {"x": true}\n'),
        ("a: {b: 1}\n", ("a", "c", "d"), 2, 'a: {b: 1, "c": {"d": 2}}\n'),
        ("a:\n  b: 1 # one\n  c: 2\n", ("a", "b"), 5, "a:\n  b: 5 # one\n  c: 2\n"),
        ("a:\n  b: 1\n  c: 2\n", ("a", "b"), DROP, "a:\n  c: 2\n"),
        ("a: {b: 1, c: 2}\n", ("a", "c"), DROP, "a: {b: 1}\n"),
        ("a: {b: 1, c: 2}\n", ("a", "b"), DROP, "a: {c: 2}\n"),
        ("a: short\n", ("a", "b"), 1, "a: short\n"),
        ("a: 1\n", ("b",), DROP, "a: 1\n"),
    ],
)
def test_one_key_of_a_text_is_changed(text, key, value, after):
    assert changed_text(text, key, value) == after


def test_fix_needs_a_target_and_a_text_that_it_can_change(tmp_path, capsys):
    file = tmp_path / "graph.yaml"
    file.write_text(FILE)
    assert main(["check", str(file), "--fix"]) == 2
    assert "--target isaacsim-6.0" in capsys.readouterr().err


def test_nothing_is_written_through_a_link(tmp_path):
    (tmp_path / "real.yaml").write_text(FILE)
    link = tmp_path / "graph.yaml"
    link.symlink_to(tmp_path / "real.yaml")
    assert main(["check", str(link), "--target", "isaacsim-6.0", "--fix"]) == 2
    assert (tmp_path / "real.yaml").read_text() == FILE
