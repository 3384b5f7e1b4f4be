"""Clocks at their limits, over any rates and any course of events, and over many plays."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.sim import App
from graph.sim import settings as keys
from graph.sim.settings import Settings
from graph.sim.timing.clocks import Accumulator
from graph.sim.timing.timeline import Timeline
from tests.support.lidar_texts import lidar_graph
from tests.support.noting_sensor import NotingSensor, add
from tests.support.places import ROOT

PRODUCT = "isaacsim-6.0.1"
YEAR = 31_557_600

# -- limits --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
@pytest.mark.parametrize("sps", [1, 1_000_000])
@pytest.mark.parametrize("loop", ["0.1", "60", "10000"])
def test_slowest_and_fastest_rates(sps, loop, parity):
    options = {"settings": {keys.WARM_UP_STEPS: 0, keys.MIN_FRAME_RATE: 0}, "parity": parity}
    with App(physics_hz=sps, loop_hz=loop, **options) as app:
        sensor = add(app, NotingSensor(1))
        app.play()
        updates = 600
        app.update(updates)
        passed = updates / Fraction(loop)
        assert app.timeline.current_time == passed
        assert app.simulation.get_num_physics_steps() == math.floor(passed * sps)
        assert app.simulation.time == Fraction(math.floor(passed * sps), sps)
        assert len(sensor.ticks) == min(updates, math.floor(app.simulation.time))


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_a_billion_steps_in_one_direct_step_without_drift(parity):
    with App(physics_hz=240, parity=parity, settings={keys.WARM_UP_STEPS: 0}) as app:
        sensor = add(app, NotingSensor(Fraction(2997, 100)))
        app.play()
        app.simulation.step(steps=10**9)
        app.update()
        count = 10**9 + 4
        assert app.simulation.get_num_physics_steps() == count
        assert app.simulation.time == app.simulation.monotonic_time == Fraction(count, 240)
        newest = math.floor(Fraction(count, 240) * Fraction(2997, 100))
        assert [tick.index for tick in sensor.ticks] == [newest]
        assert sensor.product.missed == newest - 1


def test_290_years_are_counted_and_293_refused():
    with App(physics_hz=1, loop_hz=1) as app:
        app.play()
        app.simulation.step(steps=290 * YEAR)
        app.update(3)
        assert app.simulation.time == 290 * YEAR + 3
        with pytest.raises(RunError, match="2\\*\\*63 - 1 ns \\(292 years\\)"):
            app.simulation.step(steps=3 * YEAR)
        assert app.simulation.time == 290 * YEAR + 3  # nothing was half done
        app.stop()
        app.play()
        app.simulation.step(steps=290 * YEAR)  # stop and play restart the clock, as the line says


def test_ros_stamps_end_at_68_years_with_a_clear_line():
    from nodes.ros2.messages import stamp

    assert stamp((2**31 - 1) * 10**9).sec == 2**31 - 1
    with pytest.raises(RunError, match="68 years"):
        stamp(2**31 * 10**9)


@pytest.mark.parametrize("rate", [0, -60, "1e10", "1/1e10", float("nan"), float("inf"), True, "fast"])
def test_rates_that_are_none(rate):
    with pytest.raises(UserError):
        App(physics_hz=rate)
    with pytest.raises(UserError):
        App(loop_hz=rate)


# -- any rates -----------------------------------------------------------------------------------------------------

rates = st.fractions(Fraction(1, 100), 10**5, max_denominator=10**4)


@given(sps=rates, loop=rates, updates=st.integers(1, 50_000))
@settings(max_examples=40, deadline=None)
def test_no_step_is_lost_or_doubled_in_equal_updates(sps, loop, updates):
    """After n updates of 1/loop: floor(n * sps / loop) steps, whatever the rates; two million updates in all."""
    accumulator, elapsed, steps = Accumulator(sps), 1 / loop, 0
    for update in range(1, updates + 1):
        steps += accumulator.take(elapsed)
        if update in (1, 2, 3, updates):
            assert steps == math.floor(update * sps / loop)
            assert accumulator.carry == update / loop - steps / sps
    assert 0 <= accumulator.carry < 1 / sps


@given(sps=rates, cap=st.integers(1, 240), elapsed=st.lists(st.fractions(0, 2, max_denominator=10**6), max_size=60))
@settings(max_examples=200, deadline=None)
def test_a_capped_accumulator_follows_the_four_rules(sps, cap, elapsed):
    """n = floor((e + carry) / pdt); M = max(1, sps // minFrameRate); n = min(n, M); carry = min(rest, M * pdt)."""
    accumulator, pdt, carry = Accumulator(sps, cap), 1 / sps, Fraction(0)
    most = max(1, sps // cap)
    for e in elapsed:
        n = min(math.floor((e + carry) / pdt), most)
        carry = min(e + carry - n * pdt, most * pdt)
        assert accumulator.take(e) == n
        assert accumulator.carry == carry


@given(sps=rates, loop=rates, sensors=st.lists(rates, min_size=1, max_size=3), updates=st.integers(1, 60))
@settings(max_examples=60, deadline=None)
def test_schedules_through_the_app_equal_the_closed_form(sps, loop, sensors, updates):
    """An update from T0 to T renders a sensor of rate r if floor(T r) > floor(T0 r), for the newest k."""
    with App(physics_hz=sps, loop_hz=loop) as app:
        noting = [add(app, NotingSensor(rate), str(number)) for number, rate in enumerate(sensors)]
        app.play()
        times = [Fraction(0)]
        for _ in range(updates):
            app.update()
            times.append(app.external_time)
        assert times == [Fraction(math.floor(n * sps / loop)) / sps for n in range(updates + 1)]
        for rate, sensor in zip(sensors, noting, strict=True):
            grid = [math.floor(time * rate) for time in times]
            due = [(new, time) for old, new, time in zip(grid, grid[1:], times[1:], strict=False) if new > old]
            assert [(tick.index, tick.time) for tick in sensor.ticks] == due


EVENTS = st.one_of(
    st.tuples(st.just("update"), st.integers(1, 5)),
    st.tuples(st.just("step"), st.integers(1, 7)),
    st.tuples(st.just("rate"), st.sampled_from([30, 60, 100, 240, 1000])),
    st.tuples(st.just("loop"), st.sampled_from([Fraction(1, 24), Fraction(1, 60), Fraction(1, 144), Fraction(1, 3)])),
    st.tuples(st.sampled_from(["play", "pause", "stop", "render"]), st.just(0)),
)


class Model:
    """The clocks as the tables tell them, in plain fractions."""

    def __init__(self, warm_up, cap):
        self.warm_up, self.min_frame_rate = warm_up, cap
        self.rate = self.stamped = Fraction(60)
        self.ldt = Fraction(1, 60)
        self.state, self.count, self.carry = "stopped", 0, Fraction(0)
        self.timeline = self.monotonic = Fraction(0)

    def steps(self, number):
        if number:
            self.count += number
            self.monotonic += number / self.rate
            self.stamped = self.rate

    def update(self):
        if self.state != "playing":
            return
        self.timeline += self.ldt
        pending = self.ldt + self.carry
        n = math.floor(pending * self.rate)
        if self.min_frame_rate:
            most = max(1, self.rate // self.min_frame_rate)
            n = min(n, most)
            self.carry = min(pending - n / self.rate, most / self.rate)
        else:
            self.carry = pending - n / self.rate
        self.steps(n)

    def apply(self, event, argument):
        if event == "update":
            for _ in range(argument):
                self.update()
        elif event == "step" and self.state != "stopped":
            self.carry = Fraction(0)
            self.steps(argument)
        elif event == "rate":
            self.rate = Fraction(argument)
            if not self.count:
                self.stamped = self.rate
        elif event == "loop":
            self.ldt = argument
        elif event == "play":
            if self.state == "stopped":
                self.steps(self.warm_up)
                self.carry = Fraction(0)
            self.state = "playing"
        elif event == "pause" and self.state == "playing":
            self.state = "paused"
        elif event == "stop":
            self.state, self.count, self.carry, self.timeline = "stopped", 0, Fraction(0), Fraction(0)
        elif event == "render" and self.state == "playing":
            self.timeline += self.ldt


@given(parity=st.sampled_from(["documented", PRODUCT]), events=st.lists(EVENTS, max_size=30))
@settings(max_examples=80, deadline=None)
def test_any_course_of_events_keeps_the_clocks_as_the_tables_say(parity, events):
    """Time is count / rate, monotonic time never decreases and sums the steps, none is lost or doubled."""
    product = parity == PRODUCT
    model = Model(2 if product else 0, 30 if product else 0)
    with App(parity=parity) as app:
        for event, argument in events:
            before = app.simulation.monotonic_time
            if event == "update":
                app.update(argument)
            elif event == "step":
                if not app.timeline.is_stopped():
                    app.simulation.step(steps=argument)
            elif event == "rate":
                app.simulation.setup_simulation(dt=Fraction(1, argument))
            elif event == "loop":
                app.run_loop.manual_step = argument
            elif event == "render":
                app.rendering.render()
            else:
                getattr(app, event)()
            model.apply(event, argument)
            simulation = app.simulation
            assert simulation.get_num_physics_steps() == model.count
            assert simulation.time == model.count / model.stamped
            assert app.fabric.get("/ExternalSimulationTime", "omni:time") == float(simulation.time)
            assert simulation.monotonic_time == model.monotonic >= before
            assert simulation.carry == model.carry
            assert app.timeline.current_time == model.timeline


@given(loop=st.integers(1, 500), tcps=st.integers(1, 500), fast=st.booleans(), updates=st.integers(1, 400))
@settings(max_examples=60, deadline=None)
def test_fixed_stepping_accepts_one_update_in_n_whatever_the_rates(loop, tcps, fast, updates):
    values = {keys.FIXED_STEPPING: True, keys.FAST_MODE: fast, keys.TARGET_FRAMERATE: loop}
    timeline = Timeline(Settings({**values, keys.TIME_CODES_PER_SECOND: tcps}))
    timeline.play()
    timeline.commit()
    moved = [timeline.advance(Fraction(1, loop)) for _ in range(updates)]
    n = 1 if fast else math.ceil(Fraction(loop, tcps))
    assert moved == [Fraction(1, tcps) if update % n == 0 else 0 for update in range(updates)]
    assert timeline.current_time == Fraction(-(-updates // n), tcps)


# -- many plays ----------------------------------------------------------------------------------------------------

SCENE = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Wall: {type: Cube, size: 2.0, translate: [5, 0, 1]}
    /World/Ball: {type: Sphere, radius: 0.3, translate: [2, 1, 1], rigid_body: true}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D, translate: [0, 0, 0.5]}
clock: {physics_hz: 120, loop_hz: 20, parity: PARITY}
"""


class Digest:
    """A sink that keeps a digest of the clouds it got."""

    def __init__(self):
        self.clouds = 0
        self.hash = hashlib.sha256()

    def advertise(self, topic, type_name):
        pass

    def write(self, message):
        self.clouds += 1
        self.hash.update(repr(message.message.header.stamp).encode())
        self.hash.update(bytes(message.message.data))

    def close(self):
        pass


def one_play(app, updates=9):
    """How many clouds a play publishes, and their digest."""
    digest = Digest()
    app.bus.subscribe(digest)
    app.play()
    app.update(updates)
    app.stop()
    app.bus.unsubscribe(digest)
    return digest.clouds, digest.hash.hexdigest()


@pytest.fixture(params=["documented", PRODUCT])
def file(request, tmp_path):
    found = tmp_path / "g.yaml"
    found.write_text(SCENE.replace("PARITY", request.param) + lidar_graph())
    return found


def test_two_apps_and_many_plays_give_identical_bytes(file):
    with App.from_file(file) as first, App.from_file(file) as second:
        found = {one_play(app) for _ in range(5) for app in (first, second)}
        assert len(found) == 1
        assert next(iter(found))[0] >= 1


def test_apps_side_by_side_in_turns_give_the_bytes_of_each_alone(file):
    with App.from_file(file) as app:
        alone = one_play(app)
    with App.from_file(file) as first, App.from_file(file) as second:
        digests = [Digest(), Digest()]
        for app, digest in zip((first, second), digests, strict=True):
            app.bus.subscribe(digest)
            app.play()
        for _ in range(9):
            first.update()
            second.update()
        assert {(digest.clouds, digest.hash.hexdigest()) for digest in digests} == {alone}


CYCLES = """
import ctypes, gc, sys
from contextlib import ExitStack
from pathlib import Path
from graph.sim import App, CountingSink

libc = ctypes.CDLL(None)

def held():
    gc.collect()
    if hasattr(libc, "malloc_trim"):
        libc.malloc_trim(0)  # what is free but kept for later is not a leak
    return int(Path("/proc/self/statm").read_text().split()[1]), len(gc.get_objects())

def two_apps(plays):
    for _ in range(plays // 2):
        for app in apps:
            app.play()
            app.update(6)
            app.stop()

with ExitStack() as stack:
    apps = [stack.enter_context(App.from_file(sys.argv[1])) for _ in range(2)]
    for app in apps:
        app.bus.subscribe(CountingSink())
    two_apps(60)  # until the thread pools have what they keep
    before = held()
    two_apps(100)
    print(*before, *held())
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="resident memory is read from /proc")
def test_100_plays_of_two_apps_leak_nothing(tmp_path):
    """Resident memory stays flat within 2 %, and not one object a play is left.

    In a process of its own with one heap for all threads: with several, threads that come and go spread over them, and
    memory moves by more than a leak would.
    """
    file = tmp_path / "g.yaml"
    file.write_text(SCENE.replace("PARITY", "documented") + lidar_graph())
    ran = subprocess.run(
        [sys.executable, "-c", CYCLES, str(file)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=True,
        env={**os.environ, "MALLOC_ARENA_MAX": "1"},
    )
    pages, objects, pages_after, objects_after = map(int, ran.stdout.split())
    assert pages_after <= pages * 1.02
    assert objects_after < objects + 100
