"""Writes the files of a run: the recording and `report.json`, in a folder that one run holds at a time.

An earlier run's files with these names are renamed (`run.previous.mcap`) until this run has ended well.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from graph.base.errors import RunError, UserError
from graph.base.exact import nanoseconds
from graph.base.outputs import check_no_link, make_folder, remove, rename
from graph.recording.recorder import Recorder
from graph.spec.file_spec import RecordSpec

from .report import REPORT, write_report


@contextmanager
def locked(folder: Path, advice: str, *, shared: bool = False) -> Iterator[None]:
    """Locks a folder for this process, without a lock file. Raises UserError, with `advice`, if another run holds it.

    shared: others may hold it in the same way at the same time. On systems or file systems without such locks, nothing
    is locked.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        yield
        return
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise UserError(f"{folder}: {error.strerror}; name a folder that can be read") from None
    try:
        try:
            fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(f"{folder}: another run is recording into this folder; {advice}") from None
        except OSError:  # a network file system without locks
            pass
        yield
    finally:
        os.close(handle)


@contextmanager
def held_folder(folder: Path, advice: str) -> Iterator[None]:
    """Makes a folder and locks it, as `locked` does. Raises UserError if it cannot be written."""
    try:
        make_folder(folder)
    except OSError as error:
        raise UserError(f"--out {folder}: {error.strerror}; name a folder that can be written") from None
    with locked(folder, advice):
        yield


def held_output(
    held: ExitStack, folder: Path, record: RecordSpec, read: Iterable[Path], provenance: Mapping[str, str]
) -> Output:
    """The output files of a run, in a folder that only this run holds until `held` ends. Raises as `Output` does."""
    held.enter_context(held_folder(folder, "name another folder, or let that run end"))
    return Output(folder, record, read, provenance)


class Output:
    """The files of one run in `folder`; `sink` records."""

    def __init__(
        self, folder: Path, record: RecordSpec, read: Iterable[Path], provenance: Mapping[str, str] | None = None
    ) -> None:
        """Moves an earlier run's files aside.

        Raises UserError if this run could not write, or if it reads one of them.
        """
        self.folder = folder
        self.sink = Recorder(
            folder / record.mcap,
            provenance,
            split_bytes=record.split_size,
            split_ns=None if record.split_seconds is None else nanoseconds(record.split_seconds),
            topics=record.topics,
            exclude=record.exclude,
        )
        files = [self.sink.path, folder / REPORT]
        self.failure: RunError | None = None
        """The error of finishing the files, if any."""
        self._earlier: dict[Path, Path] = {}
        try:
            files += self.sink.earlier_parts()
            for file in files:
                check_no_link(file)
                if file.is_dir():
                    raise UserError(f"--out {folder}: {file} is a folder; move it or name another folder")
                if file.exists() and any(file.samefile(one) for one in read):
                    raise UserError(
                        f"--out {folder}: this run reads {file} and would write over it; name another folder"
                    )
            make_folder(folder, *self.sink.path.relative_to(folder).parent.parts)
            for file in files:
                if file.is_file():  # not a device
                    self._move_aside(file)
        except OSError as error:
            raise UserError(f"--out {folder}: {error.strerror}; name a folder that can be written") from None

    def finish(self, report: dict[str, Any], *, well: bool) -> list[str]:
        """Writes the report after the sink is closed, with the recording's files; returns lines for the user.

        well: whether the run ended as it should. Otherwise an earlier run's files stay, and get their names back if
        this run failed before it recorded anything or ended an update. Raises RunError if there is no space for the
        report.
        """
        if self._earlier and not well and not self.sink.messages and not report["updates"]:
            self._bring_back()
            return [*self.sink.notes, f"this run recorded nothing; {self.folder} is as the earlier run left it"]
        report["recording"] = [file.relative_to(self.folder).as_posix() for file in self.sink.files]
        self._write(report)
        if self.sink.given_up:
            given = f"its last {self.sink.given_up} messages made room for {REPORT}"
            self.failure = RunError(
                f"{self.sink.path}: No space left on device; {given}, {self.sink.messages} are kept"
            )
        well = well and self.failure is None
        lines = [*self.sink.notes, self._wrote()]
        if well:
            self._drop_earlier()
        elif self._earlier:
            lines.append(f"the earlier run's files are kept: {', '.join(map(str, self._earlier.values()))}")
        return lines

    def _move_aside(self, file: Path) -> None:
        aside = file.with_name(f"{file.stem}.previous{file.suffix}")
        rename(file, aside)
        self._earlier[file] = aside

    def _bring_back(self) -> None:
        for file, aside in self._earlier.items():
            with suppress(OSError):
                rename(aside, file)

    def _drop_earlier(self) -> None:
        for aside in self._earlier.values():
            with suppress(OSError):
                remove(aside)

    def _write(self, report: Mapping[str, Any]) -> None:
        """Writes the report; on a full disk the recording gives up its last chunks to make space."""
        make_folder(self.folder)
        while True:
            try:
                return write_report(report, self.folder)
            except RunError as error:
                full = isinstance(error.__cause__, OSError) and error.__cause__.errno in (errno.ENOSPC, errno.EDQUOT)
                if not full or not self.sink.give_up_chunk():
                    raise

    def _wrote(self) -> str:
        report = self.folder / REPORT
        if not self.sink.messages:
            reason = "no message was published"
            if self.sink.left_out:
                reason = f"record: leaves out {', '.join(self.sink.left_out)}"
            return f"wrote {report}; {reason}, so there is no recording"
        files = self.sink.files
        size = sum(file.stat().st_size for file in files if file.exists())
        written = f"{files[0]}" + (f" to {files[-1].name}" if len(files) > 1 else "")
        return f"wrote {written} ({self.sink.messages:,} messages, {size / 1e6:,.1f} MB) and {report}"
