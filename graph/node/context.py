"""What the nodes of one evaluation can read about time and the world, and where their warnings go."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

from graph.base import exact
from graph.base.memory_budget import Room
from graph.base.records import dataclass, field
from graph.base.warning_keys import Key, key_of

from .events import EventBus

if TYPE_CHECKING:
    from graph.sim.app import App


@dataclass(slots=True)
class Warned:
    """One warning and how often it came: a stable code, the node or prim it is about, the first message."""

    code: str
    where: str
    message: str
    count: int = 1


class WarningLog:
    """Collects warnings, one entry for each code and place (and for each text that a node's author wrote)."""

    def __init__(self) -> None:
        self._entries: dict[Key, Warned] = {}

    def __call__(self, code: str, where: str, message: str) -> None:
        """Adds a warning, or counts it again."""
        key = key_of(code, where, message, self._entries)
        known = self._entries.get(key)
        if known is None:
            self._entries[key] = Warned(code, where, message)
        else:
            known.count += 1

    def __iter__(self) -> Iterator[Warned]:
        return iter(self._entries.values())

    def __len__(self) -> int:
        return len(self._entries)


Warn = Callable[[str, str, str], None]
"""Takes a code, a place and a message."""

Scripts = Literal["refuse", "skip", "run"]
"""What happens to a node that would run code of its graph file: it fails, does nothing, or runs the code."""


@dataclass(slots=True)
class Context:
    """Time and world as one evaluation sees them. Seconds are floats, for nodes; the exact values are fields as well.

    delta: how far the timeline moved in this update; loop_delta: planned length of the update; exact_time: timeline
    time; since_start: loop time since the app started, playing or not; absolute: simulation time that a stop does not
    reset; frames_per_second: time codes per second; update: index of the app update; events: the queue of events
    between nodes and scripts; room: the memory budget of large values.

    warn: takes code, place and message of a warning. scripts: what happens to a node that would run code of the graph
    file: it fails, does nothing, or runs it (see `graph.evaluate.script_permission`). closing: whether the App is about
    to close. asked: whether a program may read any output at any time, so that all are wanted. frame_time: the
    time, on the renderer's clock, of the frame whose post-render graphs are evaluated; None in other graphs.
    """

    app: App | None = None
    warn: Warn = field(default_factory=WarningLog)
    is_playing: bool = False
    delta: Fraction = Fraction(0)
    loop_delta: Fraction = Fraction(1, 60)
    exact_time: Fraction = Fraction(0)
    since_start: Fraction = Fraction(0)
    absolute: Fraction = Fraction(0)
    frames_per_second: Fraction = Fraction(60)
    update: int = 0
    events: EventBus = field(default_factory=EventBus)
    room: Room = field(default_factory=Room)
    scripts: Scripts = "refuse"
    closing: bool = False
    asked: bool = False
    frame_time: Fraction | None = None

    @classmethod
    def standalone(cls, loop_hz: float | str | Fraction = 60) -> Context:
        """A context without an App, always playing; `advance` moves its clock by one update of 1/loop_hz."""
        step = 1 / exact.rate(loop_hz)
        return cls(is_playing=True, delta=step, loop_delta=step, update=-1)

    def advance(self) -> None:
        """Moves a standalone context to its next update; the first one ends at 1/loop_hz."""
        self.update += 1
        self.since_start += self.loop_delta
        if self.is_playing:
            self.exact_time += self.delta
            self.absolute += self.delta

    def follow(self, app: App) -> None:
        """Takes the values of an App's present update.

        Call it in each update before its graphs, and in each of its steps.
        """
        timeline = app.timeline
        loop_time = app.loop_time
        self.is_playing = timeline.is_playing()
        self.delta = timeline.delta
        self.exact_time = timeline.current_time
        self.frames_per_second = timeline.time_codes_per_second
        if self.update != app.update_index:
            self.loop_delta = loop_time - self.since_start if self.update + 1 == app.update_index else 1 / app.loop_rate
        self.since_start = loop_time
        self.absolute = app.simulation.monotonic_time
        self.update = app.update_index

    @property
    def delta_seconds(self) -> float:
        """Length of this update [s], playing or not; `delta` is how far the timeline moved."""
        return float(self.loop_delta)

    @property
    def time(self) -> float:
        """Timeline time [s]."""
        return float(self.exact_time)

    @property
    def frame(self) -> float:
        """Timeline time in frames, counted in timeCodesPerSecond."""
        return float(self.exact_time * self.frames_per_second)

    @property
    def time_since_start(self) -> float:
        """Loop time since the app started [s], playing or not."""
        return float(self.since_start)

    @property
    def absolute_sim_time(self) -> float:
        """Simulation time that a stop does not reset [s]."""
        return float(self.absolute)
