"""`graph completion`: a script that completes the command in bash, zsh or tcsh, made by the library shtab."""

from __future__ import annotations

import argparse
from importlib import import_module

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

    print(shtab.complete(command_line(), shell=args.shell))
    return 0


def arguments() -> dict[str, list[argparse.Action]]:
    """The arguments of every command, in the order of its --help."""
    [commands] = (action for action in command_line()._actions if isinstance(action, argparse._SubParsersAction))
    return {name: list(parser._actions) for name, parser in commands.choices.items()}


def command_line() -> argparse.ArgumentParser:
    """The whole command line as one parser: every command with its options."""
    import shtab

    from .main import COMMANDS

    whole = argparse.ArgumentParser(prog="graph")
    whole.add_argument("--version", action="store_true", help="print the version and exit")
    commands = whole.add_subparsers()
    for name, command in COMMANDS.items():
        parser = commands.add_parser(name, help=command.help)
        parser.add_argument("--debug", action="store_true", help="show tracebacks")
        import_module(f"graph.cli.{command.module}").add_arguments(parser)
        for action in parser._actions:
            if action.dest in FILES or action.metavar in ("FILE", "DIR", "OUT", "IN"):
                action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE  # type: ignore[attr-defined]
    return whole
