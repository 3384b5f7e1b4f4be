"""`graph new`: writes a commented graph file to start from, or copies a shipped example with its scene."""

from __future__ import annotations

import argparse
import os
import shlex
from importlib import resources
from pathlib import Path

from graph.base.errors import UserError
from graph.base.outputs import make_folder, write

from . import examples
from .printing import print_table, say

KINDS = {
    "sensors": "a lidar, a radar and a camera before a falling ball, with TF",
    "lidar": "a wall, a falling ball and a lidar that publishes point clouds",
    "diffdrive": "a mobile robot with two driven wheels: it follows /cmd_vel and publishes odometry and TF",
}
"""The kinds of templates; the text of each is `templates/KIND.yaml` beside this module."""
COMMANDS = {"diffdrive": "diffdrive.commands.yaml"}
"""Kinds whose robot stands still without messages, and the template of these."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument(
        "kind",
        metavar="KIND",
        nargs="?",
        help=f"the template {', '.join(KINDS)}, or the name of a shipped example; --list says what each is",
    )
    parser.add_argument(
        "file",
        metavar="FILE",
        nargs="?",
        help="the file to write, such as robot.yaml; of an example the folder; it must not exist yet",
    )
    parser.add_argument("--list", action="store_true", help="list the kinds and the examples, and do nothing else")


def run(args: argparse.Namespace) -> int:
    """Runs the command. Raises UserError if the target exists or its folder does not."""
    if args.list:
        rows = [(name, examples.about(file)) for name, file in examples.examples().items()]
        print_table([(kind, "FILE", what) for kind, what in KINDS.items()], ("template", "", "content"))
        say()
        print_table([(name, "DIR", what) for name, what in rows], ("example", "", "content"))
        return 0
    if args.kind is None:
        raise UserError("name a kind or an example: graph new KIND FILE, graph new EXAMPLE DIR, graph new --list")
    known = examples.examples()
    if args.kind not in KINDS and args.kind not in known:
        raise UserError(examples.unknown(args.kind, KINDS))
    if args.file is None:
        target = "FILE.yaml" if args.kind in KINDS else "DIR"
        raise UserError(f"name what to write: graph new {args.kind} {target}")
    lines = _write(args.kind, Path(args.file)) if args.kind in KINDS else _copy(known[args.kind], Path(args.file))
    for line in lines:
        say(line)
    return 0


def _write(kind: str, path: Path) -> list[str]:
    if path.suffix not in (".yaml", ".yml"):
        raise UserError(f"{path}: the file is YAML; give it the ending .yaml")
    files = {path: text(kind, path)}
    played = _commands_file(path) if kind in COMMANDS else None
    if played is not None:
        files[played] = _template(COMMANDS[kind])
    for file in files:
        if os.path.lexists(file):
            raise UserError(f"{file} exists; give another name, or remove it first")
    try:
        for file, content in files.items():
            write(file, content)
    except FileNotFoundError:
        raise UserError(f"{path}: its folder {path.parent} does not exist; make it first") from None
    return [f"wrote {' and '.join(map(str, files))}; next:", *_next(path, played)]


def _copy(example: Path, folder: Path) -> list[str]:
    """Copies an example into a new or empty folder."""
    if os.path.lexists(folder) and (folder.is_symlink() or not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder} exists; give another name, or remove it first")
    if not folder.absolute().parent.is_dir():
        raise UserError(f"{folder}: its folder {folder.parent} does not exist; make it first")
    files = examples.files_of(example)
    for file in files:
        target = folder / file.relative_to(example.parent)
        make_folder(target.parent)
        write(target, file.read_bytes())
    played = examples.commands_of(files)
    commands = folder / played.relative_to(example.parent) if played else None
    return [f"wrote {len(files)} files into {folder}; next:", *_next(folder / example.name, commands)]


def _next(file: Path, played: Path | None) -> list[str]:
    """The commands that play a file and show what it did."""
    out = f"out/{file.stem}"
    play = ("--play", str(played)) if played is not None else ()
    commands = [("graph", "run", str(file), *play, "--out", out), ("graph", "view", out)]
    return [f"  {shlex.join(command)}" for command in commands]


def _commands_file(path: Path) -> Path:
    return path.with_name(f"{path.stem}.commands.yaml")


def text(kind: str, file: str | Path) -> str:
    """The template of a kind; its first lines show the command that plays `file`."""
    path = Path(file)
    filled = _template(f"{kind}.yaml").replace("COMMANDS", _commands_file(path).as_posix())
    return filled.replace("FILE", path.as_posix())


def _template(name: str) -> str:
    return resources.files(__package__).joinpath("templates", name).read_text(encoding="utf-8")
