"""`graph recover`: rebuilds the index of a recording that was not finished, for example after a kill or a power cut."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from graph.base.errors import RunError, UserError

from .output_folder import locked
from .printing import say

if TYPE_CHECKING:
    from graph.sim.messages.recovery import Finished


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", type=Path, help="MCAP recording; it is mended in place")
    parser.add_argument("--out", type=Path, metavar="OUT", help="leave FILE as it is and write the mended one as OUT")


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.sim.messages.recovery import finish

    file: Path = args.file
    if not file.is_file():
        raise UserError(f"{file}: no such file; name an MCAP recording")
    with locked(file.parent, "let the run end, or stop it, first"):
        target = _copied(file, args.out) if args.out else file
        try:
            left = finish(target)
        except UserError:
            if args.out:
                target.unlink()
            raise
        except OSError as error:
            raise RunError(f"{target}: {error.strerror or error}; its whole chunks are kept, try again") from error
    say(f"{target}: {_said(left)}")
    return 0


def _copied(file: Path, target: Path) -> Path:
    """The copy to repair."""
    if target.exists():
        raise UserError(f"{target} exists; name a file that does not")
    try:
        shutil.copyfile(file, target)
    except OSError as error:
        target.unlink(missing_ok=True)
        raise UserError(f"{target}: {error.strerror}; name a file that can be written") from None
    return target


def _said(left: Finished) -> str:
    if left.whole:
        return f"the recording is finished, nothing was changed ({left.messages:,} messages)"
    parts = [f"index rebuilt over {left.messages:,} messages"]
    if left.messages:
        parts[0] += f", up to {left.end_ns / 1e9:.9f} s"
    if left.cut:
        parts.append(f"{left.cut:,} bytes of what was being written were cut off")
    if left.dropped:
        parts.append(f"{left.dropped} whole chunks at its end made room for the index")
    if left.damaged:
        parts.append(f"{left.damaged} damaged chunks are left out of the index")
    return "; ".join(parts)
