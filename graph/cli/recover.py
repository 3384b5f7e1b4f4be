"""`graph recover`: rebuilds the index of a recording that was not finished, for example after a kill or a power cut.

Of a recording in parts only the last can be unfinished; a folder is mended part by part.
"""

from __future__ import annotations

import argparse
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from graph.base.errors import Problem, RunError, UserError
from graph.base.inputs import opened
from graph.base.outputs import make_output, remove, replacing

from .arguments import add_limit
from .output_folder import locked
from .printing import say

if TYPE_CHECKING:
    from graph.recording.recovery import Finished


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="MCAP recording or the folder of a run; mended in place"
    )
    parser.add_argument("--out", type=Path, metavar="OUT", help="leave FILE as it is and write the mended one as OUT")
    add_limit(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.recording.run_reader import recorded_files

    file: Path = args.file
    if file.is_dir():
        if args.out:
            raise UserError(f"--out takes one file; name one of the recordings in {file}")
        folder, files = file, [one for one in recorded_files(file) if one.suffix == ".mcap"]
        if not files:
            raise UserError(f"{file}: no .mcap file is in this folder; name an MCAP recording")
    elif file.is_file():
        folder, files = file.parent, [file]
    else:
        raise UserError(f"{file}: no such file; name an MCAP recording")
    problems: list[Problem] = []
    with locked(folder, "let the run end, or stop it, first"):
        if len(files) > 1 and files[-1].is_file() and not files[-1].is_symlink() and not files[-1].stat().st_size:
            empty = files.pop()
            remove(empty)
            say(f"{empty}: the run was killed when it began this part; the empty file is removed")
        for one in files:
            try:
                _mend(one, args.out)
            except UserError as error:
                problems += error.problems
    if problems:
        raise UserError(problems)
    return 0


def _mend(file: Path, out: Path | None) -> None:
    """Finishes one recording, or a copy of it, and says what was done."""
    from graph.recording.recovery import finish

    target = _copied(file, out) if out else file
    try:
        left = finish(target)
    except UserError:
        if out:
            remove(target)
        raise
    except OSError as error:
        raise RunError(f"{target}: {error.strerror or error}; its whole chunks are kept, try again") from error
    say(f"{target}: {_said(left)}")


def _copied(file: Path, target: Path) -> Path:
    """The copy to repair."""
    if os.path.lexists(target):
        raise UserError(f"{target} exists; name a file that does not")
    make_output(target.parent, file.parent)
    try:
        with opened(file) as stream, replacing(target) as copy:
            shutil.copyfileobj(stream, copy, 2**20)
    except OSError as error:
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
        parts.append(f"{left.damaged} damaged records are left out of the index")
    return "; ".join(parts)
