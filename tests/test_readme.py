"""The README: its blocks typed in as they stand, in order, in an empty folder."""

import json
import os
import re
import subprocess
import sys

import pytest

from graph.cli.main import main
from graph.manual import page, pages
from tests.support import manual
from tests.support.places import ROOT
from tests.support.without_wing import needs_every_command

README = (ROOT / "README.md").read_text(encoding="utf-8")


OLD_NAMES = {"isaacsim.ros2.bridge": "omni.isaac.ros2_bridge", "isaacsim.core.nodes": "omni.isaac.core_nodes"}


def section(heading):
    return re.search(rf"^## {heading}\n(.*?)(?=^## |\Z)", README, re.MULTILINE | re.DOTALL)[1]


def blocks(language, text=README):
    """The fenced blocks of one language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def shown(text):
    """The lines of an output that are not empty, without the space around them."""
    return [line.strip() for line in text.splitlines() if line.strip()]


def typed(block, capsys):
    """Runs the commands of a block; what they print, on both streams."""
    for line in block.splitlines():
        assert main(manual.words(line)) == 0, line
    out, err = capsys.readouterr()
    return out + err


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder with the README's graph file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fall.yaml").write_text(*blocks("yaml"))
    return tmp_path


def test_it_is_read_in_two_minutes():
    assert len(README.splitlines()) <= 250


@pytest.mark.usefixtures("folder")
def test_the_commands_of_the_graph_file_print_what_stands_below_them(capsys):
    part = section("A graph file")
    [commands], [output] = blocks("sh", part), blocks("text", part)
    printed = shown(typed(commands, capsys))
    assert [line for line in shown(output) if line not in printed] == []


@pytest.mark.usefixtures("folder")
def test_the_drawing_is_what_graph_show_prints(capsys):
    assert main(["show", "fall.yaml", "--format", "mermaid"]) == 0
    assert capsys.readouterr().out == blocks("mermaid")[0]


def test_an_old_stage_of_isaac_sim_gives_the_warning_that_is_shown(folder, capsys):
    assert main(["convert", "fall.yaml", "robot.usda"]) == 0
    stage = (folder / "robot.usda").read_text()
    for new, old in (
        ("isaacsim.ros2.bridge", "omni.isaac.ros2_bridge"),
        ("isaacsim.core.nodes", "omni.isaac.core_nodes"),
    ):
        stage = stage.replace(f'"{new}.', f'"{old}.')
    (folder / "robot.usda").write_text(stage)
    part = section("Bring your Isaac Sim graph")
    [commands], [output] = blocks("sh", part), blocks("text", part)
    printed = " ".join(typed(commands, capsys).split())
    assert " ".join(output.split()) in printed
    assert (folder / "robot.yaml").is_file()


@pytest.mark.parametrize("block", blocks("python"), ids=["app", "node"])
def test_a_python_block_runs_beside_the_graph_file(folder, block):
    done = subprocess.run(
        [sys.executable, "-c", block],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "run_node" in block or "the scan began at 900000000 ns" in done.stdout


@needs_every_command
def test_every_other_command_is_one_that_the_command_takes():
    elsewhere = [
        *blocks("sh", section("Run it")),
        *blocks("sh", section("Gallery")),
        *re.findall(r"`(graph [^`]+)`", README),
    ]
    lines = [line for block in elsewhere for line in block.replace("\\\n", " ").splitlines()]
    commands = [line for line in lines if "graph " in line and "TOPIC" not in line and "COMMAND" not in line]
    assert len(commands) > 12
    assert [wrong for wrong in map(manual.refused, commands) if wrong] == []


def test_each_picture_is_there_beside_its_command():
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", README)
    assert len(pictures) == 8
    assert all((ROOT / path).stat().st_size < 300_000 for path in pictures)
    gallery = re.findall(r"^!\[[^\]]+\]\([^)]+\)\n\n```sh\ngraph ", section("Gallery"), re.MULTILINE)
    assert len(gallery) == 6


def test_the_figures_of_accuracy_are_those_of_the_cases():
    rows = map(manual.cells_of, re.findall(r"^\| .*doctor --stability.*$", README, re.MULTILINE))
    cases = [manual.cells_of(line) for line in page("stability").text.splitlines() if line.startswith("| ")]
    for _, result, command in rows:
        [only] = re.findall(r'"(.*)"', command)
        [case] = [cells for cells in cases if only in cells[1]]
        assert re.findall(r"[\d.e+-]+\d", result)[0] == case[3].split()[0]


def test_the_figures_of_speed_are_those_that_were_measured():
    groups = json.loads((ROOT / "tests/benchmarks/measured.json").read_text(encoding="utf8"))
    shown = re.findall(r"\| ([\d.]+) ×[^|]*\| `python tests/benchmarks/run.py (\w+)`", README)
    assert len(shown) == 2
    for value, group in shown:
        assert value in [f"{row['value']:.3g}" for row in groups[group]["rows"]]


def test_every_page_of_the_manual_is_named_by_its_title():
    listed = re.findall(r"\[([^\]]+)\]\(graph/manual/([\w-]+)\.md\)", section("More"))
    assert sorted(listed) == sorted((one.title, one.topic) for one in pages())
