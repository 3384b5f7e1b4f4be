"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.asset_roots import checked_roots
from graph.base.errors import UserError
from graph.base.limits import checked

if TYPE_CHECKING:
    from graph.session.open import Session


def check_folder(folder: Path) -> None:
    """Raises UserError for a folder of `--out` that cannot be written, before there is anything to write."""
    place = next((one for one in (folder, *folder.absolute().parents) if one.exists()), folder)
    if not place.is_dir() or not os.access(place, os.W_OK):
        raise UserError(f"--out {folder}: {place} is not a folder that can be written; name another")


def add_allow(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of every command that reads files, each repeatable.

    `--allow DIR`: folders whose files may be read besides those around the graph file. `--asset-root PREFIX=DIR`: the
    folder of assets whose address begins so. `--limit NAME=VALUE`: raises or lowers what a file may ask for.
    """
    parser.add_argument(
        "--allow", action="append", default=[], type=folder, metavar="DIR", help="also allow files below DIR"
    )
    text = "read assets whose address begins with PREFIX, such as package://my_robot, below DIR"
    parser.add_argument("--asset-root", action="append", default=[], metavar="PREFIX=DIR", help=text)
    add_limit(parser)


def add_limit(parser: argparse.ArgumentParser) -> None:
    """Adds `--limit NAME=VALUE`, repeatable."""
    text = "change what a file may ask for at most; `graph help robustness` lists the names"
    parser.add_argument("--limit", action="append", default=[], metavar="NAME=VALUE", help=text)


def add_skip_outside(parser: argparse.ArgumentParser) -> None:
    """Adds `--skip-outside`: run without files outside the allowed folders that the scene refers to."""
    parser.add_argument(
        "--skip-outside",
        action="store_true",
        help="leave out what the scene refers to outside its folder and the allowed ones, with a warning each",
    )


def add_nodes(parser: argparse.ArgumentParser) -> None:
    """Adds `--nodes FILE.py`, repeatable."""
    parser.add_argument(
        "--nodes",
        dest="node_files",
        action="append",
        default=[],
        type=Path,
        metavar="FILE.py",
        help="run FILE.py, which registers node types of your own (@node_type), before the graph file is read",
    )


def add_overrides(parser: argparse.ArgumentParser) -> None:
    """Adds `--set NODE.ATTR=VALUE | /PRIM.ATTR=VALUE` and `--fidelity K=V`, each repeatable."""
    add_set(parser)
    add_fidelity(parser)


def add_set(parser: argparse.ArgumentParser) -> None:
    """Adds `--set NODE.ATTR=VALUE | /PRIM.ATTR=VALUE`, repeatable."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NODE.ATTR=VALUE",
        help="override a node's input, or an attribute of a prim: /PRIM/PATH.ATTR=VALUE, where ATTR is a USD attribute "
        "(omni:sensor:tickRate) or a key of inline prims (translate, rotate, scale, radius, mass, config)",
    )


def add_fidelity(parser: argparse.ArgumentParser) -> None:
    """Adds `--fidelity K=V`, repeatable."""
    parser.add_argument("--fidelity", action="append", default=[], metavar="K=V", help="override a fidelity knob")


def add_play(parser: argparse.ArgumentParser) -> None:
    """Adds `--play FILE`, repeatable."""
    parser.add_argument(
        "--play",
        action="append",
        default=[],
        type=Path,
        metavar="FILE",
        help="send the messages of FILE, a recording or a list of messages (`graph help live-and-recordings`), to the "
        "graph's subscribers; may be repeated",
    )


def add_live(parser: argparse.ArgumentParser) -> None:
    """Adds `--live NAME`, repeatable."""
    from graph.base.plugins import TRANSPORTS, shipped

    parser.add_argument(
        "--live",
        action="append",
        default=[],
        metavar="NAME[:HOST][:PORT]",
        help=f"exchange messages with other programs while the run goes on, over {', '.join(shipped(TRANSPORTS))} or "
        "the transport of a package (`graph help live-and-recordings`); may be repeated",
    )


def add_remap(parser: argparse.ArgumentParser) -> None:
    """Adds `--remap OLD:=NEW`, repeatable."""
    parser.add_argument(
        "--remap",
        action="append",
        default=[],
        metavar="OLD:=NEW",
        help="play the messages of topic OLD of the --play files on topic NEW; may be repeated",
    )


def folder(text: str) -> Path:
    """The folder of that name. Raises ArgumentTypeError if it does not exist."""
    path = Path(text)
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text} is not a folder")
    return path


def fidelity_of(args: argparse.Namespace) -> dict[str, str]:
    """The knobs of a command line. Raises UserError for an option without =."""
    device = getattr(args, "device", None)
    return _pairs(args.fidelity, "--fidelity", "KEY") | ({"device": device} if device else {})


def overrides_of(args: argparse.Namespace) -> dict[str, str]:
    """The values that a command line sets on nodes and prims, by target. Raises UserError for an option without =."""
    return _pairs(args.set, "--set", "NODE.ATTR")


def session_of(args: argparse.Namespace, **more: Any) -> Session:
    """Opens the graph file of a command line. more: further options of `open_session`, or other values for these."""
    from graph.isaac.managers.app import App
    from graph.session.open import open_session

    options: dict[str, Any] = {
        "app_type": App,
        "allow": args.allow,
        "skip_outside": args.skip_outside,
        "settings": getattr(args, "settings", {}),
        "fidelity": fidelity_of(args),
        "overrides": overrides_of(args),
        "skip_unknown": args.skip_unknown,
    }
    return open_session(args.file, **{**options, **more})


def _pairs(options: list[str], flag: str, form: str) -> dict[str, str]:
    pairs = {}
    for option in options:
        key, equals, value = option.partition("=")
        if not equals or not key:
            raise UserError(f"{flag} {option}: write it as {form}=VALUE")
        pairs[key] = value
    return pairs


def asset_roots_of(args: argparse.Namespace) -> dict[str, Path]:
    """The folder of each asset root of a command line. Raises UserError for a wrong one."""
    try:
        return checked_roots(_pairs(getattr(args, "asset_root", []), "--asset-root", "PREFIX"))
    except ValueError as error:
        raise UserError(f"--asset-root: {error}") from None


def limits_of(args: argparse.Namespace) -> dict[str, int]:
    """The limits that a command line changes. Raises UserError for an unknown limit or an invalid value."""
    values: dict[str, int] = {}
    for option in getattr(args, "limit", ()):
        name, equals, text = option.partition("=")
        try:
            values[name] = checked(name, text) if equals else 0
        except ValueError as error:
            raise UserError(f"--limit {option}: {error}") from None
        if not equals:
            raise UserError(f"--limit {option}: write it as NAME=VALUE")
    return values
