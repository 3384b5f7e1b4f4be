"""What the clocks of an App will do, update by update, without running anything: the rules of the App, exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graph.sim import App


@dataclass(frozen=True, slots=True)
class Step:
    """What one update does: by how much the loop and the timeline move [s], how many substeps are run.

    physics_time and external_time [s] are those after the substeps; due is how many substeps the time waiting amounts
    to, which is more than `substeps` only where the catch-up cap holds them back.
    """

    index: int
    loop_dt: Fraction
    timeline_dt: Fraction
    substeps: int
    due: int
    physics_time: Fraction
    external_time: Fraction


def loop_dt(app: App) -> Fraction:
    """The dt of each update [s]: the manual step; in automatic mode a whole number of microseconds of wall time."""
    from graph.sim import settings as keys

    if app.run_loop.manual_mode:
        return app.run_loop.manual_step
    return Fraction(math.floor(1_000_000 / app.settings.rate(keys.RATE_LIMIT_FREQUENCY)), 1_000_000)


def plan_updates(app: App) -> Iterator[Step]:
    """The updates of an App that plays from its first update on, without end."""
    from graph.sim import settings as keys
    from graph.sim.clocks import Accumulator
    from graph.sim.timeline import Timeline

    settings, rate = app.settings, app.simulation.steps_per_second
    timeline = Timeline(settings)
    timeline.set_end_time(Fraction(app.timeline.get_end_time()))
    timeline.set_looping(app.timeline.is_looping())
    timeline.play()
    timeline.commit()
    steps_physics = bool(settings.get(keys.PLAY_SIMULATIONS))
    accumulator = Accumulator(rate, settings.get(keys.MIN_FRAME_RATE))
    dt, count, loop, index = loop_dt(app), int(settings.get(keys.WARM_UP_STEPS)), Fraction(0), 0
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
