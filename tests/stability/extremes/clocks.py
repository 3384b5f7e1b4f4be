"""Clocks: rates from 1e-3 to 1e5 Hz, a billion ticks, stamps across the limits of their integers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from graph.cli.extreme_cases import Case, camera_at, channel, refusal, seen
from graph.files import loads
from graph.session.open import open_session
from graph.sim import App, MemorySink
from sensors.lidar.config import EmitterState, LidarConfig
from tests.stability.extremes.worlds import unplayable

AREA = "clocks"
YEAR = 31_557_600

CLOCK = """\
tickgraph: 1
clock: {physics_hz: 1, loop_hz: 1}
graphs:
  /Graph:
    nodes: {tick: OnPlaybackTick, time: IsaacReadSimulationTime, clock: ROS2PublishClock}
    connections: [tick.tick -> clock.execIn, time.simulationTime -> clock.timeStamp]
"""


def clock_message(seconds: int) -> float:
    """The time of a clock message after so many seconds of simulation [ns]."""
    with open_session(loads(CLOCK)).app as app:
        sink = MemorySink()
        app.bus.subscribe(sink)
        app.play()
        app.simulation.step(steps=seconds)
        app.update()
        stamp = sink["/clock"][-1].message.clock
        return abs(int(stamp.sec) * 10**9 + int(stamp.nanosec) - (seconds + 1) * 10**9)


def beyond(years: int) -> str:
    """The line about a time that a clock cannot hold."""

    def run() -> None:
        with open_session(loads(CLOCK)).app as app:
            app.bus.subscribe(MemorySink())
            app.play()
            app.simulation.step(steps=years * YEAR)
            app.update()

    return refusal(run)


def turning(rate: str) -> LidarConfig:
    """A rotary lidar of 36 firings a turn."""
    hz = Fraction(rate)
    emitters = (EmitterState(azimuth_deg=np.zeros(1), elevation_deg=np.zeros(1)),)
    return LidarConfig(scan_rate_base_hz=hz, pattern_firing_rate_hz=36 * hz, emitter_states=emitters)


def slow_turn(rate: str) -> float:
    """The time offsets of a slow turn: how far from k / 36 of it [ns]."""
    room: dict[str, Any] = {"/Room": {"type": "Cube", "size": 20.0}}
    frame = seen("OmniLidar", room, "timeOffsetNs", config=turning(rate), updates=180)
    return float(np.abs(channel(frame, "timeOffsetNs") - np.arange(36) / 36 / float(Fraction(rate)) * 1e9).max())


def billion(rate: str) -> float:
    """The stamp of a sensor's first tick after 1e9 steps, 24 a tick: how far from its grid [ns]."""
    exact = Fraction(rate)
    with App(physics_hz=24 * exact, loop_hz=6 * exact) as app:
        product = camera_at(app, exact)
        app.play()
        app.simulation.step(steps=10**9)
        app.update()  # the newest tick that was missed
        app.update()
        tick = 10**9 // 24 + 1
        return abs(int(product.frame.timestamp_ns) - round(tick / exact * 10**9))


CASES = (
    Case(AREA, "the tick after 1e9 steps", 0.0, "ns", "rates are fractions; nothing is added up", billion,
         ("1/2", "10", "2997/100", "1000/7", "1000")),
    Case(AREA, "a clock message after 2^53 ns and 67 years", 0.0, "ns", "seconds and nanoseconds are integers",
         clock_message, (9_007_199, 9_007_200, 67 * YEAR)),
    Case(AREA, "a clock message after 69 years", "68 years", "", "its seconds are int32", beyond, (69,)),
    Case(AREA, "293 years of simulation", "2**63 - 1 ns (292 years)", "", "stamps are int64", beyond, (293,)),
    Case(AREA, "a lidar that turns at 0.466 Hz", 1.0, "ns", "offsets are int32: up to 2.147 s", slow_turn, ("0.466",)),
    Case(AREA, "a lidar that turns at 0.465 Hz or less", "the slowest scan is 0.466 Hz", "", "its offsets overflow",
         lambda rate: refusal(lambda: turning(rate)), ("0.465", "0.001")),
    Case(AREA, "200,000 steps in an update", "--limit clock.steps=N", "", "such an update would not end soon",
         lambda hz: unplayable({"/Ball": {"type": "Sphere", "rigid_body": True}}, 1, hz=hz, loop=1), (200_000,)),
)  # fmt: skip
