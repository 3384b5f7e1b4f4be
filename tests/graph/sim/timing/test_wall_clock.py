"""Wall clocks: the virtual one is exact, the real one keeps the beat."""

from __future__ import annotations

import time
from fractions import Fraction

from graph.sim import App, RealClock, VirtualClock


def test_a_virtual_clock_moves_only_by_its_paces():
    clock = VirtualClock(Fraction(1000))
    for _ in range(3600 * 60):
        clock.pace(SIXTIETH)
    assert clock.now() == 1000 + 3600


def test_a_virtual_clock_changes_pace_exactly():
    clock = VirtualClock()
    for period in (Fraction(1, 60), Fraction(1, 7), Fraction(1001, 30000)):
        clock.pace(period)
    assert clock.now() == Fraction(1, 60) + Fraction(1, 7) + Fraction(1001, 30000)


def test_a_real_clock_paces_updates():
    with App(loop_hz=200, wall_clock=RealClock()) as app:
        app.play()
        app.update()
        began = time.monotonic()
        app.update(40)
        took = time.monotonic() - began
    assert 0.19 < took < 0.5  # 40 updates of 5 ms; the upper bound is for a busy machine


def test_a_late_update_is_not_made_up_for(monkeypatch):
    moment, slept = [0], []
    monkeypatch.setattr(time, "monotonic_ns", lambda: moment[0])
    monkeypatch.setattr(time, "sleep", lambda seconds: (slept.append(seconds), moment.append(0))[0])
    clock = RealClock()
    moment[0] = 10**9
    clock.pace(Fraction(1, 10))  # the first beat is now
    moment[0] += 30_000_000
    clock.pace(Fraction(1, 10))
    moment[0] = 3 * 10**9  # nearly two seconds late
    clock.pace(Fraction(1, 10))
    moment[0] += 60_000_000
    clock.pace(Fraction(1, 10))
    assert slept == [0.07, 0.04]


def test_real_time_moves_forward():
    clock = RealClock()
    first = clock.now()
    assert clock.now() >= first
    assert abs(float(first) - time.time()) < 1


SIXTIETH = Fraction(1, 60)
