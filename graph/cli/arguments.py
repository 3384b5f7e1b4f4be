"""Arguments that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_allow(parser: argparse.ArgumentParser) -> None:
    """`--allow DIR`, any number of times: folders whose files may be read beside those around the graph file."""
    parser.add_argument(
        "--allow", action="append", default=[], type=folder, metavar="DIR", help="also allow files below DIR"
    )


def folder(text: str) -> Path:
    """The folder of that name. Raises ArgumentTypeError where there is none."""
    path = Path(text)
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text} is no folder")
    return path
