"""Opens files for reading: regular files only, and never more of them than the reader says.

A named pipe waits for a writer for ever, `/dev/zero` never ends, a sparse file of 20 GB takes no space on disk. So
every file that a user or a stranger names is opened here; a test looks for other ways.
"""

from __future__ import annotations

import errno
import os
import stat
from typing import TYPE_CHECKING, BinaryIO

from .errors import UserError

if TYPE_CHECKING:
    from pathlib import Path

FLAGS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
"""A pipe without a writer is opened without waiting, and then refused."""


def opened(path: str | Path, *, buffering: int = -1) -> BinaryIO:
    """The open file. Raises OSError, with a reason, if it cannot be read or is not a regular file."""
    handle = os.open(path, os.O_RDONLY | FLAGS)
    try:
        check_regular(os.fstat(handle), path)
        return os.fdopen(handle, "rb", buffering)
    except BaseException:
        os.close(handle)
        raise


def read(path: str | Path, limit: str, name: str = "") -> bytes:
    """The bytes of a file, at most as many as the limit of this name.

    Raises OverLimit if it is larger, and OSError as `opened` does. name: the file's name in that message.
    """
    from .limits import check, most  # `graph --help` reads without limits

    size = most(limit)
    data = start_of(path, size + 1)
    if len(data) > size:
        check(limit, len(data), f"{name or path} is too large")
    return data


def start_of(path: str | Path, size: int) -> bytes:
    """The first bytes of a file, `size` at most. Raises OSError as `opened` does."""
    with opened(path) as stream:
        return stream.read(size)


def read_text(path: str | Path, limit: str) -> str:
    """The UTF-8 text of a file, without a byte order mark. Raises UserError for other bytes, and as `read` does."""
    try:
        return read(path, limit).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UserError(f"{path} is not UTF-8 text; save it as UTF-8") from None


def digest(path: str | Path) -> str:
    """The SHA-256 of a file, as hexadecimal digits. Raises OSError as `opened` does."""
    import hashlib

    found = hashlib.sha256()
    with opened(path) as stream:
        while part := stream.read(2**20):
            found.update(part)
    return found.hexdigest()


def check_regular(found: os.stat_result, path: str | Path) -> None:
    """Raises OSError unless the file is a regular one."""
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
