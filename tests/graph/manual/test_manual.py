"""The pages of the manual: their examples typed in as they stand, their names and figures as the code has them."""

import importlib
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from ruamel.yaml import YAML

from graph.base.limits import LIMITS
from graph.cli.main import main
from graph.manual import ORDER, page, pages
from graph.sim.fidelity import KNOBS, Fidelity
from graph.testing import run_graph
from tests.support import figures, manual
from tests.support.places import ROOT
from tests.support.without_wing import needs_every_command, needs_wing

MANUAL = "".join(one.text for one in pages())


def blocks(language, topic=None):
    """The fenced blocks of one language, in order: of a page, or of all."""
    text = page(topic).text if topic else MANUAL
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


PYTHON = blocks("python")
NODE, EVERY_NTH = (block for block in PYTHON if "@node_type" in block)
"""The nodes that the page of nodes keeps in halve.py and every_nth.py."""


def test_every_file_of_the_manual_is_in_its_order():
    assert sorted(ORDER) == sorted(path.stem for path in (ROOT / "graph/manual").glob("*.md"))


@pytest.mark.parametrize("topic", ORDER)
def test_a_page_begins_with_its_title_and_a_line_of_what_it_answers(topic):
    one = page(topic)
    assert one.text.startswith(f"# {one.title}\n\n{one.line}\n\n")
    assert 20 < len(one.line) <= 120
    assert one.line.endswith(".")


@needs_every_command
def test_what_commands_print_is_up_to_date_in_the_pages(capsys):
    assert manual.main(["--check"]) == 0, capsys.readouterr().out


@needs_every_command
def test_a_part_that_is_not_up_to_date_is_found_and_written_again(tmp_path, monkeypatch, capsys):
    for path in manual.FOLDER.glob("*.md"):
        text = path.read_text(encoding="utf8")
        (tmp_path / path.name).write_text(
            text.replace("| `lidar.bins` | 10,000", "| `lidar.bins` | 1"), encoding="utf8"
        )
    monkeypatch.setattr(manual, "FOLDER", tmp_path)
    assert manual.main(["--check"]) == 1
    assert capsys.readouterr().out == f"not up to date: robustness; run: {manual.COMMAND}\n"
    assert manual.main([]) == 0
    assert (tmp_path / "robustness.md").read_text(encoding="utf8") == page("robustness").text


@needs_every_command
def test_figures_measured_again_are_written_into_the_page_and_readme(tmp_path, monkeypatch):
    for path in (*manual.FOLDER.glob("*.md"), manual.README):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf8"), encoding="utf8")
    groups = json.loads(figures.MEASURED.read_text(encoding="utf8"))
    row = next(row for row in groups["lidar"]["rows"] if row["what"].endswith("10 Hz, point cloud only"))
    row["value"] = 7.3456
    (tmp_path / "measured.json").write_text(json.dumps(groups), encoding="utf8")
    monkeypatch.setattr(manual, "FOLDER", tmp_path)
    monkeypatch.setattr(manual, "README", tmp_path / "README.md")
    monkeypatch.setattr(figures, "MEASURED", tmp_path / "measured.json")
    assert manual.main(["--check"]) == 1
    assert manual.main([]) == 0
    assert "point cloud only | 7.35 × | at most 1.25 (missed) |" in (tmp_path / "performance.md").read_text()
    assert "| 7.35 × its bare ray casts |" in (tmp_path / "README.md").read_text()
    assert manual.main(["--check"]) == 0


