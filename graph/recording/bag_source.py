"""ROS 2 messages from a rosbag2 recording in SQLite: a `.db3` file.

The file may come from a stranger. It is read as SQLite advises for such files (https://www.sqlite.org/security.html),
from plain tables and stored columns only; what one pass may read and compute grows with the file's size.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from graph.base.errors import RunError, UserError, reason_of
from graph.base.inputs import opened
from graph.base.limits import OverLimit, check, most
from graph.sim.messages.bus import topic_name
from graph.sim.messages.ros_types import known, register

from .recorded_file import RecordedFile, decoding
from .sources import Entry

_TABLES = {
    "messages": ("topic_id", "timestamp", "data"),
    "topics": ("id", "name", "type", "serialization_format"),
}
"""The columns that a recording has; those of definitions and of the schema's version are younger."""
_DEFINITIONS = ("topic_type", "encoding", "encoded_message_definition")
STEPS_A_BYTE, FEWEST_STEPS, _LOOK = 32, 1_000_000, 10_000
"""Steps of SQLite's machine: a row of a few bytes takes some thirty."""
_DAMAGED = "it has more rows than bytes for them"
_VIRTUAL = re.compile(r"\b(virtual|generated)\b", re.IGNORECASE)


class BagSource(RecordedFile):
    """The CDR messages of the file `path` (.db3), by time, read when they are needed.

    Types that this project does not know come from the file's own definitions, if it has them. Raises UserError if the
    file is not a readable rosbag2 file.
    """

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        self._defined = 0
        try:
            with closing(_connected(Path(path))) as database:
                self._examine(database)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror}; name a recording that can be read") from None
        except OverLimit as error:
            raise UserError(f"{path}: {error}") from None
        except UserError:
            raise
        except (sqlite3.Error, ValueError) as error:
            raise UserError(f"{path}: not a readable rosbag2 recording ({_reason(error)})") from None

    def _read(self, wanted: Mapping[str, str]) -> Iterator[Entry]:
        try:
            with closing(_connected(Path(self.name))) as database:
                topics = {
                    number: (topic, type_name)
                    for number, topic, type_name, _ in _topics(database)
                    if wanted.get(topic) == type_name
                }
                for number, time_ns, data in _messages(database, Path(self.name).stat().st_size, topics):
                    topic, type_name = topics[number]
                    yield Entry(time_ns, topic, type_name, decoding(data, type_name, self.name), size=len(data))
        except OverLimit as error:
            raise RunError(f"{self.name}: {error}") from error
        except (sqlite3.Error, ValueError, OSError) as error:
            raise RunError(f"{self.name}: the recording is damaged ({_reason(error)})") from error

    def _examine(self, database: sqlite3.Connection) -> None:
        _check_tables(database, self.name)
        definitions = _definitions(database)
        counts: dict[Any, int] = {}
        starts = []
        summed = (
            "SELECT topic_id, count(*), min(timestamp), sum(typeof(timestamp) != 'integer') FROM messages GROUP BY 1"
        )
        for number, count, start, others in database.execute(summed):
            if others:
                raise ValueError(f"{others:,} of its time stamps are not whole numbers")
            counts[number] = count
            starts.append(start)
        self._start_ns = min(starts, default=0)
        for number, topic, type_name, encoding in _topics(database):
            self._note(topic, type_name, counts.get(number, 0), self._unreadable(type_name, encoding, definitions))

    def _unreadable(self, type_name: str, encoding: str, definitions: Mapping[str, tuple[str, str]]) -> str:
        """Why a topic cannot be read; "" if it can."""
        if encoding != "cdr":
            return f"its messages are encoded as {encoding}, not as cdr"
        if known(type_name):
            return ""
        form, text = definitions.get(type_name, ("", ""))
        if form != "ros2msg":
            return f"its type {type_name} is unknown, and the recording does not define it"
        self._defined += len(text)
        try:
            check("recording.definitions", self._defined, f"its types take {self._defined:,} bytes of definitions")
            register(type_name, text)
        except ValueError as error:
            return str(error)
        return ""


