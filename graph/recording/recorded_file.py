"""A recorded file as a source of messages: its topics, what cannot be read, and how its bytes are decoded."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from graph.base.errors import RunError, reason_of
from graph.base.limits import OverLimit, check
from graph.sim.messages.ros_types import deserialize, least_part

from .sources import Entry

_LATEST_NS = 2**63 - 1


class RecordedFile:
    """The base of the readers of each format; they fill it when they open a file.

    Each iteration opens the file again. `skipped` says which topics cannot be read, and why; `counts`: messages by
    topic; `channels`: metadata by topic, if the format has it; `provenance`: what the file says of its source;
    `unfinished`: why a part is missing.
    """

    def __init__(self, path: str | Path) -> None:
        self.name = str(path)
        self.skipped: dict[str, str] = {}
        self.counts: dict[str, int] = {}
        self.provenance: dict[str, str] = {}
        self.channels: dict[str, dict[str, str]] = {}
        self.unfinished = ""
        self._types: dict[str, str] = {}
        self._start_ns = 0

    def topics(self) -> Mapping[str, str]:
        """The topics that can be read and their types."""
        return self._types

    def start_ns(self) -> int:
        """The time of the first message of the file [ns]; 0 without messages."""
        return self._start_ns

    def __iter__(self) -> Iterator[Entry]:
        return self.read()

    def read(self, topics: Collection[str] | None = None) -> Iterator[Entry]:
        """The messages of these topics (default: of all), by time."""
        wanted = {topic: name for topic, name in self._types.items() if topics is None or topic in topics}
        if wanted:
            yield from self._read(wanted)

    def close(self) -> None:
        """Frees what unfinished iterations hold; calling it twice is harmless."""

    def _read(self, wanted: Mapping[str, str]) -> Iterator[Entry]:
        """The messages of these topics, each with its type, by time."""
        raise NotImplementedError

    def _note(self, topic: str, type_name: str, count: int, why: str) -> bool:
        """Notes a channel with so many messages, and why it cannot be read; whether it can."""
        if not why and self._types.setdefault(topic, type_name) != type_name:
            why = f"it also has messages of type {type_name}"
        if why:
            self.skipped[topic] = why
        else:
            self.counts[topic] = self.counts.get(topic, 0) + count
        return not why


def clamped(time_ns: int) -> int:
    """A time of a recording [ns] within 63 bits; those of MCAP have 64."""
    return min(time_ns, _LATEST_NS)


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
