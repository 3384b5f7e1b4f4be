"""Compiled code on disk: found by what it was made from, so that no clone or environment compiles it a second time.

A file's name is a hash of the sources' text, the argument types and the versions of Python, Numba and LLVM; no path and
no time goes into it. Code is made for the plain instruction set of the architecture ("generic"): the same file serves
every machine, and costs nothing measurable.

A loop is looked for in the package (`SHIPPED`, which wheels fill), then in the user's own folder; what is compiled goes
into the latter. The files are pickles and machine code. So the folder must belong to the user, and nobody else may
write there; otherwise the process compiles for itself alone.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

SHIPPED = Path(__file__).with_name("shipped")
"""Code that comes with the package, read only."""

FOLDER = "TICKGRAPH_CACHE"
"""Environment variable: a folder instead of the user's cache folder."""

DIGEST = hashlib.sha256().digest_size


@cache
def numba() -> Any:
    """The module, set to compile for every processor of this architecture. Raises ImportError without it.

    A choice of the user's own (`NUMBA_CPU_NAME`) stands.
    """
    import numba

    if numba.config.CPU_NAME is None:
        numba.config.CPU_NAME, numba.config.CPU_FEATURES = "generic", ""
    return numba


def user_folder() -> Path:
    """The folder for this user's compiled code; it need not exist."""
    chosen = os.environ.get(FOLDER)
    if chosen:
        return Path(chosen).expanduser() / "kernels"
    from platformdirs import user_cache_path

    return user_cache_path("tickgraph", appauthor=False) / "kernels"


def why_not_trusted(folder: Path) -> str | None:
    """Why code from an existing folder must not be run, or None: it is not the user's, or others may write there."""
    status = os.lstat(folder)
    if os.path.islink(folder) or not os.path.isdir(folder):
        return "it is not a folder"
    if os.name == "posix" and status.st_uid != os.geteuid():
        return "it belongs to another user"
    if os.name == "posix" and status.st_mode & 0o022:
        return "others may write into it"
    return None


@cache
def _trusted(folder: Path) -> bool:
    """Whether code may be read from a folder and kept there; makes it where it is missing."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return why_not_trusted(folder) is None
    except OSError:
        return False


def why_not_kept() -> str | None:
    """Why this user's compiled code is not kept from run to run, or None if it is."""
    folder = user_folder()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        reason = why_not_trusted(folder)
        if reason is None:
            tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        reason = error.strerror or str(error)
    return reason and f"{folder}: {reason}"


def source_hash(files: set[str]) -> bytes:
    """A hash of the content of some files, whatever their folder. Raises OSError if one cannot be read."""
    return hashlib.sha256(b"".join(sorted(_content_hash(file) for file in files))).digest()


@cache
def _content_hash(file: str) -> bytes:
    return hashlib.sha256(Path(file).read_bytes()).digest()


class Kept:
    """The compiled forms of one function, as Numba's dispatcher asks for them (the methods of its own caches).

    name: module and function. files: those whose text the code is made from.
    """

    def __init__(self, name: str, files: set[str]) -> None:
        self._name, self._files = name, files
        self.misses: list[Any] = []
        """The signatures for which nothing was kept."""

    def load_overload(self, signature: Any, target: Any) -> Any:
        """What was compiled for a signature earlier, in this or another process; None if nothing is kept."""
        target.refresh()
        for file in self.places(signature, target.codegen()):
            made = _read(file)
            if made is not None:
                return numba().core.compiler.CompileResult._rebuild(target, *made)
        self.misses.append(signature)
        return None

    def has(self, signature: Any, target: Any) -> bool:
        """Whether the form for a signature is kept."""
        target.refresh()
        return any(file.exists() for file in self.places(signature, target.codegen()))

    def places(self, signature: Any, codegen: Any) -> list[Path]:
        """The files in which a form may be, the package's before the user's."""
        name = self._file_name(signature, codegen)
        if name is None:
            return []
        return [SHIPPED / name, *([user_folder() / name] if _trusted(user_folder()) else [])]

    def save_overload(self, signature: Any, made: Any) -> None:
        """Keeps what was compiled, if it can be kept."""
        name = self._file_name(signature, made.codegen)
        if name is None or not _trusted(user_folder()) or made.library.has_dynamic_globals:
            return
        code, described, environment, signature, objects, lifted, _, again, more = made._reduce()
        # The text with types names the source's folder, and nothing reads it.
        parts = (_alone(code, described), described, environment, signature, objects, lifted, "", again, more)
        data = numba().core.serialize.dumps(parts)
        _write(user_folder() / name, hashlib.sha256(data).digest() + data)

    def _file_name(self, signature: Any, codegen: Any) -> str | None:
        """The file of a signature; None if the sources cannot be read."""
        found, llvm = numba(), sys.modules["llvmlite"].__version__
        versions = (sys.implementation.cache_tag, found.__version__, llvm, found.config.USING_SVML)
        try:
            key = (self._name, source_hash(self._files), str(signature), codegen.magic_tuple(), versions)
        except OSError:
            return None
        return f"{self._name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:32]}.bin"


def _alone(code: tuple[str, str, Any], described: Any) -> tuple[str, str, Any]:
    """Machine code without the bitcode that other functions would take in: no loop calls another. Of that a process
    that loads the code would read every symbol, which takes longer than all the rest; it needs the entry's name.
    """
    name, kind, (machine, _) = code
    entry = f'define void @"{described.llvm_cpython_wrapper_name}"() {{ ret void }}'
    return name, kind, (machine, numba().core.codegen.ll.parse_assembly(entry).as_bitcode())


def _read(file: Path) -> Any:
    """A file's content, or None: it is missing, unreadable or damaged."""
    try:
        data = file.read_bytes()
    except OSError:
        return None
    return pickle.loads(data[DIGEST:]) if hashlib.sha256(data[DIGEST:]).digest() == data[:DIGEST] else None


def _write(file: Path, data: bytes) -> None:
    """Writes a file as a whole, or not at all: the disk may be full, and other processes may write the same file."""
    part = None
    try:
        with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".part", delete=False) as opened:
            part = Path(opened.name)
            opened.write(data)
        part.replace(file)
    except OSError:
        if part is not None:
            part.unlink(missing_ok=True)
