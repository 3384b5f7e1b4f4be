"""Records a run: chosen topics, in one MCAP file or in parts of a size or of a length of time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from fnmatch import fnmatchcase
from pathlib import Path

from graph.base.inputs import opened
from graph.base.outputs import make_folder, remove
from graph.sim.messages.bus import topic_name
from graph.sim.messages.message import Message

from .mcap_sink import CHUNK_BYTES, LogClock, McapSink
from .mcap_source import PROVENANCE

PART = "part"
"""Key in the provenance of a part: its number."""


class Recorder:
    """Writes the messages on chosen topics to `path`, or to the parts run_0.mcap, run_1.mcap, ... for run.mcap.

    split_bytes: a part ends after the chunk with which it reaches this size; chunks are not larger. split_ns: a part
    has the messages of one span of log time, [0, split_ns), [split_ns, 2 split_ns), ...; spans without messages have no
    part. topics, exclude: patterns such as /camera/*; a topic is recorded if it matches one of `topics` (none: any) and
    no pattern of `exclude`. Every part is a recording of its own, crash-safe as in `McapSink`.
    """

    def __init__(
        self,
        path: str | Path,
        provenance: Mapping[str, str] | None = None,
        *,
        split_bytes: int | None = None,
        split_ns: int | None = None,
        topics: Sequence[str] = (),
        exclude: Sequence[str] = (),
    ) -> None:
        self.path = Path(path)
        self.parts: list[McapSink] = []
        self.notes: list[str] = []
        self._provenance = dict(provenance or {})
        self._split_bytes, self._split_ns = split_bytes, split_ns
        self._topics, self._exclude = [*map(topic_name, topics)], [*map(topic_name, exclude)]
        self._chosen: dict[str, bool] = {}
        self._clock = LogClock()
        self._span = 0
        self._given_up = 0
        self._closed = False

    @property
    def messages(self) -> int:
        """Recorded messages."""
        return sum(part.messages for part in self.parts)

    @property
    def given_up(self) -> int:
        """Recorded messages that were removed to make space on a full disk."""
        return self._given_up + sum(part.given_up for part in self.parts)

    @property
    def files(self) -> list[Path]:
        """The files that hold messages."""
        return [part.path for part in self.parts if part.messages]

    def advertise(self, topic: str, type_name: str) -> None:
        """Decides whether the topic is recorded."""
        self._is_chosen(topic)

    def write(self, message: Message) -> None:
        """Records one message. Raises RunError if the file cannot be written."""
        if self._is_chosen(message.topic):
            self._part_for(message).write(message)

    def reached(self, now_ns: int) -> None:
        """Writes messages that have waited for half a second of simulation."""
        if self.parts:
            self.parts[-1].reached(now_ns)

    @property
    def left_out(self) -> tuple[str, ...]:
        """The topics of the run that `topics` and `exclude` keep out of the recording."""
        return tuple(topic for topic, chosen in self._chosen.items() if not chosen)

    def flush(self) -> None:
        """Writes the pending messages."""
        if self.parts:
            self.parts[-1].flush()

    def close(self) -> None:
        """Finishes the last part; calling it twice is harmless."""
        if self._closed:
            return
        self._closed = True
        try:
            if self.parts:
                self.parts[-1].close()
        finally:
            for part in self.parts:
                self.notes += part.notes
                if part.messages and not part.path.is_file() and part is not self.parts[-1]:
                    self.notes.append(f"{part.path}: it was deleted; lost messages: {part.messages:,}")
                    part.messages = 0
            for pattern in (*self._topics, *self._exclude):
                if not any(fnmatchcase(topic, pattern) for topic in self._chosen):
                    self.notes.append(f"record: {pattern} matches no topic of this run")

    def give_up_chunk(self) -> bool:
        """Makes space on a full disk: removes the last chunk, or the last part if that is its only one; False if it is
        the only chunk of the recording.
        """
        if not self.parts:
            return False
        last = self.parts[-1]
        if last.give_up_chunk():
            return True
        if len(self.parts) == 1:
            return False
        with suppress(OSError):
            remove(last.path)
            self._given_up += last.messages + last.given_up
            self.parts.pop()
            return True
        return False

    def earlier_parts(self) -> Iterator[Path]:
        """The parts of an earlier recording with this name: files that note the number in their name as their part."""
        name = re.compile(rf"{re.escape(self.path.stem)}_(\d+){re.escape(self.path.suffix)}")
        if not self.path.parent.is_dir():
            return
        for file in sorted(self.path.parent.iterdir()):
            match = name.fullmatch(file.name)
            if match and file.is_file() and _noted_part(file) == match[1]:
                yield file

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _is_chosen(self, topic: str) -> bool:
        chosen = self._chosen.get(topic)
        if chosen is None:
            wanted = not self._topics or any(fnmatchcase(topic, pattern) for pattern in self._topics)
            chosen = wanted and not any(fnmatchcase(topic, pattern) for pattern in self._exclude)
            self._chosen[topic] = chosen
        return chosen

    def _part_for(self, message: Message) -> McapSink:
        span = self._clock.at(message.sent_ns) // self._split_ns if self._split_ns else 0
        if not self.parts:
            self._begin(span)
        elif self._is_full(span):
            self.parts[-1].close()
            self._begin(span)
        return self.parts[-1]

    def _is_full(self, span: int) -> bool:
        return span != self._span or (self._split_bytes is not None and self.parts[-1].written >= self._split_bytes)

    def _begin(self, span: int) -> None:
        self._span = span
        if self._split_bytes is None and self._split_ns is None:
            path, provenance = self.path, self._provenance
        else:
            number = len(self.parts)
            path = self.path.with_name(f"{self.path.stem}_{number}{self.path.suffix}")
            provenance = {**self._provenance, PART: str(number)}
            if number:  # the folder may have been removed since
                make_folder(path.parent)
        most = min(CHUNK_BYTES, self._split_bytes or CHUNK_BYTES)
        self.parts.append(McapSink(path, provenance, chunk_bytes=most, clock=self._clock))


def _noted_part(file: Path) -> str | None:
    from .mcap_records import leading_metadata

    try:
        with opened(file) as stream:
            return leading_metadata(stream, PROVENANCE).get(PART)
    except Exception:  # the reader may raise anything for another kind of file
        return None
