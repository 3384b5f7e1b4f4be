"""The command `graph`: finds the subcommand, passes it its options, turns errors into lines and exit codes.

Exit codes: 0 done, 1 the run failed, 2 the user's input is wrong, 130 interrupted. Only the module of the
given subcommand is imported (`commands.py`). `args.settings`
holds the `--/path=value` options, `args.debug` whether tracebacks are shown.
"""

from __future__ import annotations

import argparse
import atexit
import errno
import gc
import os
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from typing import Any, NoReturn

from graph.base.errors import RunError, UserError
from graph.base.suggest import did_you_mean

from .commands import COMMANDS, Command, every, find
from .printing import EXIT_INTERRUPTED, problem_line, say, tell

DONE, FAILED, WRONG_INPUT = 0, 1, 2


@atexit.register
def _leave_memory_to_the_system() -> None:
    """Skips Python's search for cycles among all objects at exit, which takes a tenth of a short command's time.

    Not with Open3D, which prints complaints at exit about objects that were not freed.
    """
    if "open3d" not in sys.modules:
        gc.freeze()


_NUMBERS = {"int": "whole number", "float": "number"}
_NO_NUMBER = re.compile(r"invalid (int|float) value: ('.*')")


class _WrongUsage(Exception):  # noqa: N818  (a signal of this module, caught in it)
    """The command line itself is wrong."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        message = _NO_NUMBER.sub(lambda found: f"{found[2]} is not a {_NUMBERS[found[1]]}", message)
        raise _WrongUsage(f"{self.prog}: {message}; see {self.prog} --help")

    def own_arguments(self, arguments: Sequence[str]) -> int:
        """The number of this command's own arguments: its options, and the script, the first one without a dash."""
        valued = {
            option
            for action in self._actions
            if action.nargs is None and action.const is None
            for option in action.option_strings
        }
        skip = False
        for index, argument in enumerate(arguments):
            if not argument.startswith("-") and not skip:
                return index + 1
            skip = argument in valued and not skip
        return len(arguments)

    def refuse_unknown_options(self, arguments: Sequence[str]) -> None:
        """Raises _WrongUsage, with the nearest option, for an option that this parser does not have.

        argparse alone would take the value after it as a positional argument and complain about others.
        """
        known = [option for action in self._actions for option in action.option_strings if option.startswith("--")]
        for argument in _options(arguments):
            option = argument.partition("=")[0]
            if option.startswith("--") and len(option) > 2 and not any(one.startswith(option) for one in known):
                self.error(f'there is no option "{option}"{did_you_mean(option, known).rstrip("?")}')


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command line `argv` (default: this process's) and returns its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a character that the terminal cannot show is printed as an escape
            stream.reconfigure(errors="backslashreplace")
    debug = "--debug" in _options(arguments)
    try:
        code = _dispatch(arguments, debug)
        sys.stdout.flush()
        return code
    except SystemExit as left:  # argparse has printed a --help
        return int(left.code or DONE)
    except _WrongUsage as wrong:
        _complain([str(wrong)])
        return WRONG_INPUT
    except UserError as error:
        _trace(debug)
        _complain(map(problem_line, error.problems))
        return WRONG_INPUT
    except RunError as error:
        _trace(debug)
        _complain([f"graph: {error}"])
        return FAILED
    except KeyboardInterrupt:
        _trace(debug)
        _complain(["graph: interrupted"])
        return EXIT_INTERRUPTED
    except BrokenPipeError:  # the reader (`| head`) has exited
        _drop_output()
        return FAILED
    except ImportError as error:
        _trace(debug)
        _complain([f"graph: a library cannot be loaded: {error}; graph doctor says what to install"])
        return FAILED
    except OSError as error:
        _trace(debug)
        if error.errno == errno.ENOSPC:
            _drop_output()
        where = f"{error.filename}: " if error.filename else ""
        _complain([f"graph: {where}{error.strerror or error}"])
        return FAILED
    except MemoryError:
        _trace(debug)
        _complain(["graph: out of memory"])
        return FAILED
    except Exception as error:
        _trace(debug)
        if isinstance(error, RuntimeError) and str(error).startswith("Symlink loop"):  # of pathlib before Python 3.13
            _complain([f"graph: {error}: its links lead to themselves; name a file or folder that is there"])
            return WRONG_INPUT
        if type(error).__module__ == "pxr.Tf":  # of a damaged scene, in an unexpected place
            from graph.sim.scene.diagnostics import reason_of

            _complain([f"graph: USD cannot make sense of the scene: {reason_of(error)}; repair its files"])
            return FAILED
        advice = "" if debug else "; run it again with --debug for the traceback, and report it"
        _complain([f"graph: internal error: {type(error).__name__}: {error}{advice}"])
        return FAILED


def leave(code: int) -> int:
    """The exit code of the process; after a live run it ends here, without the exit hooks of the networks' libraries.

    Everything is closed and written by now, and a hook may wait for a listener that takes nothing, deaf to signals.
    """
    if "graph.recording.transports.sink" in sys.modules:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)
    return code


