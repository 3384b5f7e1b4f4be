"""Opens what a run recorded: the one reader of `graph info`, `export`, `view` and `--play`.

    with open_run("out/yard") as run:
        for topic in run.recorded.values():
            print(topic.name, topic.type_name, topic.messages)
        for entry in run.read(["/points"]):
            cloud, stamp_ns = entry.load(), entry.stamp_ns

A run is a folder of `graph run --out` (the recording in one file or in parts, and report.json), a rosbag2 folder, or
one file (.mcap, .db3). Messages come by time and are decoded one by one, so memory does not grow with the recording.
"""

from __future__ import annotations

import heapq
import json
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.inputs import read_text, start_of

from .sources import Entry

if TYPE_CHECKING:
    from .recorded_file import RecordedFile

REPORT = "report.json"
"""Name of the report beside a recording."""
PREVIOUS = ".previous"
"""Stands before the suffix of an earlier run's files until the next run has ended well."""
SUFFIXES = (".mcap", ".db3")
"""Extensions of recordings."""
NAMED = 3
"""Folders of runs that a message lists at most."""
_COMPRESSED = re.compile(r"compression_mode:\s*[\"']?(file|message)", re.IGNORECASE)


@dataclass(slots=True)
class RecordedTopic:
    """A topic of a recording: its type, its number of messages, the metadata of its channel (empty in .db3 files)."""

    name: str
    type_name: str
    messages: int = 0
    metadata: Mapping[str, str] = field(default_factory=dict)


class RunReader:
    """A recording in one or more files; a `Source` of messages.

    recorded: its topics by name. report: the content of report.json; None without one. provenance: what the recorder
    noted about the run. notes: lines about what is missing. skipped: topics that cannot be read, and why. on_read: is
    called for each message that is read.
    """

    def __init__(
        self, name: str, files: Iterable[RecordedFile], report: Mapping[str, Any] | None, notes: Iterable[str]
    ) -> None:
        self.name, self.report = name, report
        self.files = tuple(files)
        self.notes = [*notes, *(one.unfinished for one in self.files if one.unfinished)]
        self.skipped: dict[str, str] = {}
        self.on_read: Callable[[], None] = _nothing
        self.recorded: dict[str, RecordedTopic] = {}
        self.provenance: dict[str, str] = {}
        for file in self.files:
            self.provenance = self.provenance or file.provenance
            self._add(file)

    def topics(self) -> Mapping[str, str]:
        """The topics that can be read and their types."""
        return {topic.name: topic.type_name for topic in self.recorded.values()}

    def start_ns(self) -> int:
        """The log time of the first message [ns]; 0 without messages."""
        return min((file.start_ns() for file in self.files if any(file.counts.values())), default=0)

    def __iter__(self) -> Iterator[Entry]:
        return self.read()

    def read(self, topics: Collection[str] | None = None) -> Iterator[Entry]:
        """The messages on these topics (default: on all) by log time; equal times in the order of the files.

        A file is opened when the time of its first message is reached. Raises RunError at damaged content.
        """
        wanted = {name for name in self.recorded if topics is None or name in topics}
        order = count()
        files = sorted(self.files, key=lambda one: one.start_ns(), reverse=True)
        running: list[tuple[int, int, Entry, Iterator[Entry]]] = []

        def advance(entries: Iterator[Entry], place: int) -> None:
            entry = next(entries, None)
            if entry is not None:
                heapq.heappush(running, (entry.time_ns, place, entry, entries))

        while files or running:
            while files and (not running or files[-1].start_ns() <= running[0][0]):
                file = files.pop()
                readable = file.topics()
                fitting = {name for name in wanted if readable.get(name) == self.recorded[name].type_name}
                advance(iter(file.read(fitting)), next(order))
            if running:
                _, place, entry, entries = heapq.heappop(running)
                self.on_read()
                yield entry
                advance(entries, place)

    def __repr__(self) -> str:
        messages = sum(topic.messages for topic in self.recorded.values())
        return f"<recording {self.name}: {messages:,} messages on {len(self.recorded)} topics>"

    def _repr_html_(self) -> str:
        from graph.base.html import table

        rows = [(topic.name, topic.type_name, f"{topic.messages:,}") for topic in self.recorded.values()]
        return table(("topic", "type", "messages"), rows, repr(self))

    def close(self) -> None:
        """Closes its files; calling it twice is harmless."""
        for file in self.files:
            file.close()

    def __enter__(self) -> RunReader:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _add(self, file: RecordedFile) -> None:
        self.skipped |= file.skipped
        for name, type_name in file.topics().items():
            topic = self.recorded.setdefault(name, RecordedTopic(name, type_name, 0, file.channels.get(name, {})))
            if topic.type_name == type_name:
                topic.messages += file.counts.get(name, 0)
            else:
                self.skipped[name] = f"{file.name} has messages of type {type_name} on it"


