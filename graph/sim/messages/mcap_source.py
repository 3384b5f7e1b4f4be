"""ROS 2 messages from an MCAP recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from graph.base.errors import RunError, UserError

from .bus import topic_name
from .ros_types import deserialize, known, register
from .sources import Entry

if TYPE_CHECKING:
    from mcap.reader import McapReader

ENCODING = "cdr"
SCHEMAS = "ros2msg"
MOST_SCHEMA_BYTES = 100_000


class McapSource:
    """The CDR messages of the MCAP file `path`, by log time; read as they are needed, never all at once.

    Types that this project does not know come from the file's own definitions. `skipped` tells of topics that cannot
    be read, and why. Raises UserError if the file is no readable MCAP file.
    """

    def __init__(self, path: str | Path) -> None:
        self.name = str(path)
        self.skipped: dict[str, str] = {}
        self._types: dict[str, str] = {}
        self._start_ns = 0
        self._files: list[BinaryIO] = []
        try:
            with Path(path).open("rb") as file:
                self._examine(_reader(file))
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; name an MCAP recording that can be read") from None
        except UserError:
            raise
        except Exception as error:  # whatever a damaged file makes of the reader
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise UserError(f"{path}: not a whole MCAP recording ({reason})") from None

    def topics(self) -> Mapping[str, str]:
        """The topics that can be read and their types."""
        return self._types

    def start_ns(self) -> int:
        """The log time of the first message of the file [ns]."""
        return self._start_ns

    def __iter__(self) -> Iterator[Entry]:
        if not self._types:
            return
        with Path(self.name).open("rb") as file:
            self._files.append(file)
            for schema, channel, message in self._records(file):
                topic = topic_name(channel.topic)
                if schema is not None and self._types.get(topic) == schema.name:
                    yield Entry(message.log_time, topic, schema.name, _decoding(message.data, schema.name, self.name))

    def _records(self, file: BinaryIO) -> Iterator[tuple[Any, Any, Any]]:
        try:
            yield from _reader(file).iter_messages()
        except Exception as error:  # whatever damaged content makes of the reader
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise RunError(f"{self.name}: the recording is damaged ({reason})") from error

    def close(self) -> None:
        """Closes the file; calling it twice is harmless."""
        while self._files:
            self._files.pop().close()

    def _examine(self, reader: McapReader) -> None:
        summary = reader.get_summary()
        if summary is None:
            raise UserError(f"{self.name}: the recording has no summary: it was not finished; repair it: mcap recover")
        if summary.statistics is not None:
            self._start_ns = summary.statistics.message_start_time
        for channel in summary.channels.values():
            schema = summary.schemas.get(channel.schema_id)
            why = _unreadable(channel.message_encoding, schema)
            topic = topic_name(channel.topic)
            if why or schema is None:
                self.skipped[topic] = why
            elif self._types.setdefault(topic, schema.name) != schema.name:
                self.skipped[topic] = f"it also has messages of type {schema.name}"


def _unreadable(encoding: str, schema: Any) -> str:
    """Why a channel cannot be read; "" if it can."""
    if encoding != ENCODING or schema is None:
        return f"its messages are encoded as {encoding or 'nothing known'}, not as {ENCODING}"
    if known(schema.name):
        return ""
    if schema.encoding != SCHEMAS:
        return f"its type {schema.name} is unknown and defined as {schema.encoding}, not as {SCHEMAS}"
    if len(schema.data) > MOST_SCHEMA_BYTES:
        return f"the definition of {schema.name} has {len(schema.data)} bytes; {MOST_SCHEMA_BYTES} are read at most"
    try:
        register(schema.name, schema.data.decode("utf-8", "replace"))
    except ValueError as error:
        return str(error)
    return ""


def _reader(file: BinaryIO) -> McapReader:
    from mcap.reader import make_reader

    return make_reader(file)


def _decoding(data: bytes, type_name: str, name: str) -> Callable[[], Any]:
    def load() -> Any:
        try:
            return deserialize(data, type_name)
        except Exception as error:
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise RunError(f"{name}: a message of type {type_name} cannot be decoded ({reason})") from error

    return load
