"""One run of one setting: measured (what bodies did and sensors saw), or timed (what it cost)."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError
from graph.base.exact import shortest
from graph.base.limits import check
from graph.base.outputs import remove
from graph.session.meter import Cost, Meter, MeteredSink
from graph.sim.fidelity import KNOBS, Fidelity
from sensors.channels import STABLE_IDS

from .float32 import Float32, Float32Log, float32_log
from .readings import OTHER, SORTS, ReadingLog, Readings
from .states import StateLog, Trajectory
from .study import Scene, Setting, overrides_of

if TYPE_CHECKING:
    from graph.session.open import Session

_NAMES = {name.replace(".", "_"): name for name in KNOBS}
"""Knobs by their fields of `Fidelity`."""

UNSTABLE, FAILED = "unstable", "failed"
CLOCKS = frozenset({"physics.hz", "loop_hz"})
"""Knobs that every run reads, when it is opened."""


@dataclass(slots=True)
class Measured:
    """What a run did and saw. ended: "" if it lasted to its end, else why not; status: of a run that did not.

    warnings: the codes of its warnings. started: simulation time [s] at which every sensor had given a frame, 0 if one
    never did. opening: processor time until it played [s], pace: of a simulated second after that [s]. period: of the
    slowest sensor [s], 0 without one. read: the fidelity knobs that something in the run asked for. frames: of all
    sensors, per simulated second. float32: how the bodies move on a device; None unless `device` is varied.
    """

    bodies: Trajectory | None = None
    sensors: dict[str, Readings] = field(default_factory=dict)
    status: str = ""
    ended: str = ""
    ended_at: float = 0.0
    warnings: tuple[str, ...] = ()
    started: float = 0.0
    opening: float = 0.0
    pace: float = 0.0
    period: Fraction = Fraction(0)
    read: frozenset[str] = CLOCKS
    frames: float = 0.0
    float32: Float32 | None = None


@dataclass(frozen=True, slots=True)
class Timed:
    """What a run cost: its updates by part, per simulated second, and its start [s]. ended: as in `Measured`.

    sensors: processor time of sensors by their kind, per simulated second, which is in `parts` too.
    """

    parts: dict[str, Cost]
    start: float
    ended: str = ""
    sensors: dict[str, float] = field(default_factory=dict)

    @property
    def whole(self) -> Cost:
        """The sum of all parts."""
        return sum(self.parts.values(), Cost())


def measure(scene: Scene, setting: Setting, duration: Fraction) -> Measured:
    """Runs a setting and records its bodies and sensors. Raises UserError for what cannot be opened, or never ends."""
    from graph.session.step_limit import check_steps
    from graph.sim.messages.bus import CountingSink

    found, read = Measured(), set(CLOCKS)
    began = time.process_time()
    told = replace(scene, settings={**scene.settings, STABLE_IDS: True})  # ids of prims, to match returns by
    with _playing(told, setting) as session:
        app = session.app
        updates = math.ceil(duration * app.loop_rate)
        check("run.updates", updates, f"--duration {shortest(duration)}: {updates:,} updates")
        app.world.fidelity = _watched(app.fidelity, read)
        readings = ReadingLog(app, float(duration))
        app.bus.subscribe(CountingSink())  # with a reader publishers publish, as they do in a recorded run
        app.play()
        check_steps(app)
        beside = float32_log(app, setting.get("device"))
        states = StateLog(app, float(duration), beside.take if isinstance(beside, Float32Log) else tuple)
        found.opening = time.process_time() - began
        stepping = [False]
        app.on("physics", lambda: stepping.__setitem__(0, True), -(2**60))
        app.on("physics", lambda: stepping.__setitem__(0, False), 2**60)
        try:
            for _ in range(updates):
                app.update()
                if any(not product.frames for product in app.rendering.products.values()):
                    found.started = 0.0
                elif not found.started:
                    found.started = float(app.simulation.time)
                if app.exit_requested:
                    break
        except RunError as error:
            found.status, found.ended = UNSTABLE if stepping[0] else FAILED, str(error)
        found.ended_at = float(app.simulation.time)
        found.pace = (time.process_time() - began - found.opening) / (found.ended_at or math.inf)
        found.bodies, found.sensors = states.trajectory(), readings.sensors
        found.period = max((1 / one.rate for one in readings.sensors.values() if one.rate), default=Fraction(0))
        if found.bodies is not None and beside is not None:
            found.float32 = beside.compared(found.bodies) if isinstance(beside, Float32Log) else beside
            read.add("device")
        found.read = frozenset(read)
        found.frames = sum(len(one.frames) for one in readings.sensors.values()) / (found.ended_at or math.inf)
        found.warnings = tuple(sorted({str(warning.as_dict()["code"]) for warning in app.warnings}))
    return found


def clock(scene: Scene, setting: Setting, duration: Fraction, start: float, recording: Path) -> Timed:
    """Times a run of a setting that is recorded into a file, as `graph run --out` does.

    The updates of the first `start` simulated seconds belong to the start; those of `duration` after them count.
    """
    from graph.recording.mcap_sink import McapSink

    meter = Meter()
    began = time.perf_counter()
    with meter.watching(), _playing(scene, setting) as session:
        app = session.app
        app.bus.subscribe(MeteredSink(McapSink(recording), meter))
        app.play()
        meter.follow(app)
        first = math.ceil(Fraction(start) * app.loop_rate)
        ended = ""
        started = app.simulation.time
        spent = 0.0
        try:
            for index in range(first + math.ceil(duration * app.loop_rate)):
                if index == first:
                    spent = time.perf_counter() - began
                    started = app.simulation.time
                    meter.clear()
                app.update()
                if app.exit_requested:
                    break
        except RunError as error:
            ended = str(error)
        simulated = float(app.simulation.time - started)
        costs, sensors = meter.costs, dict(meter.sensors)
    remove(recording)
    length = simulated or math.nan
    shares = {SORTS.get(name, OTHER): seconds / length for name, seconds in sensors.items()}
    return Timed({name: cost.per(length) for name, cost in costs.items()}, spent, ended, shares)


@contextmanager
def _playing(scene: Scene, setting: Setting) -> Iterator[Session]:
    from graph.base.limits import raised
    from graph.session.message_sources import open_sources, play_into

    with raised(scene.limits):
        session = _opened(scene, setting)
        with session.app as app:
            if scene.play:
                play_into(app, open_sources(scene.play))
            yield session


def _opened(scene: Scene, setting: Setting) -> Session:
    from graph.isaac.managers.app import App
    from graph.session.open import open_session

    return open_session(
        scene.file,
        app_type=App,
        allow=scene.allow,
        skip_outside=scene.skip_outside,
        settings=scene.settings,
        fidelity={**scene.fidelity, **{name: value for name, value in setting.items() if name in KNOBS}},
        overrides={**scene.overrides, **overrides_of(setting)},
        seed=scene.seed,
        skip_unknown=scene.skip_unknown,
        allow_scripts=scene.allow_scripts,
    )


def _watched(fidelity: Fidelity, read: set[str]) -> Fidelity:
    """The same knobs; adds to `read` the name of each that is asked for."""

    class Watched(Fidelity):
        def __getattribute__(self, name: str) -> Any:
            if name in _NAMES:
                read.add(_NAMES[name])
            return super().__getattribute__(name)

    return Watched(**{field: fidelity[name] for field, name in _NAMES.items()})


def without_arrays(found: Measured) -> Measured:
    """A copy without the trajectories of bodies and the readings of sensors."""
    return replace(found, bodies=None, sensors={})


def present_values(scene: Scene) -> Fidelity:
    """The knobs of the file, with the user's own, and the rates that its clock gives.

    Raises UserError for what cannot be opened.
    """
    with _playing(scene, {}) as session:
        app = session.app
        return replace(app.fidelity, physics_hz=app.simulation.steps_per_second, loop_hz=app.loop_rate)
