"""Writes trace events, the JSON that Chrome and Perfetto read, during the run."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TextIO

WALL, TIMELINE, PHYSICS, RENDERER = 1, 2, 3, 4
_GROUPS = {WALL: "wall time", TIMELINE: "timeline", PHYSICS: "physics", RENDERER: "renderer"}
_BUFFERED = 4096
"""Events that are buffered before they are written."""

Event = dict[str, Any]


class TraceWriter:
    """Writes trace events as a JSON array, some thousands at a time; a truncated file can still be read.

    `failed` is called with the error if the file cannot be written; from then on nothing is written.
    """

    def __init__(self, stream: TextIO, failed: Callable[[OSError], object]) -> None:
        self._stream = stream
        self._failed = failed
        self._pending: list[Event] = []
        self._tracks: dict[tuple[int, str], int] = {}
        self._written = 0
        self._closed = False
        for group, name in _GROUPS.items():
            self.add({"ph": "M", "pid": group, "tid": 0, "name": "process_name", "args": {"name": name}})
            self.add({"ph": "M", "pid": group, "tid": 0, "name": "process_sort_index", "args": {"sort_index": group}})

    def track(self, group: int, name: str) -> int:
        """The number of a track in a group, created at first use."""
        number = self._tracks.get((group, name))
        if number is None:
            number = self._tracks[group, name] = len(self._tracks) + 1
            about = {"ph": "M", "pid": group, "tid": number}
            self.add({**about, "name": "thread_name", "args": {"name": name}})
            self.add({**about, "name": "thread_sort_index", "args": {"sort_index": number}})
        return number

    def slice(self, group: int, track: int, name: str, start_us: float, length_us: float, **args: Any) -> None:
        """An interval, in microseconds."""
        self.add({"ph": "X", "pid": group, "tid": track, "name": name, "ts": start_us, "dur": length_us, "args": args})

    def instant(self, group: int, track: int, name: str, at_us: float, **args: Any) -> None:
        """A single moment, in microseconds."""
        self.add({"ph": "i", "s": "t", "pid": group, "tid": track, "name": name, "ts": at_us, "args": args})

    def curve(self, name: str, at_us: float, **values: float) -> None:
        """Values at a moment of wall time."""
        self.add({"ph": "C", "pid": WALL, "tid": 0, "name": name, "ts": at_us, "args": values})

    def add(self, event: Event) -> None:
        """Adds one event; after `close` events are dropped."""
        if self._closed:
            return
        self._pending.append(event)
        if len(self._pending) >= _BUFFERED:
            self.flush()

    def flush(self) -> None:
        """Writes the buffered events."""
        pending, self._pending = self._pending, []
        lines = [json.dumps(event, separators=(",", ":"), default=str) for event in pending]
        if lines:
            self._write((",\n" if self._written else "[\n") + ",\n".join(lines))
            self._written += len(lines)

    def close(self) -> None:
        """Ends the array and closes the stream; calling it twice is harmless."""
        if not self._closed:
            self.flush()
            self._write("\n]\n")
            self._end()

    def _write(self, text: str) -> None:
        if not self._closed:
            try:
                self._stream.write(text)
            except OSError as error:
                self._end()
                self._failed(error)

    def _end(self) -> None:
        self._closed = True
        with suppress(OSError):
            self._stream.close()
