"""ROS 2 messages from an MCAP recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from graph.base.errors import RunError, UserError, reason_of
from graph.base.limits import OverLimit, check

from .bus import topic_name
from .ros_types import deserialize, known, least_part, register
from .sources import Entry

MAGIC = b"\x89MCAP0\r\n"
NOT_FINISHED = "the recording was not finished, so it has no index; rebuild it: graph recover FILE"
ENCODING = "cdr"
SCHEMAS = "ros2msg"


class McapSource:
    """The CDR messages of the MCAP file `path`, by log time, read when they are needed, never all at once.

    Types that this project does not know come from the file's own definitions. `skipped` says which topics cannot be
    read, and why. Raises UserError if the file is not a readable MCAP file.
    """

    def __init__(self, path: str | Path) -> None:
        self.name = str(path)
        self.skipped: dict[str, str] = {}
        self._types: dict[str, str] = {}
        self._start_ns = 0
        self._summary: Any = None
        self._defined = 0
        self._files: list[BinaryIO] = []
        try:
            with Path(path).open("rb") as file:
                self._examine(file)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; name an MCAP recording that can be read") from None
        except OverLimit as error:
            raise UserError(f"{path}: {error}") from None
        except UserError:
            raise
        except Exception as error:  # the reader may raise anything for a damaged file
            raise UserError(f"{path}: {_why_unreadable(Path(path), error)}") from None

    def topics(self) -> Mapping[str, str]:
        """The topics that can be read and their types."""
        return self._types

    def start_ns(self) -> int:
        """The log time of the first message of the file [ns]."""
        return self._start_ns

    def __iter__(self) -> Iterator[Entry]:
        if not self._types:
            return
        from .mcap_records import messages

        with Path(self.name).open("rb") as file:
            self._files.append(file)
            for schema, channel, message in self._undamaged(messages(file, self._summary)):
                topic = topic_name(channel.topic)
                if schema is not None and self._types.get(topic) == schema.name:
                    yield Entry(message.log_time, topic, schema.name, decoding(message.data, schema.name, self.name))

    def _undamaged(self, found: Iterator[tuple[Any, Any, Any]]) -> Iterator[tuple[Any, Any, Any]]:
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

    def _examine(self, file: BinaryIO) -> None:
        from .mcap_records import read_summary

        summary = read_summary(file)
        if summary is None:
            raise UserError(f"{self.name}: {NOT_FINISHED}")
        self._summary, self._start_ns = summary, summary.start_ns
        for channel in summary.channels.values():
            schema = summary.schemas.get(channel.schema_id)
            why = self._unreadable(channel.message_encoding, schema)
            topic = topic_name(channel.topic)
            if why or schema is None:
                self.skipped[topic] = why
            elif self._types.setdefault(topic, schema.name) != schema.name:
                self.skipped[topic] = f"it also has messages of type {schema.name}"

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


def _why_unreadable(path: Path, error: Exception) -> str:
    """Whether a file starts as a recording and is incomplete, or is another kind of file."""
    with path.open("rb") as file:
        start, size = file.read(len(MAGIC)), path.stat().st_size
        file.seek(max(size - len(MAGIC), 0))
        end = file.read()
    if start == MAGIC and end != MAGIC:
        return NOT_FINISHED
    return f"not a whole MCAP recording ({reason_of(error)})"


def decoding(data: bytes, type_name: str, name: str) -> Callable[[], Any]:
    """The decoder of the CDR bytes of messages in the file `name`; it raises RunError for damaged bytes."""

    def load() -> Any:
        part = least_part(type_name)
        try:
            what = f"a message of type {type_name} may hold {len(data) // max(part, 1):,} texts and messages"
            check("recording.parts", len(data) // part if part else 0, what)
            return deserialize(data, type_name)
        except OverLimit as error:
            raise RunError(f"{name}: {error}") from error
        except Exception as error:
            raise RunError(f"{name}: a message of type {type_name} cannot be decoded ({reason_of(error)})") from error

    return load
