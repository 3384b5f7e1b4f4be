"""Computes the clocks of an App update by update, by the App's own rules, without running anything."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.session.open import Session
    from graph.sim.app import App

DEFAULT_DURATION_S = 5
"""Default of a file without a duration."""
MOST_PLANNED_UPDATES = 100_000
"""Most updates that are counted one by one; a longer run is described by its first ones."""


@dataclass(frozen=True, slots=True)
class Step:
    """One update: the advance of loop and timeline [s], and the number of substeps.

    physics_time and external_time [s] are those after the substeps. due: the number of substeps that the waiting time
    amounts to; it is larger than `substeps` only if the catch-up cap limits them.
    """

    index: int
    loop_dt: Fraction
    timeline_dt: Fraction
    substeps: int
    due: int
    physics_time: Fraction
    external_time: Fraction


def duration_of(session: Session) -> Fraction:
    """How long `graph run` plays a file [s]."""
    duration = session.spec.duration
    return Fraction(DEFAULT_DURATION_S) if duration is None else duration


def updates_of(session: Session) -> int:
    """How many updates `graph run` does of a file."""
    return math.ceil(duration_of(session) * session.app.loop_rate)


def loop_dt(app: App) -> Fraction:
    """The dt of each update [s]: the manual step; in automatic mode a whole number of microseconds of wall time."""
    from graph.sim import settings as keys

    if app.run_loop.manual_mode:
        return app.run_loop.manual_step
    return Fraction(math.floor(1_000_000 / app.settings.rate(keys.RATE_LIMIT_FREQUENCY)), 1_000_000)


def clock_facts(app: App, steps: Sequence[Step]) -> dict[str, Any]:
    """Rates [Hz] and ratios of the three clocks and the wall clock while the App plays, from its first updates.

    sim_per_wall: the simulated seconds per second of wall time that the clocks are set to.
    """
    from graph.sim import settings as keys
    from graph.sim.timing.clocks import Accumulator

    settings, dt = app.settings, loop_dt(app)
    accepted = next((step.timeline_dt for step in steps if step.timeline_dt), Fraction(0))
    gaps = [step.index for step in steps if step.timeline_dt][:2]
    every = gaps[1] - gaps[0] if len(gaps) == 2 else 1
    sps = app.simulation.steps_per_second
    cap = Accumulator(sps, settings.get(keys.MIN_FRAME_RATE)).cap
    simulates = bool(settings.get(keys.PLAY_SIMULATIONS))
    wanted = sps * accepted if simulates else Fraction(0)
    substeps = (wanted if cap is None else min(wanted, Fraction(cap))) / every
    return {
        "experience": app.experience,
        "parity": app.parity,
        "physics_hz": sps,
        "loop_hz": 1 / dt,
        "timeline_step_s": accepted,
        "timeline_every_updates": every,
        "substeps_per_update": substeps,
        "most_substeps": cap,
        "warm_up_steps": int(settings.get(keys.WARM_UP_STEPS)) if simulates else 0,
        "timeline_per_loop": accepted / every / dt,
        "update_lasts_s": app.run_loop.period,
        "sim_per_wall": substeps / sps / app.run_loop.period,
        "multi_tick": app.rendering.multi_tick,
        "frames_later": app.rendering.frames_later,
    }


def plan_updates(app: App) -> Iterator[Step]:
    """Yields the updates of an App that plays from its first update on, endlessly."""
    from graph.sim import settings as keys
    from graph.sim.timing.clocks import Accumulator
    from graph.sim.timing.timeline import Timeline

    settings, rate = app.settings, app.simulation.steps_per_second
    timeline = Timeline(settings)
    timeline.set_range(app.timeline.start_time, app.timeline.end_time)
    timeline.set_looping(app.timeline.is_looping())
    timeline.play()
    timeline.commit()
    steps_physics = bool(settings.get(keys.PLAY_SIMULATIONS))
    accumulator = Accumulator(rate, settings.get(keys.MIN_FRAME_RATE))
    dt, loop, index = loop_dt(app), Fraction(0), 0
    count = int(settings.get(keys.WARM_UP_STEPS)) if steps_physics else 0
    while True:
        timeline.commit()
        moved = timeline.advance(dt)
        loop += dt
        steps = due = 0
        if moved and steps_physics:
            due = math.floor((accumulator.carry + moved) * rate)
            steps = accumulator.take(moved)
            count += steps
        time = count / rate
        yield Step(index, dt, moved, steps, due, time, time if app.rendering.multi_tick else loop)
        index += 1
