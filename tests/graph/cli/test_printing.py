import ast
import json
import logging

import pytest

from graph.base.shorten import printable
from graph.cli.main import main
from graph.cli.printing import say_json
from graph.cli.safe_log import SafeFormatter
from tests.support.places import ROOT
from tests.support.without_wing import needs_every_command

TITLE = "\x1b]0;owned\x07"
"""What sets the title of a terminal's window."""

ALLOWED = {
    "printing.py": ("print", "console.print"),
    "sweep.py": ("runs.console.print",),
    "command.py": ("console.print",),
    "completion.py": ("print",),
    "help.py": ("print", "Console().print"),
}
"""Who may print: the writer, the tables of a trade and a campaign (their cells are made printable), a script and
pages without any part of a file.
"""


@needs_every_command
def test_nothing_in_the_commands_prints_but_the_one_writer():
    found = {}
    for file in (*(ROOT / "graph/cli").glob("*.py"), *(ROOT / "wings").rglob("*.py")):
        for call in ast.walk(ast.parse(file.read_text())):
            name = ast.unparse(call.func) if isinstance(call, ast.Call) else ""
            if name == "print" or name.endswith((".print", ".stdout.write", ".stderr.write")):
                found.setdefault(file.name, set()).add(name)
    assert {name: tuple(sorted(calls, reverse=True)) for name, calls in found.items()} == ALLOWED


def test_a_line_is_printable_whatever_is_in_it():
    assert printable("a\nb\tc\x1b[2J\x9b1m\u202eß\ud800\x7f") == "a b c\\u001b[2J\\u009b1m\\u202eß\\ud800\\u007f"


def test_json_on_the_terminal_escapes_what_is_not_printable_and_says_the_same(capsys):
    value = {TITLE: ["\x9b1m", "\x7f", "ß", "\ud800"]}
    say_json(value)
    out = capsys.readouterr().out
    assert json.loads(out) == value
    assert out.replace("\n", "").isprintable()


def test_the_log_is_one_printable_line_a_record():
    record = logging.LogRecord("tickgraph", logging.INFO, "", 0, f"{TITLE}\nnext", None, None)
    assert SafeFormatter().format(record) == "\\u001b]0;owned\\u0007 next"


HOSTILE = {
    "tickgraph": 1,
    "scene": {"prims": {"/World/Ball": {"type": "Sphere", "rigid_body": True}}},
    "graphs": {
        "/World/G": {
            "nodes": {
                "tick": "OnPlaybackTick",
                "say": {"type": "omni.graph.ui_nodes.PrintText", "inputs": {"text": TITLE}},
                "pose": {"type": "IsaacComputeOdometry", "inputs": {"chassisPrim": "/World/Ball"}},
                "send": {"type": "ROS2PublishClock", "inputs": {"topicName": "clock", "nodeNamespace": TITLE}},
            },
            "connections": ["tick.tick -> say.execIn", "tick.tick -> pose.execIn"],
        }
    },
}


def test_what_a_node_prints_is_one_printable_line(tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(logging.getLogger("tickgraph"), "handlers", [])  # as in a process of its own
    nodes = {"tick": "OnPlaybackTick", "say": HOSTILE["graphs"]["/World/G"]["nodes"]["say"]}
    graphs = {"/World/G": {"nodes": nodes, "connections": ["tick.tick -> say.execIn"]}}
    (tmp_path / "g.yaml").write_text(json.dumps({"tickgraph": 1, "graphs": graphs}))
    assert main(["run", str(tmp_path / "g.yaml"), "--updates", "1"]) == 0
    assert "\\u001b]0;owned\\u0007\n" in capfd.readouterr().err


@pytest.mark.parametrize("command", ["run --updates 2", "run --json --updates 2", "check", "show", "explain", "test"])
def test_no_command_sends_a_files_control_characters_to_the_terminal(tmp_path, capfd, command):
    file = tmp_path / ("g.test.yaml" if command == "test" else "g.yaml")
    document = HOSTILE
    if command == "test":
        case = {"node": "Countdown", "inputs": {TITLE: 1}, "updates": 1}
        document = {"tickgraph_tests": 1, "cases": {f"one{TITLE}": case}}
    file.write_text(json.dumps(document))
    first, *rest = command.split()
    main([first, str(file), *rest])
    told = capfd.readouterr()
    assert (told.out + told.err).replace("\n", "").isprintable()
