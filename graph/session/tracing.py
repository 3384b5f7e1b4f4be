"""A trace of a run for Chrome and Perfetto (chrome://tracing, ui.perfetto.dev): JSON trace events.

Four groups of tracks share the time axis. "wall time" shows what the machine did: updates and their phases, the nodes
of each graph, the sensors, published messages, and the three clocks as curves. "timeline", "physics" and "renderer"
show the run on its own clocks, in simulated time: updates and node computes; physics steps; scans from their first to
their last moment. Each clock starts again at a stop. An App that is not traced has no tracing code installed.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.node.database import Database
    from graph.sim.app import App
    from graph.sim.renderer.schedule import Tick
    from graph.sim.renderer.sensor import Sensor, SensorFrame

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


_FIRST, _LAST = -(2**60), 2**60
"""Orders before and after all other subscribers."""


class Tracer:
    """Watches an App and its graphs and writes what happens.

    Attach it before the first update and close it at the end.
    """

    def __init__(self, app: App, graphs: Iterable[Graph], stream: TextIO) -> None:
        self._app = app
        self._writer = writer = TraceWriter(stream, self._failed)
        self._began = time.perf_counter_ns()
        self._open: list[tuple[str, float]] = []
        self._undo: list[Callable[[], object]] = []
        self._sensors: list[Any] = []
        self._step_began = Fraction(0)
        self._phases = writer.track(WALL, "updates")
        self._updates = writer.track(TIMELINE, "updates")
        self._steps = writer.track(PHYSICS, "steps")
        self._rendered = writer.track(RENDERER, "updates")
        self._external = app.external_time
        for graph in graphs:
            graph.observe(self._observed(graph))
        for index, phase in enumerate(app.phases.names):
            self._on(phase, self._begin_update if index == 0 else None, self._end_update if phase == "end" else None)
        self._undo.append(app.on("render", self._find_sensors, _FIRST))
        self._undo.append(app.on("physics_pre_step", self._begin_step, _FIRST))
        self._undo.append(app.on("physics_post_step", self._end_step, _LAST))
        for event in ("play", "pause", "resume", "stop"):
            self._undo.append(app.on(event, self._noted(event), _FIRST))
        app.bus.subscribe(self)
        if app.timeline.is_playing():
            self._noted("play")()

    def close(self) -> None:
        """Ends the open intervals (a run that failed ends inside a phase) and finishes the file."""
        while self._undo:
            self._undo.pop()()
        while self._open:
            self._close_last()
        self._writer.close()

    # -- phases ------------------------------------------------------------------------------------------------------

    def _on(self, phase: str, before: Callable[[], None] | None, after: Callable[[], None] | None) -> None:
        def begin() -> None:
            if before is not None:
                before()
            self._begin(phase)

        def end() -> None:
            self._end(phase)
            if after is not None:
                after()

        self._undo += (self._app.on(phase, begin, _FIRST), self._app.on(phase, end, _LAST))

    def _begin(self, name: str) -> None:
        self._open.append((name, self._now()))

    def _end(self, name: str) -> None:
        """Ends the interval with this name, and the intervals inside it that are still open."""
        if any(name == began for began, _ in self._open):
            while self._close_last(name):
                pass

    def _close_last(self, name: str = "") -> bool:
        """Ends the newest interval; returns whether more must be ended until `name` is."""
        began, start = self._open.pop()
        args = {} if began == name else {"unfinished": True}
        self._writer.slice(WALL, self._phases, began, start, round(self._now() - start, 3), **args)
        return began != name

    def _begin_update(self) -> None:
        while self._open:  # an update that failed, in an App that went on
            self._close_last()
        self._begin(f"update {self._app.update_index}")

    def _end_update(self) -> None:
        app, writer = self._app, self._writer
        now, external = app.timeline.current_time, app.external_time
        moved = app.timeline.delta
        name = f"update {app.update_index}"
        self._end(name)
        if moved:
            writer.slice(TIMELINE, self._updates, name, *_span(now - moved, now))
        if external > self._external:
            writer.slice(RENDERER, self._rendered, name, *_span(self._external, external))
        self._external = external
        physics = app.simulation.time
        writer.curve("clocks [s]", self._now(), timeline=float(now), physics=float(physics), renderer=float(external))

    # -- nodes -------------------------------------------------------------------------------------------------------

    def _observed(self, graph: Graph) -> Callable[[Node, Any], Any]:
        writer, clock, began = self._writer, time.perf_counter_ns, self._began
        known: set[Any] = set()
        wall, timeline = writer.track(WALL, f"graph {graph.path}"), writer.track(TIMELINE, f"graph {graph.path}")

        def wrap(node: Node, compute: Any) -> Any:
            if compute in known:  # an edit of the graph has its nodes observed again
                return compute
            name, kind, own = node.name, node.type.short_name, node.graph

            def traced(db: Database) -> Any:
                start = clock()
                args: dict[str, Any] = {"type": kind}
                try:
                    done = compute(db)
                except BaseException as error:
                    args["error"] = f"{type(error).__name__}: {error}"
                    raise
                finally:
                    length = clock() - start
                    writer.slice(WALL, wall, name, (start - began) / 1000, length / 1000, **args)
                    writer.instant(TIMELINE, timeline, name, _us(own.context.exact_time))
                return done

            known.add(traced)
            return traced

        return wrap

    # -- physics, sensors, messages ----------------------------------------------------------------------------------

    def _begin_step(self) -> None:
        self._step_began = self._app.simulation.time
        self._begin("step")

    def _end_step(self) -> None:
        self._end("step")
        simulation = self._app.simulation
        name = f"step {simulation.get_num_physics_steps()}"
        self._writer.slice(PHYSICS, self._steps, name, *_span(self._step_began, simulation.time))

    def _find_sensors(self) -> None:
        """Watches the sensors of products that were created since the last update."""
        for product in self._app.rendering.products.values():
            if not any(product.sensor is known for known in self._sensors):
                self._sensors.append(product.sensor)
                self._watch(product.sensor, product.camera_path)

    def _watch(self, sensor: Sensor, path: str) -> None:
        writer, render = self._writer, sensor.render
        wall, scans = writer.track(WALL, f"sensor {path}"), writer.track(RENDERER, f"sensor {path}")

        def traced(tick: Tick) -> SensorFrame | None:
            start = self._now()
            frame = None
            try:
                frame = render(tick)
            finally:
                count = frame.count if frame is not None else 0
                writer.slice(WALL, wall, "render", start, round(self._now() - start, 3), elements=count)
            if frame is not None:
                stamp = frame.timestamp_ns
                writer.slice(RENDERER, scans, "frame", *_span(tick.start, tick.end), stamp_ns=stamp, elements=count)
            return frame

        sensor.render = traced  # type: ignore[method-assign]
        self._undo.append(lambda: sensor.__dict__.pop("render", None))

    def advertise(self, topic: str, type_name: str) -> None:
        """As a sink of the bus: a publisher exists."""

    def write(self, message: Any) -> None:
        """As a sink of the bus: notes a message."""
        track = self._writer.track(WALL, "messages")
        name = message.type_name
        self._writer.instant(WALL, track, message.topic, self._now(), type=name, stamp_ns=message.stamp_ns)

    def _noted(self, event: str) -> Callable[[], None]:
        return lambda: self._writer.instant(WALL, self._phases, event, self._now())

    def _failed(self, error: OSError) -> None:
        self._app.warn("trace-cut-off", "trace", f"the trace ends early: {error.strerror or error}")

    def _now(self) -> float:
        """Wall time since the start of the trace [us]."""
        return (time.perf_counter_ns() - self._began) / 1000


def _us(seconds: Fraction) -> float:
    """Seconds in microseconds, to the nanosecond."""
    return round(seconds * 10**9) / 1000


def _span(start: Fraction, end: Fraction) -> tuple[float, float]:
    """Start and length in microseconds, such that adjacent intervals meet exactly."""
    first, last = round(start * 10**9), round(end * 10**9)
    return first / 1000, (last - first) / 1000
