"""The commands: ours, and those that packages declare in the entry point group `tickgraph.commands`."""

from __future__ import annotations

from graph.base import plugins
from graph.base.records import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """A subcommand: its line of help, its module, and whether it takes `--/path=value`.

    module: the one with `add_arguments(parser)` and `run(args) -> int`, imported when the command is given.
    script: whether what follows its first argument belongs to that script.
    """

    help: str
    module: str
    settings: bool = False
    script: bool = False


COMMANDS = {
    "run": Command("play a graph file and report what happened", "graph.cli.run", settings=True),
    "check": Command(
        "validate graph files without running them; explain finds more traps", "graph.cli.check", settings=True
    ),
    "exec": Command(
        "run an Isaac Sim script (Python code, with your rights) over this engine", "graph.cli.exec", True, True
    ),
    "test": Command("run *.test.yaml tests of graphs and nodes", "graph.cli.test", settings=True),
    "nodes": Command("list node types", "graph.cli.nodes"),
    "node": Command("describe one node type", "graph.cli.node"),
    "sensors": Command("list sensor configurations, or describe one with its variants", "graph.cli.sensors"),
    "new": Command("write a commented graph file to start from", "graph.cli.new"),
    "convert": Command("write a graph file in another format: yaml, json, usda", "graph.cli.convert"),
    "show": Command("draw the graphs of a file; a file without graphs is an error", "graph.cli.show"),
    "inspect": Command(
        "show one frame of a sensor: header, channels, what was hit", "graph.cli.inspect", settings=True
    ),
    "info": Command("say what a recording holds, and what was due", "graph.cli.info"),
    "export": Command("write a recording in a format of other tools", "graph.cli.export"),
    "recover": Command("rebuild the index of a recording that was not finished", "graph.cli.recover"),
    "explain": Command(
        "tell what ticks when, who consumes what, and where traps lie", "graph.cli.explain", settings=True
    ),
    "schema": Command("print the JSON Schema of graph files", "graph.cli.schema"),
    "assets": Command(
        "list what a scene, graph file or script wants from other files, and what is missing", "graph.cli.assets"
    ),
    "help": Command("list the pages of the manual, or print one", "graph.cli.help"),
    "doctor": Command("is this machine ready, and what to install if not", "graph.cli.doctor"),
    "completion": Command("print a script that completes this command in your shell", "graph.cli.completion"),
}
"""Ours; a package cannot replace one."""


def find(name: str) -> Command | None:
    """The command of a name, or None. Raises UserError for one of a package that cannot be used."""
    return COMMANDS.get(name) or plugins.load(plugins.COMMANDS, name, Command)


def every() -> dict[str, Command]:
    """Ours, then those of packages; a package that fails is left out with a warning."""
    others = {plugin.name: command for plugin, command in plugins.loaded(plugins.COMMANDS, Command)}
    return {**COMMANDS, **{name: command for name, command in others.items() if name not in COMMANDS}}