def _connected(path: Path) -> sqlite3.Connection:
    """The open database, within limits of cells and of work. Raises OSError unless it is a regular file."""
    with opened(path) as file:
        size = file.seek(0, 2)
    place = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    database = sqlite3.connect(place, uri=True, isolation_level=None, check_same_thread=False)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, most("recording.record"))
    for pragma in ("trusted_schema=OFF", "query_only=ON", "cell_size_check=ON", "mmap_size=0", "temp_store=MEMORY"):
        database.execute(f"PRAGMA {pragma}")
    left = (FEWEST_STEPS + STEPS_A_BYTE * size) // _LOOK

    def spent() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    database.set_progress_handler(spent, _LOOK)
    return database


def _check_tables(database: sqlite3.Connection, name: str) -> None:
    """Refuses a database whose reading would compute what it stores: views, virtual tables, generated columns."""
    for kind, text in database.execute("SELECT type, sql FROM sqlite_master"):
        if kind in ("view", "trigger"):
            raise UserError(
                f"{name}: the database has views or triggers, which no rosbag2 recording has; it is refused"
            )
        if kind == "table" and _VIRTUAL.search(str(text)):
            raise UserError(f"{name}: the database has virtual tables or columns, which no rosbag2 recording has")
    for table, columns in _TABLES.items():
        stored = _stored(database, table)
        if missing := [one for one in columns if one not in stored]:
            raise ValueError(f"its table {table} has no stored {', '.join(missing)}")


def _stored(database: sqlite3.Connection, table: str) -> set[str]:
    """The plain columns of a table; those that are computed or hidden are left out."""
    return {row[1] for row in database.execute(f"PRAGMA table_xinfo({table})") if row[6] == 0}


def _topics(database: sqlite3.Connection) -> Iterator[tuple[int, str, str, str]]:
    """Number, name, type and encoding of each topic."""
    for number, *texts in database.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id"):
        if not isinstance(number, int) or not all(isinstance(one, str) for one in texts):
            raise ValueError("its table topics holds what is not a number, a name, a type and an encoding")
        name, type_name, encoding = texts
        yield number, topic_name(name), type_name, encoding


def _definitions(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """By type: how it is defined, and its definition."""
    if not _stored(database, "message_definitions").issuperset(_DEFINITIONS):
        return {}
    found: dict[str, tuple[str, str]] = {}
    for row in database.execute(f"SELECT {', '.join(_DEFINITIONS)} FROM message_definitions"):
        if all(isinstance(one, str) for one in row):
            found.setdefault(row[0], row[1:])
            total = sum(len(text) for _, text in found.values())
            check("recording.definitions", total, f"its types take {total:,} bytes of definitions")
    return found


def _messages(
    database: sqlite3.Connection, size: int, topics: Mapping[int, object]
) -> Iterator[tuple[int, int, bytes]]:
    """Topic, time [ns] and bytes of each message of these topics, by time. size: of the file, which all of them fit
    into.
    """
    # The bytes are fetched one by one, so that sorting holds numbers alone.
    numbers = "SELECT _rowid_, topic_id, timestamp, length(data) FROM messages ORDER BY timestamp, _rowid_"
    for row, topic, time_ns, length in database.execute(numbers):
        if topic not in topics:
            continue
        check("recording.record", length or 0, f"a message of it has {length} bytes")
        (data,) = database.execute("SELECT data FROM messages WHERE _rowid_ = ?", (row,)).fetchone() or (None,)
        if not isinstance(data, bytes) or not isinstance(time_ns, int):
            raise ValueError("it has messages that are not bytes at a time")
        size -= len(data)
        if size < 0:
            raise ValueError(_DAMAGED)
        yield topic, time_ns, data


def _reason(error: Exception) -> str:
    return _DAMAGED if str(error) == "interrupted" else reason_of(error)
