"""Time spent on compiling is counted once, however compilations nest, and said in one line."""

import json
import os
import subprocess
import sys
import time

from sensors.compiled.compile_time import CompileTime
from tests.support.places import ROOT


def test_nested_compilations_count_once_and_are_said_once(monkeypatch, capsys):
    """From 10 to 14 s with one inside, then from 20 to 21 s: 4 + 1 seconds of two outer compilations."""
    clock = iter([10.0, 14.0, 20.0, 21.0])
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    counted = CompileTime(lambda: 37)
    for step in (counted.start, counted.start, counted.end, counted.end, counted.start, counted.end):
        step()
    assert (counted.seconds, counted.loops) == (5.0, 2)
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("compiling 37 of the sensors' loops")


def test_a_compilation_that_runs_counts_in_the_elapsed_time_already(monkeypatch):
    """Started at 10 s, asked at 13 s, ended at 14 s, asked at 20 s."""
    clock = iter([10.0, 13.0, 14.0])
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    counted = CompileTime()
    counted.start()
    assert (counted.elapsed, counted.seconds) == (3.0, 0.0)
    counted.end()
    assert counted.elapsed == counted.seconds == 4.0


NODES = '''
import numpy as np
from graph.node import node_type
from sensors.compiled import compiled


@compiled
def twice(values):
    for at in range(len(values)):
        values[at] *= 2


@node_type("own.Twice", inputs={}, outputs={})
def compute(db):
    """Runs a loop."""
    twice(np.ones(3))
'''
GRAPH = """
tickgraph: 1
graphs:
  /G: {evaluator: push, nodes: {twice: own.Twice}}
"""


def test_the_first_run_on_a_machine_says_what_it_compiled_and_the_second_compiles_nothing(tmp_path):
    (tmp_path / "nodes_of_mine.py").write_text(NODES)
    (tmp_path / "g.yaml").write_text(GRAPH)
    command = ["-m", "graph", "run", "g.yaml", "--nodes", "nodes_of_mine.py", "--updates", "2", "--json"]
    env = {**os.environ, "TICKGRAPH_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    runs = [
        subprocess.run([sys.executable, *command], cwd=tmp_path, env=env, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    first, second = (json.loads(run.stdout)["timing_s"]["compile"] for run in runs)
    assert first > 0 == second
    assert "compiled 1 loop in " in runs[0].stderr
    assert "compil" not in runs[1].stderr


def test_where_loops_cannot_be_kept_the_run_says_why_and_what_to_do(tmp_path):
    (tmp_path / "nodes_of_mine.py").write_text(NODES)
    (tmp_path / "g.yaml").write_text(GRAPH)
    (tmp_path / "file").write_text("")
    command = ["-m", "graph", "run", "g.yaml", "--nodes", "nodes_of_mine.py", "--updates", "2"]
    env = {**os.environ, "TICKGRAPH_CACHE": str(tmp_path / "file"), "PYTHONPATH": str(ROOT)}
    run = subprocess.run([sys.executable, *command], cwd=tmp_path, env=env, capture_output=True, text=True, check=True)
    place = tmp_path / "file" / "kernels"
    assert f"each run compiles again: {place}: Not a directory; set TICKGRAPH_CACHE to a folder of" in run.stderr


def test_what_is_left_are_the_listed_forms_of_imported_modules_that_are_not_kept(tmp_path):
    """Importing a loop and compiling its one form takes one off the number."""
    code = "from pathlib import Path\nfrom sensors.compiled import kept\nkept.SHIPPED = Path('no such folder')\n"
    code += "from sensors.camera.rays import _face\nfrom sensors.compiled.signatures import number_left\n"
    code += "import json\nfrom sensors.compiled.signatures import LIST, type_of\nprint(number_left())\n"
    code += "_face.code.compile(tuple(map(type_of, json.loads(LIST.read_text())[_face.name][0])))\nprint(number_left())"
    env = {**os.environ, "TICKGRAPH_CACHE": str(tmp_path), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    before, after = map(int, done.stdout.split())
    assert before - after == 1
