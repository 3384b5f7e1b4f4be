"""ROS 2 messages from a rosbag2 recording in SQLite: a `.db3` file."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rosbags.interfaces import MessageDefinitionFormat  # noqa: TID253
from rosbags.rosbag2 import Reader  # noqa: TID253

from graph.base.errors import RunError, UserError, reason_of
from graph.base.limits import check

from .bus import topic_name
from .recorded_file import RecordedFile, decoding
from .ros_types import known, register
from .sources import Entry


class BagSource(RecordedFile):
    """The CDR messages of the file `path` (.db3), by time, read when they are needed.

    Types that this project does not know come from the file's own definitions, if it has them. Raises UserError if the
    file is not a readable rosbag2 file.
    """

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        try:
            _check_tables(Path(path))
            with Reader(Path(path)) as reader:
                self._examine(reader)
        except UserError:
            raise
        except Exception as error:  # the reader may raise anything for a damaged file
            raise UserError(f"{path}: not a readable rosbag2 recording ({reason_of(error)})") from None

    def _read(self, wanted: Mapping[str, str]) -> Iterator[Entry]:
        with Reader(Path(self.name)) as reader:
            chosen = [one for one in reader.connections if wanted.get(topic_name(one.topic)) == one.msgtype]
            for connection, time_ns, data in self._undamaged(reader, chosen):
                load = decoding(data, connection.msgtype, self.name)
                yield Entry(time_ns, topic_name(connection.topic), connection.msgtype, load, size=len(data))

    def _undamaged(self, reader: Reader, connections: list[Any]) -> Iterator[tuple[Any, int, bytes]]:
        try:
            yield from reader.messages(connections) if connections else ()
        except Exception as error:  # the reader may raise anything for damaged content
            raise RunError(f"{self.name}: the recording is damaged ({reason_of(error)})") from error

    def _examine(self, reader: Reader) -> None:
        self._start_ns = reader.start_time if reader.message_count else 0
        for connection in reader.connections:
            topic = topic_name(connection.topic)
            self._note(topic, connection.msgtype, connection.msgcount, _unreadable(connection))


def _check_tables(path: Path) -> None:
    """Refuses a database with views, because the query of a view may run endlessly."""
    with path.open("rb"):  # the reason why a file cannot be opened
        pass
    database = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        kinds = dict(database.execute("SELECT name, type FROM sqlite_master"))
    finally:
        database.close()
    if any(kind in ("view", "trigger") for kind in kinds.values()):
        raise UserError(f"{path}: the database has views or triggers, which no rosbag2 recording has; it is refused")


def _unreadable(connection: Any) -> str:
    """Why a topic cannot be read; "" if it can."""
    if connection.ext.serialization_format != "cdr":
        return f"its messages are encoded as {connection.ext.serialization_format}, not as cdr"
    if known(connection.msgtype):
        return ""
    definition = connection.msgdef
    if definition.format != MessageDefinitionFormat.MSG:
        return f"its type {connection.msgtype} is unknown, and the recording does not define it"
    try:
        check("recording.definitions", len(definition.data), f"its type takes {len(definition.data):,} bytes")
        register(connection.msgtype, definition.data)
    except ValueError as error:
        return str(error)
    return ""
