"""What other packages declare: found where it is wanted, and left out in one line where it is broken."""

import os
import subprocess
import sys

import pytest

from tests.support.places import ROOT

PARTS = """\
import sys
from graph.cli.commands import Command
from graph.recording.exporting import Format
from graph.recording.transports.transport import Kind
GREET = Command("greet somebody", "parts")
WIRE = Kind("parts", port=1)
TEXT = "not a command"
class Names:
    def add(self, run, topics, out, *, world, number): (out / "names.txt").write_text(topics[0]); return ["wrote names"]
    def finish(self, out): pass
NAMES = Format("names of topics", lambda type_name: True, Names)
class Wire:
    place = "the wire"
    def __init__(self, target): self.sent = 0
    def advertise(self, topic): pass
    def matched(self, topic): return True
    def send(self, message): self.sent += 1
    def subscribe(self, topic, receive): pass
    def flush(self, seconds): pass
    def close(self): pass
    def notes(self): return [("wire", f"{self.sent} sent")]
open_transport = Wire
def add_arguments(parser): parser.add_argument("name")
def run(args): print("hello", args.name); return 0
"""
TABLE = """\
[tickgraph.commands]
greet = parts:GREET
lost = no_such_module:COMMAND
text = parts:TEXT
run = parts:GREET
[tickgraph.exports]
names = parts:NAMES
[tickgraph.transports]
wire = parts:WIRE
lost = no_such_module
"""


@pytest.fixture
def command(tmp_path):
    """The command `graph` beside a package that declares plug-ins, two of them broken."""
    (tmp_path / "parts.py").write_text(PARTS)
    info = tmp_path / "acme-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(TABLE)
    path = os.pathsep.join([str(tmp_path), str(ROOT)])

    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "graph", *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": path},
        )

    return run


def test_a_package_adds_a_command(command):
    assert (command("greet", "Ada").stdout, command("greet", "--help").returncode) == ("hello Ada\n", 0)


def test_the_help_lists_it_and_broken_ones_are_a_warning_each(command):
    done = command("--help")
    assert done.returncode == 0
    assert "\n  greet       greet somebody\n" in done.stdout
    assert "\n  run         play a graph file" in done.stdout
    lost, text = done.stderr.splitlines()
    assert lost == (
        "warning command-package: lost (no_such_module:COMMAND): ModuleNotFoundError: No module named "
        "'no_such_module'; the package is left out, repair or uninstall it"
    )
    assert "text (parts:TEXT): TypeError: it is of the class str, not a Command" in text


def test_a_broken_command_is_one_line_where_it_is_called(command):
    done = command("lost")
    assert (done.returncode, done.stderr) == (
        2,
        "graph: the command lost (no_such_module:COMMAND) cannot be used: ModuleNotFoundError: No module named "
        "'no_such_module'\n",
    )


def test_a_package_adds_a_transport_and_a_format(command, tmp_path):
    nodes = "{time: IsaacReadSimulationTime, tick: OnPlaybackTick, clock: ROS2PublishClock}"
    links = "[tick.tick -> clock.execIn, time.simulationTime -> clock.timeStamp]"
    (tmp_path / "g.yaml").write_text(f"tickgraph: 1\ngraphs: {{/G: {{nodes: {nodes}, connections: {links}}}}}\n")
    done = command("run", "g.yaml", "--updates", "3", "--live", "wire", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "live wire: the wire" in done.stderr + done.stdout
    assert "warning wire: wire: 3 sent" in done.stderr + done.stdout
    done = command("export", "out", "--format", "names", "--out", "names")
    assert (done.stdout, (tmp_path / "names/names.txt").read_text()) == ("wrote names\n", "/clock")
    assert "names: names of topics" in command("export", "--help").stdout


def test_a_transport_that_is_broken_or_unknown_is_one_line(command, tmp_path):
    (tmp_path / "g.yaml").write_text("tickgraph: 1\n")
    lost, none = (command("run", "g.yaml", "--live", name) for name in ("lost", "wirre"))
    assert "graph: --live lost: the transport lost (no_such_module) cannot be used: ModuleNotFound" in lost.stderr
    assert none.stderr == "graph: --live wirre: there is no transport 'wirre'; did you mean \"wire\"?\n"
    assert [lost.stderr.count("\n"), lost.returncode, none.returncode] == [1, 2, 2]
