"""Writes files: whole or not at all, and never through a link.

Folders that a user works in may come from strangers, with links in them. The folder that the user names is taken as it
is; below it nothing is written through a link, neither a folder nor a file. A file is written beside its place and
renamed when it is whole: a full disk or a kill leaves the earlier file. A test looks for other ways to write.
"""

from __future__ import annotations

import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO, TextIO

from .errors import UserError
from .inputs import check_regular

_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)


class LinkError(UserError):
    """A place to write at is a link, or lies below one."""

    def __init__(self, path: Path) -> None:
        super().__init__(f"{path} is a link, and nothing is written through links; remove it or name another place")


def make_folder(root: Path, *names: str) -> Path:
    """The folder `root`/name/name..., made if it is missing. Raises LinkError if one of the names is a link.

    root: as the user names it; it may be, or lie below, a link. Raises OSError if it cannot be made.
    """
    root.mkdir(parents=True, exist_ok=True)
    for name in names:
        root = root / name
        check_no_link(root)
        root.mkdir(exist_ok=True)
    return root


def make_output(out: Path, source: Path) -> Path:
    """The folder `out`, made if it is missing; below the folder `source`, which is read, no link leads to it.

    Raises LinkError if one does, and OSError if the folder cannot be made.
    """
    out, source = Path(os.path.abspath(out)), Path(os.path.abspath(source))
    if out != source and out.is_relative_to(source):
        return make_folder(source, *out.relative_to(source).parts)
    return make_folder(out)


def check_no_link(path: Path) -> None:
    """Raises LinkError for a link, whether it leads somewhere or not."""
    if path.is_symlink():
        raise LinkError(path)


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A stream for the new content of a file, which takes its place when the block ends without an error.

    The permissions of an earlier file stay. A device, such as /dev/null, is written directly. Raises LinkError for a
    link, OSError if it cannot be written.
    """
    earlier = _status(path)
    if earlier is not None and stat.S_ISCHR(earlier.st_mode):
        with os.fdopen(os.open(path, os.O_WRONLY | _FLAGS), "wb") as stream:
            yield stream
        return
    if earlier is not None:
        check_regular(earlier, path)
    made = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with os.fdopen(_created(made), "wb") as stream:
            yield stream
        if earlier is not None:
            made.chmod(stat.S_IMODE(earlier.st_mode) & 0o777)
        os.replace(made, path)
    except BaseException as error:
        with suppress(OSError):
            made.unlink()
        if isinstance(error, OSError) and error.filename == str(made):
            error.filename = str(path)
        raise


@contextmanager
def replacing_text(path: Path) -> Iterator[TextIO]:
    """`replacing` for UTF-8 text, whose line ends are written as they are."""
    with replacing(path) as stream:
        text = TextIOWrapper(stream, encoding="utf-8", errors="backslashreplace", newline="")
        yield text
        text.flush()
        text.detach()


def write(path: Path, content: bytes | str) -> None:
    """Replaces the content of a file, text as UTF-8. Raises as `replacing` does."""
    with replacing(path) as stream:
        stream.write(content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content)


def created(path: Path) -> BinaryIO:
    """A new file to write and read, for what must be on disk as it grows. An earlier regular file is removed first.

    Raises LinkError for a link, OSError if it cannot be made.
    """
    earlier = _status(path)
    if earlier is not None and stat.S_ISCHR(earlier.st_mode):
        return os.fdopen(os.open(path, os.O_RDWR | _FLAGS), "w+b")
    if earlier is not None:
        check_regular(earlier, path)
        path.unlink()
    return os.fdopen(_created(path), "w+b")


def changed(path: Path) -> BinaryIO:
    """An existing file to change in place, unbuffered.

    Raises LinkError for a link, UserError for a file with a second name, OSError if it cannot be written.
    """
    check_no_link(path)
    handle = os.open(path, os.O_RDWR | _FLAGS | getattr(os, "O_NONBLOCK", 0))
    try:
        found = os.fstat(handle)
        check_regular(found, path)
        if found.st_nlink > 1:
            raise UserError(f"{path} has another name too (a hard link), and would change there as well; copy it first")
        return os.fdopen(handle, "r+b", 0)
    except BaseException:
        os.close(handle)
        raise


def rename(path: Path, name: Path) -> None:
    """Gives a file, or a link itself, another name; an earlier file of that name is gone. Raises OSError."""
    os.replace(path, name)


def remove_folder(path: Path) -> None:
    """Removes a folder with its content, or a link itself, if it is there; follows no link. Raises OSError."""
    if path.is_symlink():
        path.unlink()
    elif path.exists():
        shutil.rmtree(path)


def remove(path: Path) -> None:
    """Removes a file, or a link itself, if it is there. Raises OSError if it stays."""
    path.unlink(missing_ok=True)


def _created(path: Path) -> int:
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | _FLAGS, 0o666)


def _status(path: Path) -> os.stat_result | None:
    """What is at a place; None if nothing is there. Raises LinkError for a link."""
    try:
        found = path.lstat()
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(found.st_mode):
        raise LinkError(path)
    return found
