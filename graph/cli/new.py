"""`graph new`: writes a commented graph file to start from."""

from __future__ import annotations

import argparse
import os
from importlib import resources
from pathlib import Path

from graph.base.errors import UserError
from graph.base.outputs import write

from .printing import say

KINDS = {
    "sensors": "a lidar, a radar and a camera before a falling ball, with TF",
    "lidar": "a wall, a falling ball and a lidar that publishes point clouds",
    "diffdrive": "a robot with two driven wheels that follows /cmd_vel and publishes odometry and TF",
}
"""The kinds of templates; the text of each is `templates/KIND.yaml` beside this module."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    kinds = "; ".join(f"{kind}: {what}" for kind, what in KINDS.items())
    parser.add_argument("kind", metavar="KIND", choices=tuple(KINDS), help=kinds)
    parser.add_argument("file", metavar="FILE", help="the file to write, such as robot.yaml; it must not exist yet")


def run(args: argparse.Namespace) -> int:
    """Runs the command. Raises UserError if the file exists or its folder does not."""
    path = Path(args.file)
    if path.suffix not in (".yaml", ".yml"):
        raise UserError(f"{path}: the file is YAML; give it the ending .yaml")
    if os.path.lexists(path):
        raise UserError(f"{path} exists; give another name, or remove it first")
    try:
        write(path, text(args.kind, path.as_posix()))
    except FileNotFoundError:
        raise UserError(f"{path}: its folder {path.parent} does not exist; make it first") from None
    say(f"wrote {path}; next: graph run {path} --out out/{path.stem}")
    return 0


def text(kind: str, file: str) -> str:
    """The template of a kind; its first lines show the command that plays `file`."""
    template = resources.files(__package__).joinpath("templates", f"{kind}.yaml")
    return template.read_text(encoding="utf-8").replace("FILE", file)
