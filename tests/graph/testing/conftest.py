import textwrap
from types import SimpleNamespace

import pytest

from graph.testing.cases import read_cases
from graph.testing.checking import check_cases
from graph.testing.running import run_case

GRAPH = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 4, period: 2}}
    connections: [tick.tick -> wait.execIn]
"""


@pytest.fixture
def graph_file(tmp_path):
    """small.yaml: a tick that holds a countdown of four, every second update."""
    file = tmp_path / "small.yaml"
    file.write_text(GRAPH)
    return file


@pytest.fixture
def write_tests(tmp_path):
    """Writes a test file of these lines (below `tickgraph_tests: 1`); gives its path."""

    def write(text, name="small.test.yaml"):
        file = tmp_path / name
        file.write_text("tickgraph_tests: 1\n" + textwrap.dedent(text))
        return file

    return write


@pytest.fixture
def run_tests(write_tests, monkeypatch, tmp_path):
    """Runs the cases of these lines; gives what is wrong with the file and each case's failures, as lines."""
    monkeypatch.chdir(tmp_path)

    def run(text):
        write_tests(text)
        file = read_cases("small.test.yaml")
        problems = [str(one) for one in (*file.problems, *check_cases(file.cases))]
        failures = {} if problems else {c.name: [str(one) for one in run_case(c).failures] for c in file.cases}
        return SimpleNamespace(problems=problems, failures=failures)

    return run
