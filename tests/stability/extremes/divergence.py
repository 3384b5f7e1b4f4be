"""Divergence: found in the update in which it happens, told with body, time, cause and what to do."""

from __future__ import annotations

import math
import tempfile
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

from graph.base.errors import RunError
from graph.cli.extreme_cases import WEIGHTLESS, Case, body, playing
from graph.files import loads
from graph.recording.mcap_sink import McapSink
from graph.recording.run_reader import open_run
from graph.session.open import open_session
from tests.stability.extremes.bodies import drive, spinning
from tests.stability.extremes.worlds import unplayable

AREA = "divergence"
BOUND = 1e10
"""Positions [m] and velocities [m/s] from here on are divergence."""

FALLING = """\
tickgraph: 1
clock: {physics_hz: 60, loop_hz: 60}
scene: {prims: {/Ball: {type: Sphere, rigid_body: true, mass: 1.0}}}
graphs:
  /Graph:
    nodes: {tick: OnPlaybackTick, time: IsaacReadSimulationTime, clock: ROS2PublishClock}
    connections: [tick.tick -> clock.execIn, time.simulationTime -> clock.timeStamp]
"""


def updates_late(hz: int) -> float:
    """A body that is beyond the bound after the fourth and last step of an update: updates until the error."""
    a_step = 1e6 / hz
    start = body(1, (BOUND - 3.5 * a_step, 0, 0), velocity=[1e6, 0, 0])
    with playing({**WEIGHTLESS, "/Body": start}, hz, Fraction(hz, 4)) as app:
        for update in range(4):
            try:
                app.update()
            except RunError:
                return update
    return math.inf


def starting(prims: dict[str, Any], **knobs: Any) -> str:
    """The line with which a scene ends, at 60 Hz."""
    return unplayable({**WEIGHTLESS, **prims}, 60, hz=60, **knobs)


def tumble(integrator: str) -> str:
    """The line about a body that turns by 166 rad in a step."""
    keys = {"angular_velocity": [5e4, 5e5, 5e4], "attributes": {"physics:diagonalInertia": [1 / 128, 1 / 64, 3 / 128]}}
    return starting(spinning(0.0, **keys), physics_integrator=integrator)


def huge(side: str) -> str:
    """The line about boxes of 1e8 m in each other."""
    return starting({side: body(1e8, (0, 0, 0), mass=1e6), "/Other": body(1e8, (1e6, 0, 0), mass=1e6)})


def lost_messages(_: object) -> float:
    """A ball gets a velocity of 1e12 m/s after ten updates: how many of their messages are not in the recording."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        with open_session(loads(FALLING)).app as app:
            app.bus.subscribe(McapSink(file))
            app.play()
            app.update(10)
            app.simulation.tensors.set_velocities(linear=[1e12, 0, 0])
            with suppress(RunError):
                app.update(10)
        with open_run(file) as run:
            return 10 - len(list(run.read()))


CASES = (
    Case(AREA, "a body beyond 1e10 m", 0.0, "updates late", "the state is checked after the last step too",
         updates_late, (1, 240, 100_000)),
    Case(AREA, "a drive too stiff for rk4 or euler", "for the drive of /Rail is too stiff", "",
         "with body, time, cause, hint", lambda kind: starting(drive(1e6), physics_integrator=kind), ("rk4", "euler")),
    Case(AREA, "a tumble too fast for rk4 or euler", "for it turned too far in a step", "",
         "with body, time, cause, hint", tumble, ("rk4", "euler")),
    Case(AREA, "boxes of 1e8 m in each other", "overlapped", "", "with body, time, cause, hint", huge, ("/Box",)),
    Case(AREA, "a recording that ends so", 0.0, "messages lost", "what was recorded stays", lost_messages),
)  # fmt: skip
