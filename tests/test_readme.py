"""The README's examples, typed in as they stand."""

import os
import re
import subprocess
import sys

import pytest

from graph.base.limits import LIMITS
from graph.cli.main import COMMANDS, main
from graph.sim.fidelity import KNOBS, Fidelity
from tests.support.places import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    """The fenced blocks of one language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


PYTHON = blocks("python")
[NODE] = [block for block in PYTHON if "@node_type" in block]
"""The node that the README keeps in halve.py."""


@pytest.mark.parametrize("block", PYTHON, ids=[block.splitlines()[0] for block in PYTHON])
def test_every_python_block_runs_by_itself_beside_the_file_that_it_names(tmp_path, block):
    (tmp_path / "halve.py").write_text(NODE)
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-c", block],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    if "gmo.timestampNs" in block:
        assert "returns at 900000000 ns" in done.stdout


def test_the_graph_file_checks_and_runs(tmp_path):
    graph, _ = blocks("yaml")
    file = tmp_path / "first.yaml"
    file.write_text(graph)
    assert main(["check", str(file)]) == 0
    assert main(["run", str(file), "--updates", "30", "--strict"]) == 0


def test_the_test_file_passes(tmp_path, capsys):
    _, tests = blocks("yaml")
    file = tmp_path / "counts.test.yaml"
    file.write_text(tests)
    assert main(["test", str(file)]) == 0
    assert "1 passed, 0 failed" in capsys.readouterr().out


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_its_line(command):
    assert f"`graph {command}" in README


KNOB = re.compile(r"(?<![\w./])((?:physics|lidar|radar|camera|mesh)\.[a-z_]+|(?:fabric|tlas)(?==))(?:=([^\s,]+))?")
"""A fidelity knob, and its value where one is given: `lidar.motion=frozen`, `mesh.tolerance`."""


def test_every_knob_that_is_named_exists_and_takes_the_value_that_stands_there():
    found = [match for code in re.findall(r"`([^`\n]+)`", README) for match in KNOB.findall(code)]
    assert {"lidar.motion", "lidar.subrays", "mesh.tolerance", "fabric", "tlas"} <= {name for name, _ in found}
    for name, value in found:
        if value or name not in LIMITS:  # those of the table of limits share the knobs' words
            Fidelity.from_mapping({name: value or KNOBS[name].default})


def test_the_defaults_in_brackets_are_those_of_the_knobs():
    """As in "`lidar.bins` (8)"."""
    found = re.findall(r"`([a-z]+\.[a-z]+)` \((\d+)\)", README)
    assert found
    assert {name: KNOBS[name].default for name, _ in found} == {name: int(value) for name, value in found}
