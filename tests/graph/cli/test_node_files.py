"""`--nodes FILE.py`: types of a file that the user names."""

import json

import pytest

from graph.node.registry import DEFAULT

NODE = """\
from graph import Attribute, Database, node_type


@node_type(
    "{id}",
    inputs={{"value": Attribute("double", "a number", default=0.0)}},
    outputs={{"half": Attribute("double", "half of it")}},
)
def compute(db: Database) -> None:
    \"\"\"Half of a number.\"\"\"
    db.outputs.half = db.inputs.value / 2
"""
GRAPH = "tickgraph: 1\ngraphs: {{/World/G: {{evaluator: push, nodes: {{h: {{type: {id}, inputs: {{value: 3}}}}}}}}}}\n"
CASE = "tickgraph_tests: 1\ncases: {{it: {{node: {id}, inputs: {{value: 3}}, expect: {{outputs: {{half: 1.5}}}}}}}}\n"


@pytest.fixture(autouse=True)
def _own_types_leave():
    yield
    for kind in DEFAULT.loaded():
        if kind.id.startswith("mine."):
            DEFAULT.remove(kind.id)


@pytest.fixture
def write(folder):
    """Writes a node file, a graph and a test that use a type id of its own; gives the id."""

    def run(stem):
        type_id = f"mine.{stem}"
        (folder / f"{stem}.py").write_text(NODE.format(id=type_id))
        (folder / "g.yaml").write_text(GRAPH.format(id=type_id))
        (folder / "n.test.yaml").write_text(CASE.format(id=type_id))
        return type_id

    return run


def test_run_check_test_explain_show_and_node_know_the_types_of_the_file(write, graph):
    type_id = write("halver")
    assert (
        graph("check", "g.yaml", "--nodes", "halver.py").out == "g.yaml: ok, 1 graph, 1 node, 0 connections, 0 prims\n"
    )
    report = json.loads(graph("run", "g.yaml", "--updates", "3", "--json", "--nodes", "halver.py").out)
    assert report["nodes"]["/World/G/h"]["computes"] == 3
    assert graph("test", "n.test.yaml", "--nodes", "halver.py").out.endswith("1 passed, 0 failed\n")
    for command in ("explain", "show"):
        assert graph(command, "g.yaml", "--nodes", "halver.py").code == 0
    assert "declared in node_files.halver:4" in graph("node", type_id, "--nodes", "halver.py").out
    assert type_id in graph("schema", "--nodes", "halver.py").out


def test_without_the_option_no_file_runs_and_the_message_names_it(write, folder, graph):
    write("unasked")
    (folder / "unasked.py").write_text("raise SystemExit(3)")
    result = graph("check", "g.yaml")
    assert result.code == 2
    assert (
        'no node type "mine.unasked"; no node package is installed, and --nodes FILE.py brings types of your own; '
        "--skip-unknown runs the rest of the file"
    ) in result.err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", "--nodes wrong.py: it registers no node type; put @node_type above a compute function"),
        ("\ndef f(:\n", "--nodes wrong.py:2: SyntaxError: invalid syntax"),
        ("import os\nraise SystemExit('no')\n", "--nodes wrong.py:2: SystemExit: no"),
        (NODE.format(id="OnPlaybackTick.x").replace("double", "dubble"), "--nodes wrong.py:4: ValueError: "),
        (NODE.format(id="omni.graph.action.Countdown"), 'node type "omni.graph.action.Countdown" is registered twice'),
        (None, "--nodes wrong.py: there is no Python file of that name"),
    ],
)
def test_a_file_that_brings_no_types_is_one_line(text, message, write, folder, graph):
    write("other")
    if text is not None:
        (folder / "wrong.py").write_text(text)
    result = graph("check", "g.yaml", "--nodes", "wrong.py")
    assert result.code == 2
    assert message in result.err
    assert len(result.err.splitlines()) == 1


def test_a_recording_says_which_files_brought_nodes(folder, graph):
    from mcap.reader import make_reader

    (folder / "clocked.py").write_text(NODE.format(id="mine.clocked"))
    text = (
        "tickgraph: 1\ngraphs: {/World/G: {nodes: {tick: OnPlaybackTick, h: mine.clocked, clock: ROS2PublishClock}, "
        "connections: [tick.tick -> clock.execIn, h.half -> clock.timeStamp]}}\n"
    )
    (folder / "c.yaml").write_text(text)
    assert graph("run", "c.yaml", "--updates", "2", "--out", "o", "--nodes", "clocked.py").code == 0
    with (folder / "o" / "run.mcap").open("rb") as stream:
        notes = {key: value for one in make_reader(stream).iter_metadata() for key, value in one.metadata.items()}
    assert json.loads(notes["nodes"]) == ["clocked.py"]