def _nothing() -> None:
    pass


def open_run(path: str | Path, *, whole: bool = True) -> RunReader:
    """The reader of a run: a folder or one file.

    whole: refuse files that were not finished or cannot be read. Otherwise what can be read of them is, and `notes`
    says what is missing; so is a folder with a report and no recording. Raises UserError if nothing can be read.
    """
    path = Path(path)
    if not path.is_dir():
        if not path.exists():
            raise UserError(f"{path}: No such file or directory; name the folder of a run or a recording")
        if path.suffix.lower() not in SUFFIXES:
            raise UserError(f"{path}: not a recording; name the folder of a run, a .mcap or a .db3 file")
        return RunReader(str(path), [_open_file(path, whole)], None, ())
    notes: list[str] = []
    report = _read_report(path, notes)
    found = recorded_files(path, report)
    if not found:
        if whole or report is None:
            below = sorted({str(one.parent) for suffix in SUFFIXES for one in path.glob(f"*/*{suffix}")})
            such = f", such as {' or '.join(below[:NAMED])}" if below else ""
            raise UserError(f"{path}: no recording is in this folder; name one that holds .mcap or .db3 files{such}")
        notes.append(f"{path}: no message was recorded")
    files: list[RecordedFile] = []
    for one in found:
        try:
            files.append(_open_file(one, whole))
        except UserError as error:
            if whole or len(found) == 1:
                raise
            notes.append(str(error))
    if found and not files:
        raise UserError("\n".join(notes))
    return RunReader(str(path), files, report, notes)


def recorded_files(folder: Path, report: Mapping[str, Any] | None = None) -> list[Path]:
    """The files of the recording in a folder: those that its report names, else all, parts by their numbers.

    Raises UserError for a folder that cannot be read, a compressed rosbag2 folder and a report that names files
    elsewhere.
    """
    if report is not None and isinstance(named := report.get("recording"), list):
        return [_inside(folder, name) for name in named]
    metadata = folder / "metadata.yaml"
    try:
        text = start_of(metadata, 1_000_000).decode("utf-8", "replace") if metadata.exists() else ""
        names = [one for one in folder.iterdir() if not one.stem.endswith(PREVIOUS)]
    except OSError as error:
        raise UserError(f"{folder}: {error.strerror}; name a recording that can be read") from None
    if any(one.suffix == ".zstd" for one in names) or _COMPRESSED.search(text):
        raise UserError(f"{folder}: the recording is compressed; write it uncompressed first: ros2 bag convert")
    return sorted((one for one in names if one.suffix in SUFFIXES), key=_by_numbers)


def _inside(folder: Path, name: object) -> Path:
    parts = PurePosixPath(name) if isinstance(name, str) else None
    if parts is None or parts.is_absolute() or ".." in parts.parts:
        raise UserError(f"{folder / REPORT}: recording: {name!r:.60} is not a file of this folder; correct the report")
    return folder / parts


def _by_numbers(path: Path) -> list[tuple[int, str]]:
    """A key that sorts run_2 before run_10."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _open_file(path: Path, whole: bool) -> RecordedFile:
    if path.suffix.lower() == ".db3":
        from .bag_source import BagSource

        return BagSource(path)
    from .mcap_source import McapSource

    return McapSource(path, whole=whole)


def _nothing_of(text: str) -> None:
    """NaN and the infinities, which are not JSON."""


def _finite(text: str) -> float | None:
    return number if math.isfinite(number := float(text)) else None


def _countable(text: str) -> int | None:
    return number if -(2**63) <= (number := int(text)) < 2**63 else None


def _read_report(folder: Path, notes: list[str]) -> Mapping[str, Any] | None:
    file = folder / REPORT
    try:
        text = read_text(file, "file.json")
        report = json.loads(text, parse_constant=_nothing_of, parse_float=_finite, parse_int=_countable)
    except FileNotFoundError:
        if not (folder / "metadata.yaml").is_file():  # of a rosbag2 folder, which has no report
            notes.append(f"{file}: there is no report; the run was killed or goes on")
        return None
    except (OSError, ValueError, RecursionError) as error:
        notes.append(f"{file}: the report cannot be read ({error})")
        return None
    if not isinstance(report, dict):
        notes.append(f"{file}: the report is not a JSON object; it is ignored")
        return None
    return report
