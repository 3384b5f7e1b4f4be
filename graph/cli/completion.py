"""`graph completion`: a script that completes the command in bash, zsh or tcsh, made by the library shtab."""

from __future__ import annotations

import argparse
from importlib import import_module

from graph.base.plugins import TARGETS, names

SHELLS = ("bash", "zsh", "tcsh")

FILES = ("files", "file", "in", "out", "allow")
"""Names of arguments whose value is a path."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("shell", choices=SHELLS, help="the shell that will read the script")
    parser.epilog = 'bash: eval "$(graph completion bash)"; zsh: the same, after compinit'


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    import shtab

    whole = command_line()
    _offer_words(whole)
    print(shtab.complete(whole, shell=args.shell))
    return 0


def _offer_words(whole: argparse.ArgumentParser) -> None:
    """Gives arguments the words that they accept: only for a script, because a parser would refuse all others."""
    from graph.manual import ORDER
    from graph.node import registry
    from graph.sim.fidelity import KNOBS
    from sensors.configs.shipped import all_assets

    from .commands import every
    from .examples import examples
    from .new import KINDS

    types = [name for one in registry.all() for name in (one.short_name, one.id)]
    configs = [name for one in all_assets() for name in (one.short_name, *one.products)]
    values = {
        name: [one for one in knob.schema.get("enum", ()) if isinstance(one, str)] for name, knob in KNOBS.items()
    }
    words: dict[tuple[str, str], list[str]] = {
        ("node", "type"): types,
        ("nodes", "pattern"): types,
        ("sensors", "name"): configs,
        ("help", "topic"): [*ORDER, *every()],
        ("new", "kind"): [*KINDS, *examples()],
        ("check", "target"): names(TARGETS),
    }
    knobs = {
        "fidelity": [f"{name}={value}" for name, some in values.items() for value in some or [""]],
        "vary": [f"{name}={','.join(some)}" for name, some in values.items()],
    }
    for command, parser in _parsers(whole).items():
        for action in parser._actions:
            offered = knobs.get(action.dest) or words.get((command, action.dest), [])
            if offered:
                action.choices = list(dict.fromkeys(word for word in offered if " " not in word))


def _parsers(whole: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    [commands] = (action for action in whole._actions if isinstance(action, argparse._SubParsersAction))
    return dict(commands.choices)


def arguments() -> dict[str, list[argparse.Action]]:
    """The arguments of every command, in the order of its --help."""
    return {name: list(parser._actions) for name, parser in _parsers(command_line()).items()}


def command_line() -> argparse.ArgumentParser:
    """The whole command line as one parser: every command with its options."""
    import shtab

    from .commands import every

    whole = argparse.ArgumentParser(prog="graph")
    whole.add_argument("--version", action="store_true", help="print the version and exit")
    commands = whole.add_subparsers()
    for name, command in every().items():
        parser = commands.add_parser(name, help=command.help)
        parser.add_argument("--debug", action="store_true", help="show tracebacks")
        import_module(command.module).add_arguments(parser)
        for action in parser._actions:
            if action.dest in FILES or action.metavar in ("FILE", "DIR", "OUT", "IN"):
                action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE  # type: ignore[attr-defined]
    return whole
