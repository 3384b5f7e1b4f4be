"""`graph check SCRIPT.py`: what `graph exec` cannot run, by the syntax tree alone."""

import ast
import re
from pathlib import Path

import pytest

from graph.cli.main import main
from graph.isaac.runnable import lacks
from graph.isaac.syntax import read_script

TESTS = Path(__file__).parents[3] / "tests"


@pytest.fixture
def checked(tmp_path, capsys):
    """Checks a script; gives the exit code and the lines, without the file's name."""

    def check(text):
        file = tmp_path / "script.py"
        file.write_text(text)
        code = main(["check", str(file)])
        return code, capsys.readouterr().err.replace(f"{file}:", "").splitlines()

    return check


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("import isaacsim.core.nosuch\n", '1:1: TickGraph does not have the module isaacsim.core.nosuch; did you mean'),
        ("import carb\nfrom isaacsim.core.apy import World\n",
         '2:1: TickGraph does not have the module isaacsim.core.apy; did you mean "isaacsim.core.api"?'),
        ("from isaacsim.core.api import Worlds\n",
         '1:1: TickGraph has no isaacsim.core.api.Worlds; did you mean "World"?'),
        ("import omni.timeline\nomni.timeline.get_timeline_interfac()\n",
         '2:1: TickGraph has no omni.timeline.get_timeline_interfac; did you mean "get_timeline_interface"?'),
        ("import omni.replicator.core as rep\nwith rep.randomizer.instantiate():\n    pass\n",
         "2:6: omni.replicator.core.randomizer.instantiate: this randomizer is not here; "),
        ("import omni.replicator.core as rep\nrep.create.cube()\nrep.physics.rigid_body()\n",
         "3:1: omni.replicator.core.physics.rigid_body: "),
        ("from isaacsim.sensors.camera import CameraView\n\nview = CameraView()\n",
         "3:8: isaacsim.sensors.camera.CameraView: use isaacsim.sensors.experimental.rtx"),
    ],
)  # fmt: skip
def test_what_exec_cannot_run_is_told_with_its_place(checked, text, line):
    code, lines = checked(text)
    assert code == 2
    assert len(lines) == 1
    assert lines[0].startswith(line)


def test_what_a_run_may_not_come_to_is_a_warning(checked):
    code, [line] = checked("def later():\n    import isaacsim.core.nosuch\n")
    assert code == 0
    assert line.startswith("warning script-name-missing: 2:5: TickGraph does not have the module isaacsim.core.nosuch")


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    import isaacsim.core.nosuch\nexcept ImportError:\n    pass\n",
        "from isaacsim.sensors.camera import CameraView\n",  # refused only when it is used
        "from isaacsim.core.experimental.utils import stage\ndef f(stage):\n    stage.GetPrimAtPath('/')\n",
        "import numpy.nosuch\n",  # not of Isaac Sim
        "from isaacsim.core.utils.nucleus import get_assets_root_path\n",  # an old name, which stands for the new one
        "import omni.timeline\nprint(omni.usd.get_context())\n",
    ],
)
def test_what_exec_runs_is_not_told(checked, text):
    assert checked(text) == (0, [])


def test_scripts_of_the_tests_that_exec_runs_lack_nothing(tmp_path):
    """Texts that make an application, in the tests that run them to a good end (those that refuse are elsewhere)."""
    seen, told = 0, []
    for name in ("test_scripts.py", "test_mirror.py", "test_robots_and_sensors.py", "test_loops.py"):
        for node in ast.walk(ast.parse((TESTS / "graph/isaac" / name).read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\nimport omni" in node.value:
                file = tmp_path / "one.py"
                file.write_text(re.sub(r"\A\s*\n", "", node.value))
                try:
                    script = read_script(file)
                except Exception:  # a part of a text
                    continue
                seen += 1
                told += [(name, node.lineno, one.problem.message) for one in lacks(script)]
    assert seen > 10
    assert told == []