def open_closed_streams() -> None:
    """Opens the standard streams that the shell closed (`2>&-`), as nothing.

    Otherwise the first file opened would get the stream's number, and its output.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number, which is this one
        if getattr(sys, name) is None:
            # Stays open until the process ends.
            setattr(sys, name, open(os.devnull, "w" if number else "r", encoding="utf-8"))  # noqa: SIM115


def _drop_output() -> None:
    """Prevents a second error message when Python flushes the rest at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def split_settings(arguments: Sequence[str]) -> tuple[list[str], dict[str, Any]]:
    """Splits a command line into the rest and its `--/path=value` options as settings, with values read as in YAML.

    Raises UserError for an option without a value.
    """
    from graph.files.scalars import resolve

    rest: list[str] = []
    settings: dict[str, Any] = {}
    for index, argument in enumerate(arguments):
        if argument == "--":
            rest += arguments[index:]
            break
        if not argument.startswith("--/"):
            rest.append(argument)
            continue
        path, equals, text = argument[2:].partition("=")
        if not equals or len(path) < 2:
            raise UserError(f"{argument}: write a setting as --/path=value")
        try:
            settings[path] = resolve(text) if text else ""
        except ValueError as error:
            raise UserError(f"{argument}: {error}") from None
    return rest, settings


def _dispatch(arguments: list[str], debug: bool) -> int:
    rest, settings = split_settings(arguments)
    # `graph --debug run FILE` means the same as `graph run FILE --debug`.
    name = next((argument for argument in rest if not argument.startswith("-")), None)
    if name is None:
        return _without_command(rest)
    command = find(name)
    if command is None:
        raise _WrongUsage(_unknown_command(name))
    before = rest[: rest.index(name)]
    _top_parser(COMMANDS).parse_args(before)
    if settings and not command.settings:
        raise UserError(f"graph {name} builds no App and takes no settings; leave out --{next(iter(settings))}")
    from graph.base.asset_roots import mapped
    from graph.base.hidden import refuse_hidden_packages
    from graph.base.limits import raised

    from .arguments import asset_roots_of, limits_of
    from .safe_log import safe_log

    safe_log(debug)
    refuse_hidden_packages()
    module = import_module(command.module)
    parser = _Parser(prog=f"graph {name}", description=f"{command.help[0].upper()}{command.help[1:]}.")
    parser.add_argument("--debug", action="store_true", help="show tracebacks")
    if command.settings:
        parser.epilog = (
            "--/path=value sets a value of the settings tree, such as --/app/runLoops/main/rateLimitFrequency=30"
        )
    module.add_arguments(parser)
    parser.epilog = f"{f'{parser.epilog}. ' if parser.epilog else ''}The manual: graph help {name}"
    options = rest[rest.index(name) + 1 :]
    own = parser.own_arguments(options) if command.script else len(options)
    parser.refuse_unknown_options(options[:own])
    args = parser.parse_args(options[:own])
    args.arguments = options[own:]
    args.settings = settings
    args.debug = args.debug or "--debug" in before
    with raised(limits_of(args)), mapped(asset_roots_of(args)):
        if files := getattr(args, "node_files", ()):
            from .node_files import load_node_files

            load_node_files(files)
        return int(module.run(args))


def _top_parser(commands: Mapping[str, Command]) -> _Parser:
    width = max(map(len, commands))
    lines = "\n".join(f"  {name:{width}}  {command.help}" for name, command in commands.items())
    parser = _Parser(
        prog="graph",
        usage="graph COMMAND [options]",
        description="Node graphs, exact clocks and multi-rate sensors over MuJoCo and Open3D.",
        epilog=f"commands:\n{lines}\n\n`graph COMMAND --help` lists options, `graph help` the pages of the manual.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="store_true", help="print the version and exit")
    parser.add_argument("--debug", action="store_true", help="show tracebacks")
    return parser


def _without_command(arguments: list[str]) -> int:
    parser = _top_parser(COMMANDS if "--version" in arguments else every())
    args = parser.parse_args(arguments)
    if args.version:
        say(f"tickgraph {version()}")
        return DONE
    if arguments:
        raise _WrongUsage("graph: no command given; see graph --help")
    parser.print_help()
    return DONE


def version() -> str:
    """The installed version; in a clone that was never installed, "(not installed)"."""
    from importlib import metadata

    try:
        return metadata.version("tickgraph")
    except metadata.PackageNotFoundError:
        return "(not installed)"


def _unknown_command(name: str) -> str:
    known = every()
    advice = did_you_mean(name, known) or f"; commands are {', '.join(known)}"
    return f'graph: there is no command "{name}"{advice}'


def _options(arguments: Sequence[str]) -> Sequence[str]:
    return arguments[: arguments.index("--")] if "--" in arguments else arguments


def _trace(debug: bool) -> None:
    if debug:
        import traceback

        traceback.print_exc()


def _complain(lines: Iterable[str]) -> None:
    for line in lines:
        tell(line)