def test_a_run_of_some_benchmarks_keeps_the_figures_of_the_others(tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(ROOT / "tests" / "benchmarks")
    run, record, measure = map(importlib.import_module, ("run", "record", "measure"))
    path = tmp_path / "measured.json"
    monkeypatch.setattr(record, "MEASURED", path)
    row = measure.Row("a case", 0.5, 1.0, "s")
    run.keep("first", "First: of two", [row], ())
    run.keep("second", "Second", [measure.Row("a lead", measure.Median([2.0, 4.0, 9.0]), 3.0, best="most")], ())
    before = json.loads(path.read_text())
    run.keep("first", "First", [measure.Row("another", 2.0)], ())
    run.keep("second", "Second", [], ("a_module_that_nobody_has",))
    after = json.loads(path.read_text())
    assert (
        "second: the figures of before are kept, as a_module_that_nobody_has is not installed"
        in capsys.readouterr().err
    )
    assert after["second"] == before["second"]
    assert before["first"]["rows"] == [{"what": "a case", "value": 0.5, "unit": "s", "bound": 1.0, "best": "least"}]
    assert [row["what"] for row in after["first"]["rows"]] == ["another"]
    assert after["first"]["machine"] == record.machine()
    assert after["second"]["rows"][0]["value"] == 4.0


def command_lines(text):
    """The commands `graph ...` in the indented blocks of a page, with lines that go on joined."""
    indented = "\n".join(line[4:] for line in text.splitlines() if line.startswith("    "))
    return re.findall(r"^graph .*$", indented.replace("\\\n", " "), re.MULTILINE)


@needs_every_command
@pytest.mark.parametrize("topic", ORDER)
def test_the_commands_of_a_page_are_ones_that_the_command_takes(topic):
    assert [wrong for wrong in map(manual.refused, command_lines(page(topic).text)) if wrong] == []


def test_pages_begin_with_something_to_type():
    """Within the first screen."""
    lines = {topic: page(topic).text.splitlines()[:12] for topic in ORDER}
    assert [topic for topic, top in lines.items() if not any(line.startswith(("    ", "```")) for line in top)] == []


def test_commands_fit_a_terminal_of_80_columns():
    """With the margins of a page; the value of an environment variable cannot be broken."""
    lines = [(topic, line[4:]) for topic in ORDER for line in page(topic).text.splitlines() if line.startswith("    ")]
    fenced = [line for topic in ORDER for block in FENCED.findall(page(topic).text) for line in block.splitlines()]
    long = [pair for pair in lines if len(pair[1]) > 78 and f"    {pair[1]}" not in fenced]
    assert [pair for pair in long if not pair[1].startswith("export ")] == []


FENCED = re.compile(r"^```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LONGEST_CELL = 25
GENERATED = re.compile(r"<!-- ([\w ]+) -->\n.*?<!-- end \1 -->\n", re.DOTALL)


@pytest.mark.parametrize("topic", ORDER)
def test_the_cells_of_tables_are_short(topic):
    """What needs more words stands in a paragraph below the table."""
    rows = re.findall(r"^\|.*\|$", GENERATED.sub("", page(topic).text), re.MULTILINE)
    long = [cell for row in rows for cell in manual.cells_of(row) if len(cell.split()) > LONGEST_CELL]
    assert long == []
    assert max((len(manual.cells_of(row)) for row in rows), default=0) <= 5


@pytest.mark.parametrize("block", [block for block in blocks("yaml") if re.match("scene:|clock:|fidelity:", block)])
def test_a_part_of_a_graph_file_checks(tmp_path, block):
    (tmp_path / "part.yaml").write_text(f"tickgraph: 1\n{block}")
    assert main(["check", str(tmp_path / "part.yaml")]) == 0


def own_wing(block):
    """The mark of a block that imports from a wing."""
    return [needs_wing(wing) for wing in re.findall(r"^from wings\.(\w+)", block, re.MULTILINE)]


@pytest.mark.parametrize(
    "block", [pytest.param(block, id=block.splitlines()[0], marks=own_wing(block)) for block in PYTHON]
)
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
    file = tmp_path / "first.yaml"
    file.write_text(blocks("yaml", "graph-files")[0])
    assert main(["check", str(file)]) == 0
    assert main(["run", str(file), "--updates", "30", "--strict"]) == 0


def test_the_graph_file_is_what_graph_new_sensors_writes(tmp_path):
    assert main(["new", "sensors", str(tmp_path / "first.yaml")]) == 0
    read = YAML(typ="safe").load
    assert read(tmp_path / "first.yaml") == read(blocks("yaml", "graph-files")[0])


def test_the_test_file_passes(tmp_path, capsys):
    file = tmp_path / "counts.test.yaml"
    file.write_text(blocks("yaml", "nodes-and-tests")[0])
    assert main(["test", str(file)]) == 0
    assert "1 passed, 0 failed" in capsys.readouterr().out


@pytest.fixture
def robot(tmp_path, monkeypatch):
    """A folder with the robot of the tutorial, without sensors, and its square."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "diffdrive", "robot.yaml"]) == 0
    (tmp_path / "square.yaml").write_text(blocks("yaml", "robot")[0])
    return tmp_path / "robot.yaml"


def test_the_robot_drives_a_square(robot):
    """Four sides of a metre and four turns of 90 degrees lead back to the start, as the page says how closely."""
    trace = run_graph(robot, updates=900, play=["square.yaml"])
    assert np.hypot(*trace.value("odometry.position")[:2]) < 0.03
    assert np.degrees(2 * abs(trace.value("odometry.orientation")[2])) < 2  # z of a small turn is half of it
    path = np.array(trace.values("odometry.position"))
    assert np.abs(np.ptp(path[:, :2], axis=0) - 1).max() < 0.03


def test_the_robot_takes_the_sensors_of_the_tutorial(robot):
    text = robot.read_text()
    for key, part in zip(("  prims:", "    nodes:", "    connections:"), blocks("yaml", "robot")[1:], strict=True):
        assert text.count(f"\n{key}\n") == 1
        text = text.replace(f"\n{key}\n", f"\n{key}\n{part}")
    robot.write_text(text)
    assert main(["check", "robot.yaml"]) == 0
    assert main(["run", "robot.yaml", "--play", "square.yaml", "--updates", "60", "--out", "out", "--strict"]) == 0
    report = json.loads((robot.parent / "out/report.json").read_text())
    assert {path.rpartition("/")[2]: one["frames"] for path, one in report["sensors"].items()} == {
        "Lidar": 10,
        "Radar": 10,
        "Camera": 15,
    }
    assert report["warnings"] == []


def test_the_node_with_memory_passes_on_every_third_trigger_and_refuses_a_count_of_0(tmp_path):
    file = tmp_path / "every_nth.py"
    file.write_text(EVERY_NTH)
    case = (
        "  {name}:\n    node: example.EveryNth\n    inputs: {{n: {n}}}\n    pulses: {{execIn: [0..8]}}\n"
        "    updates: 9\n"
    )
    (tmp_path / "nth.test.yaml").write_text(
        "tickgraph_tests: 1\ncases:\n"
        + case.format(name="third", n=3)
        + "    expect: {fired: {execOut: [2, 5, 8]}}\n"
        + case.format(name="none", n=0)
        + "    expect: {error: {message: give it 1 or more, exit: 1, update: 0}}\n"
    )
    assert main(["test", str(tmp_path / "nth.test.yaml"), "--nodes", str(file)]) == 0


KNOB = re.compile(r"(?<![\w./])((?:physics|lidar|radar|camera|mesh)\.[a-z_0-9]+|(?:fabric|tlas)(?==))(?:=([^\s,]+))?")
"""A fidelity knob, and its value where one is given: `lidar.motion=frozen`, `mesh.tolerance`."""


@needs_every_command
def test_every_knob_that_is_named_exists_and_takes_the_value_that_stands_there():
    from wings.trade.metrics import METRICS

    found = [match for code in re.findall(r"`([^`\n]+)`", MANUAL) for match in KNOB.findall(code)]
    assert {"lidar.motion", "lidar.subrays", "mesh.tolerance", "fabric", "tlas"} <= {name for name, _ in found}
    for name, value in found:
        if name in LIMITS.keys() | METRICS.keys():  # they share the knobs' words
            continue
        if value or KNOBS[name].default is not None:
            Fidelity.from_mapping({name: value or KNOBS[name].default})


def test_the_defaults_in_brackets_are_those_of_the_knobs():
    """As in "`lidar.bins` (8)"."""
    found = re.findall(r"`([a-z]+\.[a-z]+)` \((\d+)\)", MANUAL)
    assert found
    assert {name: KNOBS[name].default for name, _ in found} == {name: int(value) for name, value in found}
