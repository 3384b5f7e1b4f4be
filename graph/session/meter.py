"""Where the time of updates goes: wall and processor time of each part, measured from outside while a run is watched.

`graph trade` compares settings by it, `graph run --stats` prints it.

Parts exclude each other: a cast inside rendering counts as a cast, a structure that is built for it as a build. Nothing
is installed in an App that is not watched.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.messages.bus import Sink

PARTS = {
    "physics": "physics steps",
    "builds": "geometry and acceleration structures for rays",
    "casts": "ray casts",
    "post": "what sensors compute from hits",
    "graph": "nodes, in every update and after frames",
    "io": "messages written to the recording",
    "rest": "the rest of an update: clocks, the timeline, schedules",
}
"""The parts of an update, each with what it is."""

_FIRST, _LAST = -(2**60), 2**60
"""Orders before and after all other subscribers of a phase."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Wall and processor time [s]; processor time is that of all threads."""

    wall: float = 0.0
    cpu: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(self.wall + other.wall, self.cpu + other.cpu)

    def as_data(self) -> dict[str, float]:
        """As JSON holds it."""
        return {"wall_s": round(self.wall, 6), "cpu_s": round(self.cpu, 6)}

    def per(self, seconds: float) -> Cost:
        """The cost per second of a cost over `seconds` [s]."""
        return Cost(self.wall / seconds, self.cpu / seconds)


class Meter:
    """Charges time to one part at a time."""

    def __init__(self) -> None:
        self._costs = {name: [0.0, 0.0] for name in PARTS}
        self.sensors: dict[str, float] = {}
        """Processor time of sensors [s] by the type of their prims; it is in the parts too."""
        self._part: list[float] | None = None
        self._wall = self._cpu = 0.0

    def clear(self) -> None:
        """Sets all costs to 0."""
        for cost in self._costs.values():
            cost[:] = 0.0, 0.0
        self.sensors.clear()

    @property
    def costs(self) -> dict[str, Cost]:
        """The cost of each part so far."""
        return {name: Cost(wall, cpu) for name, (wall, cpu) in self._costs.items()}

    def enter(self, part: str | None) -> list[float] | None:
        """From now on charges to `part` (None: to nothing); returns what was charged before, for `leave`."""
        return self._switch(None if part is None else self._costs[part])

    def leave(self, before: list[float] | None) -> None:
        """From now on charges to what `enter` returned."""
        self._switch(before)

    def _switch(self, part: list[float] | None) -> list[float] | None:
        wall, cpu = time.perf_counter(), time.process_time()
        before = self._part
        if before is not None:
            before[0] += wall - self._wall
            before[1] += cpu - self._cpu
        self._part, self._wall, self._cpu = part, wall, cpu
        return before

    def charged(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, with its time charged to a part."""

        @functools.wraps(function)
        def timed(*args: Any, **options: Any) -> Any:
            before = self.enter(part)
            try:
                return function(*args, **options)
            finally:
                self.leave(before)

        return timed

    def _of_sensor(self, method: Callable[..., Any]) -> Callable[..., Any]:
        """A method of a sensor, with its time added to `sensors`."""

        @functools.wraps(method)
        def timed(sensor: Any, *args: Any) -> Any:
            began = time.process_time()
            try:
                return method(sensor, *args)
            finally:
                name = sensor.type_name
                self.sensors[name] = self.sensors.get(name, 0.0) + time.process_time() - began

        return timed

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Charges what rays cost, in every App of this process."""
        from graph.sim.world import World
        from sensors.lidar.runtime import LidarRuntime
        from sensors.raycast.triangles import TriangleScene
        from sensors.raycast.world import CastWorld
        from sensors.runtime import SensorRuntime

        with ExitStack() as undo:
            for owner, name, part in (
                (SensorRuntime, "render", ""),
                (LidarRuntime, "advance", ""),
                (World, "geometry", "builds"),
                (CastWorld, "__init__", "builds"),
                (TriangleScene, "__init__", "builds"),
                (CastWorld, "cast", "casts"),
                (TriangleScene, "cast", "casts"),
                (TriangleScene, "blocked", "casts"),
            ):
                plain = getattr(owner, name)
                setattr(owner, name, self.charged(part, plain) if part else self._of_sensor(plain))
                undo.callback(setattr, owner, name, plain)
            yield

    def follow(self, app: App) -> None:
        """Charges the phases of an App's updates, from the next update on."""
        for phase, part in (
            ("timeline_state", "rest"),
            ("physics", "physics"),
            ("simulation_graphs", "graph"),
            ("render", "post"),
            ("post_render_graphs", "graph"),
        ):
            app.on(phase, functools.partial(self.enter, part), _FIRST)
            app.on(phase, functools.partial(self.enter, "rest"), _LAST)
        app.on("end", functools.partial(self.enter, None), _LAST)


class MeteredSink:
    """A sink whose time is charged to `io`."""

    def __init__(self, sink: Sink, meter: Meter) -> None:
        self.advertise = meter.charged("io", sink.advertise)
        self.write = meter.charged("io", sink.write)
        self.close = sink.close
        if reached := getattr(sink, "reached", None):
            self.reached = meter.charged("io", reached)
