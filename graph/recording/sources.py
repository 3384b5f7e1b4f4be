"""Messages from outside: sources put them on the App's bus when simulation time reaches their time.

    player = Player(app, [MemorySource([(0.5, "/cmd_vel", "geometry_msgs/msg/Twist", twist)])])

A message of time t arrives in the first physics step whose time is t or later, ahead of everything that is evaluated on
that step or in that update. Only topics with a listener are decoded and put on the bus. A new play starts from the
beginning; while the timeline is paused no message arrives.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol

from graph.base.exact import duration, nanoseconds
from graph.sim.messages.bus import topic_name

if TYPE_CHECKING:
    from graph.sim.app import App

WALL_CLOCK_NS = 365 * 86_400 * 10**9
"""Times from here on count from 1970, not from the start of a run: no run is as long as a year."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One message of a source: its time [ns] in the source's own count, topic, type, and a function that loads it.

    stamp_ns: the stamp of its header [ns], where the source has it; size: bytes of the encoded message.
    """

    time_ns: int
    topic: str
    type_name: str
    load: Callable[[], Any]
    stamp_ns: int | None = None
    size: int = 0


class Source(Protocol):
    """Messages in the order of their times; each iteration starts from the beginning."""

    name: str
    """Its name in messages to the user."""

    def topics(self) -> Mapping[str, str]:
        """Its topics (with a leading slash) and their types."""

    def start_ns(self) -> int:
        """The time of its first message [ns]; 0 without messages."""

    def __iter__(self) -> Iterator[Entry]: ...

    def close(self) -> None:
        """Frees its resources; calling it twice is harmless."""


class MemorySource:
    """Messages from a list of (time, topic, type, message).

    time: seconds as a Fraction, text or float, taken as the shortest decimal that gives it; equal times stay in the
    order of the list.
    """

    def __init__(
        self, messages: Iterable[tuple[Fraction | float | str, str, str, Any]], *, name: str = "a list of messages"
    ) -> None:
        self.name = name
        entries = [
            Entry(nanoseconds(duration(time)), topic_name(topic), type_name, _giving(message))
            for time, topic, type_name, message in messages
        ]
        self._entries = sorted(entries, key=lambda entry: entry.time_ns)

    def topics(self) -> Mapping[str, str]:
        """Its topics and their types."""
        return {entry.topic: entry.type_name for entry in self._entries}

    def start_ns(self) -> int:
        """The time of its first message [ns]."""
        return self._entries[0].time_ns if self._entries else 0

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries)

    def close(self) -> None:
        """Does nothing."""


class RemappedSource:
    """A source whose messages come on other topics; topics that `remap` does not name stay."""

    def __init__(self, source: Source, remap: Mapping[str, str]) -> None:
        self.name = source.name
        self.files = getattr(source, "files", ())
        self.skipped = getattr(source, "skipped", {})
        self._source, self._remap = source, remap

    def topics(self) -> Mapping[str, str]:
        """The topics on which its messages come, and their types."""
        return {self._remap.get(topic, topic): type_name for topic, type_name in self._source.topics().items()}

    def start_ns(self) -> int:
        """The time of its first message [ns]."""
        return self._source.start_ns()

    def __iter__(self) -> Iterator[Entry]:
        for entry in self._source:
            yield replace(entry, topic=self._remap.get(entry.topic, entry.topic))

    def close(self) -> None:
        """Frees the source's resources."""
        self._source.close()


class Player:
    """Plays sources into an App; several are merged by time, equal times in the order of the sources.

    Times from 1971 on are those of a wall clock: such sources share one start, the earliest of their first messages,
    which becomes time 0. All other times count from play. `close` (also done by the App's close) ends it.
    """

    def __init__(self, app: App, sources: Sequence[Source]) -> None:
        self._app, self._sources = app, tuple(sources)
        starts = [source.start_ns() for source in self._sources]
        wall = [start for start in starts if start >= WALL_CLOCK_NS]
        epoch = min(wall, default=0)
        self._shifts = [epoch if start >= WALL_CLOCK_NS else 0 for start in starts]
        self._coming: Iterator[tuple[int, Entry]] = iter(())
        self._next: tuple[int, Entry] | None = None
        self._unsubscribe = [
            app.on("play", self._rewind, order=-1),
            app.on("stop", self._halt),
            # Ahead of the clock's own bookkeeping, so that what is evaluated on the step finds the messages.
            app.on("physics_post_step", self._deliver, order=-1),
            app.on("close", self.close),
        ]
        self._closed = False
        if not app.timeline.is_stopped():
            self._rewind()

    def unheard(self) -> list[tuple[str, str]]:
        """(source, reason) of the sources without any listener; call it while the App plays."""
        bus = self._app.bus
        silent = []
        for source in self._sources:
            topics = source.topics()
            if not any(bus.is_listened_to(topic) for topic in topics):
                listed = ", ".join(sorted(topics)[:5]) or "no topics"
                more = f" and {len(topics) - 5} more" if len(topics) > 5 else ""
                heard = ", ".join(sorted(bus.listened())[:5])
                instead = f"; subscribers listen to {heard}" if heard else ""
                silent.append((source.name, f"nobody listened to any of its topics: {listed}{more}{instead}"))
        return silent

    def close(self) -> None:
        """Stops playing and closes the sources; calling it twice is harmless."""
        if self._closed:
            return
        self._closed = True
        self._halt()
        for unsubscribe in self._unsubscribe:
            unsubscribe()
        for source in self._sources:
            source.close()

    def _rewind(self) -> None:
        streams = [_shifted(source, shift) for source, shift in zip(self._sources, self._shifts, strict=True)]
        self._coming = heapq.merge(*streams, key=lambda timed: timed[0])
        self._next = next(self._coming, None)

    def _halt(self) -> None:
        self._coming, self._next = iter(()), None

    def _deliver(self) -> None:
        if self._next is None:
            return
        clock = self._app.simulation.clock
        reached = nanoseconds((clock.count + 1) / clock.rate)
        while self._next is not None and self._next[0] <= reached:
            time_ns, entry = self._next
            self._app.bus.offer(entry.topic, entry.type_name, time_ns, entry.load)
            self._next = next(self._coming, None)


def _shifted(source: Source, shift_ns: int) -> Iterator[tuple[int, Entry]]:
    for entry in source:
        yield entry.time_ns - shift_ns, entry


def _giving(message: Any) -> Callable[[], Any]:
    return lambda: message
