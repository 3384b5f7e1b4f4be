"""ROS 2 messages from an MCAP recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from graph.base.errors import RunError, UserError, reason_of
from graph.base.inputs import opened
from graph.base.limits import OverLimit, check
from graph.sim.messages.bus import topic_name
from graph.sim.messages.ros_types import known, register

from .mcap_records import Summary, messages, read_metadata, read_summary
from .recorded_file import RecordedFile, clamped, decoding
from .recovery import MAGIC, scan
from .sources import Entry

NOT_FINISHED = "the recording was not finished, so it has no index; rebuild it: graph recover FILE"
PROVENANCE = "tickgraph"
"""Name of the MCAP metadata with the source of a recording."""
ENCODING = "cdr"
SCHEMAS = "ros2msg"


class McapSource(RecordedFile):
    """The CDR messages of the MCAP file `path`, by log time, read when they are needed, never all at once.

    Types that this project does not know come from the file's own definitions. `provenance`: the file's metadata of
    that name; `channels`: the metadata of each topic's channel. whole: refuse a file that was not finished; otherwise
    its whole chunks are read, and `unfinished` says so. Chunks without a wanted topic are not read. Raises UserError
    if the file is not a readable MCAP file.
    """

    def __init__(self, path: str | Path, *, whole: bool = True) -> None:
        super().__init__(path)
        self._summary: Any = None
        self._defined = 0
        self._files: list[BinaryIO] = []
        try:
            with opened(path) as file:
                self._examine(file, whole)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; name an MCAP recording that can be read") from None
        except OverLimit as error:
            raise UserError(f"{path}: {error}") from None
        except UserError:
            raise
        except Exception as error:  # the reader may raise anything for a damaged file
            raise UserError(f"{path}: {_why_unreadable(Path(path), error)}") from None

    def _read(self, wanted: Mapping[str, str]) -> Iterator[Entry]:
        summary = self._summary
        channels = {
            number: (topic_name(channel.topic), summary.schemas[channel.schema_id].name)
            for number, channel in summary.channels.items()
            if channel.schema_id in summary.schemas
        }
        channels = {number: named for number, named in channels.items() if wanted.get(named[0]) == named[1]}
        with opened(self.name) as file:
            self._files.append(file)
            try:
                for message in self._undamaged(messages(file, summary, channels)):
                    topic, name = channels[message.channel_id]
                    load = decoding(message.data, name, self.name)
                    yield Entry(
                        clamped(message.log_time), topic, name, load, clamped(message.publish_time), len(message.data)
                    )
            finally:
                if file in self._files:
                    self._files.remove(file)

    def _undamaged(self, found: Iterator[Any]) -> Iterator[Any]:
        try:
            yield from found
        except OverLimit as error:
            raise RunError(f"{self.name}: {error}") from error
        except Exception as error:  # the reader may raise anything for damaged content
            raise RunError(f"{self.name}: the recording is damaged ({reason_of(error)})") from error

    def close(self) -> None:
        """Closes the file; calling it twice is harmless."""
        while self._files:
            self._files.pop().close()

    def _examine(self, file: BinaryIO, whole: bool) -> None:
        summary = _summary(file)
        if summary is None:
            if whole:
                raise UserError(f"{self.name}: {NOT_FINISHED}")
            summary = scan(file, Path(self.name))
            self.unfinished = f"{self.name}: {NOT_FINISHED.replace('FILE', self.name)}"
        self._summary, self._start_ns = summary, clamped(summary.start_ns)
        self.provenance = read_metadata(file, summary, PROVENANCE)
        for number, channel in summary.channels.items():
            schema = summary.schemas.get(channel.schema_id)
            why = self._unreadable(channel.message_encoding, schema)
            topic = topic_name(channel.topic)
            if self._note(topic, schema.name if schema else "", summary.counts.get(number, 0), why):
                self.channels.setdefault(topic, dict(channel.metadata))

    def _unreadable(self, encoding: str, schema: Any) -> str:
        """Why a channel cannot be read; "" if it can."""
        if encoding != ENCODING or schema is None:
            return f"its messages are encoded as {encoding or 'nothing known'}, not as {ENCODING}"
        if known(schema.name):
            return ""
        if schema.encoding != SCHEMAS:
            return f"its type {schema.name} is unknown and defined as {schema.encoding}, not as {SCHEMAS}"
        self._defined += len(schema.data)
        try:
            check("recording.definitions", self._defined, f"its types take {self._defined:,} bytes of definitions")
            register(schema.name, schema.data.decode("utf-8", "replace"))
        except ValueError as error:
            return str(error)
        return ""


def _summary(file: BinaryIO) -> Summary | None:
    """The summary of a file; None if it starts as a recording and was not finished."""
    try:
        return read_summary(file)
    except OverLimit:
        raise
    except Exception:
        if _is_cut(file):
            return None
        raise


def _is_cut(file: BinaryIO) -> bool:
    """Whether a file starts as a recording and does not end as one."""
    file.seek(0)
    start = file.read(len(MAGIC))
    file.seek(max(file.seek(0, 2) - len(MAGIC), 0))
    return start == MAGIC and file.read() != MAGIC


def _why_unreadable(path: Path, error: Exception) -> str:
    if not path.stat().st_size:
        return "the file is empty; nothing was recorded"
    return f"not a whole MCAP recording ({reason_of(error)})"
