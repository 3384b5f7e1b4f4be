"""The physics-to-loop ratio table, the timeline's stepping modes, and the rates that follow from each."""

from __future__ import annotations

import time
from fractions import Fraction

import pytest

from graph.sim import App, RealClock
from graph.sim import settings as keys
from graph.sim.messages.bus import CountingSink
from tests.support.noting_sensor import NotingLidar, NotingSensor, add

PRODUCT = "isaacsim-6.0.1"


def deltas(app, updates):
    """What the timeline moved in each update."""
    seen = []
    for _ in range(updates):
        app.update()
        seen.append(app.timeline.delta)
    return seen


# -- physics dt and loop dt ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_pdt_equal_to_ldt_one_step_an_update_at_a_constant_offset(parity):
    with App(parity=parity) as app:
        app.play()
        lead = app.external_time
        assert lead == (Fraction(2, 60) if parity == PRODUCT else 0)
        for _ in range(12):
            app.update()
            assert app.external_time - app.timeline.current_time == lead


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_pdt_below_ldt_under_the_cap_external_time_trails_by_the_carry(parity):
    with App(physics_hz=100, loop_hz=60, parity=parity) as app:
        app.play()
        lead = app.external_time
        for _ in range(12):
            before = app.simulation.get_num_physics_steps()
            app.update()
            assert app.simulation.get_num_physics_steps() - before in (1, 2)
            assert app.external_time == app.timeline.current_time + lead - app.simulation.carry
            assert app.simulation.carry < Fraction(1, 100)


def test_pdt_below_ldt_over_the_cap_falls_behind_without_end():
    with App(physics_hz=60, loop_hz=10, parity=PRODUCT) as app:
        sensor = add(app, NotingSensor(5))
        app.play()
        app.update(60)
        # M = 60 // 30 = 2 of 6 steps an update: a third of real time
        assert app.external_time == Fraction(2 + 60 * 2, 60)
        assert app.timeline.current_time == 6
        assert app.speed == Fraction(1, 3)
        assert len(sensor.ticks) == 10  # 5 Hz in 2.03 s: late in proportion


def test_pdt_above_ldt_external_time_stands_then_jumps_and_sensors_tick_where_it_does():
    with App(physics_hz=20, loop_hz=60) as app:
        due, auto = add(app, NotingSensor(10), "due"), add(app, NotingSensor(), "auto")
        app.play()
        times = []
        for _ in range(12):
            app.update()
            times.append(app.external_time)
        assert times == [Fraction(n // 3, 20) for n in range(1, 13)]
        assert [tick.time for tick in auto.ticks] == [Fraction(n, 20) for n in range(1, 5)]
        assert [tick.time for tick in due.ticks] == [Fraction(1, 10), Fraction(2, 10)]


# -- the timeline's stepping modes ---------------------------------------------------------------------------------


def test_variable_stepping_follows_the_loop_s_dispatched_dt():
    with App(loop_hz=50, settings={keys.TIME_CODES_PER_SECOND: 24}) as app:
        app.play()
        assert deltas(app, 5) == [Fraction(1, 50)] * 5


def test_variable_stepping_without_manual_mode_follows_the_wall_time():
    settings = {keys.MANUAL_MODE: False, keys.RATE_LIMIT_FREQUENCY: 80}
    with App(settings=settings) as app:
        app.play()
        assert deltas(app, 3) == [Fraction(12500, 10**6)] * 3


def fixed(loop, tcps, target=None, *, fast=False, parity="documented"):
    """An App in fixed stepping; `target`: targetFramerate, the loop's rate unless given."""
    settings = {keys.TIME_CODES_PER_SECOND: tcps, keys.FAST_MODE: fast}
    if target is not None:
        settings[keys.TARGET_FRAMERATE] = target
    return App(loop_hz=loop, physics_hz=tcps, experience="full", settings=settings, parity=parity)


def test_fixed_stepping_loop_equal_to_tcps_is_real_time():
    with fixed(60, 60) as app:
        app.play()
        assert deltas(app, 60) == [Fraction(1, 60)] * 60
        assert app.speed == 1


@pytest.mark.parametrize(("loop", "tcps"), [(30, 60), (24, 60), (10, 60), (30, 50)])
def test_fixed_stepping_loop_below_tcps_is_slow_motion_by_their_ratio(loop, tcps):
    with fixed(loop, tcps) as app:
        app.play()
        assert deltas(app, loop) == [Fraction(1, tcps)] * loop
        assert app.speed == Fraction(loop, tcps)
        assert app.wall_clock.now() == 1


@pytest.mark.parametrize(
    ("loop", "tcps", "target", "n"), [(60, 30, 50, 2), (60, 60, 60, 1), (120, 60, 100, 2), (180, 60, 180, 3)]
)
def test_fixed_stepping_loop_above_tcps_accepts_one_update_in_n(loop, tcps, target, n):
    with fixed(loop, tcps, target) as app:
        app.play()
        assert app.timeline.updates_per_frame == n
        assert deltas(app, 3 * n) == ([Fraction(1, tcps)] + [Fraction(0)] * (n - 1)) * 3
        assert app.speed == 1


def test_fixed_stepping_in_fast_mode_accepts_every_update():
    with fixed(240, 60, fast=True) as app:
        app.play()
        assert deltas(app, 240) == [Fraction(1, 60)] * 240
        assert app.speed == 4


def test_set_play_every_frame_acts_in_the_next_update():
    with fixed(120, 30) as app:
        app.play()
        app.update()  # accepted; three would be skipped
        app.timeline.set_play_every_frame(True)
        assert deltas(app, 2) == [Fraction(1, 30)] * 2
        app.timeline.set_play_every_frame(False)
        assert deltas(app, 5) == [Fraction(1, 30), 0, 0, 0, Fraction(1, 30)]


def test_skipped_updates_run_no_substeps_and_leave_the_carry_alone():
    with App(loop_hz=120, physics_hz=100, experience="full") as app:
        app.play()
        steps = []
        for _ in range(6):
            carry, before = app.simulation.carry, app.simulation.get_num_physics_steps()
            app.update()
            steps.append(app.simulation.get_num_physics_steps() - before)
            if not app.timeline.delta:
                assert app.simulation.carry == carry
        assert steps == [1, 0, 2, 0, 2, 0]


def test_switching_the_mode_takes_effect_after_stop_and_play():
    with App(loop_hz=30) as app:
        app.play()
        app.settings.set(keys.FIXED_STEPPING, True)
        assert deltas(app, 1) == [Fraction(1, 30)]
        app.pause()
        app.play()
        assert deltas(app, 1) == [Fraction(1, 30)]
        app.stop()
        app.play()
        assert deltas(app, 1) == [Fraction(1, 60)]


@pytest.mark.parametrize(
    ("tcps", "target", "limit"), [(30, 50, 60), (60, 60, 60), (60, 100, 120)], ids=lambda value: str(value)
)
def test_the_product_s_play_in_fixed_stepping_overwrites_the_rate_limit(tcps, target, limit):
    settings = {keys.TIME_CODES_PER_SECOND: tcps, keys.TARGET_FRAMERATE: target, keys.RATE_LIMIT_FREQUENCY: 45}
    with App(physics_hz=tcps, experience="full", parity=PRODUCT, settings=settings) as app:
        app.play()
        assert app.settings.rate(keys.RATE_LIMIT_FREQUENCY) == limit
        assert app.timeline.overwritten_rate_limit == 45
        app.update(2 * limit)
        assert app.speed == 1


def test_a_rate_limit_set_after_play_is_the_slow_motion_trap():
    with App(experience="full", parity=PRODUCT) as app:
        app.play()
        app.settings.set(keys.RATE_LIMIT_FREQUENCY, 30)
        app.update(60)
        assert app.speed == Fraction(1, 2)


def test_the_documented_play_leaves_the_rate_limit_alone():
    with App(experience="full", settings={keys.RATE_LIMIT_FREQUENCY: 30}) as app:
        app.play()
        app.update(60)
        assert app.settings.rate(keys.RATE_LIMIT_FREQUENCY) == 30
        assert app.speed == Fraction(1, 2)


def test_timeline_subsample_rate_gives_k_ticks_a_frame_of_one_kth_each():
    with App(loop_hz=60) as app:
        seen = []
        end = app.timeline.on_tick(lambda time, delta: seen.append((time, delta)))
        app.timeline.set_ticks_per_frame(3)
        app.update()
        app.play()
        app.update(2)
        assert seen == [(Fraction(n, 180), Fraction(1, 180)) for n in range(1, 7)]
        assert app.simulation.get_num_physics_steps() == 2
        end()
        app.update()
        assert len(seen) == 6


def test_ticks_across_the_end_of_a_loop_stay_inside_it():
    with App(loop_hz=60) as app:
        app.timeline.set_end_time(Fraction(1, 40))  # one and a half updates
        app.timeline.set_ticks_per_frame(2)
        seen = []
        app.timeline.on_tick(lambda time, delta: seen.append(time))
        app.play()
        app.update(2)
        assert seen == [Fraction(1, 120), Fraction(2, 120), Fraction(3, 120), Fraction(1, 120)]


def test_auto_update_off_holds_the_timeline_while_playing_and_physics_with_it():
    with App() as app:
        app.timeline.set_auto_update(False)
        app.play()
        app.update(5)
        assert (app.timeline.current_time, app.simulation.time) == (0, 0)
        app.timeline.forward_one_frame()
        assert app.timeline.current_time == Fraction(1, 60)


def test_forward_one_frame_moves_by_one_over_tcps_whatever_the_loop_is():
    with App(loop_hz=200, settings={keys.TIME_CODES_PER_SECOND: 24}) as app:
        app.timeline.forward_one_frame()
        assert app.timeline.current_time == Fraction(1, 24)
        app.play()
        app.timeline.forward_one_frame()
        assert app.timeline.current_time == Fraction(2, 24)


def test_the_end_time_loops_the_timeline_but_not_the_simulation():
    with App() as app:
        app.timeline.set_end_time(1)
        app.play()
        app.update(90)
        assert app.timeline.current_time == Fraction(1, 2)
        assert app.simulation.time == Fraction(3, 2)


def test_the_end_time_stops_without_looping():
    with App() as app:
        app.timeline.set_end_time(1)
        app.timeline.set_looping(False)
        app.play()
        app.update(62)
        assert app.timeline.is_stopped()
        assert app.simulation.time == 0


def test_a_new_stage_has_60_time_codes_a_second_and_the_base_app_s_wide_range():
    with App() as app:
        assert app.timeline.get_time_codes_per_second() == 60
        assert (app.timeline.get_start_time(), app.timeline.get_end_time()) == (0, 1_000_000 / 60)


# -- the real wall clock -------------------------------------------------------------------------------------------

REAL = {
    "real time": ({"loop_hz": 100, "physics_hz": 100}, 1.0),
    "slow motion": (
        {"loop_hz": 100, "physics_hz": 200, "experience": "full", "settings": {keys.TIME_CODES_PER_SECOND: 200}},
        0.5,
    ),
    "one in two": (
        {"loop_hz": 200, "physics_hz": 100, "experience": "full", "settings": {keys.TIME_CODES_PER_SECOND: 100}},
        1.0,
    ),
    "fast mode": (
        {
            "loop_hz": 200,
            "physics_hz": 50,
            "experience": "full",
            "settings": {keys.TIME_CODES_PER_SECOND: 50, keys.FAST_MODE: True},
        },
        4.0,
    ),
    "capped": ({"loop_hz": 100, "physics_hz": 400, "settings": {keys.MIN_FRAME_RATE: 200}}, 0.5),
}


@pytest.mark.parametrize(("options", "ratio"), REAL.values(), ids=REAL.keys())
def test_simulated_over_wall_time_as_measured_on_both_wall_clocks(options, ratio):
    with App(**options) as app:
        app.play()
        app.update(60)
        assert app.speed == Fraction(ratio)
    with App(**options, wall_clock=RealClock()) as app:
        before = time.perf_counter()
        app.play()
        began = time.perf_counter()
        app.update(61)
        ended = time.perf_counter()
        # a loaded machine may be late, never early; to play takes it some time too
        assert 0.3 * ratio < app.speed <= 1.05 * ratio
        simulated = float(app.simulation.time)
        assert 0.9 * simulated / (ended - before) <= app.speed <= 1.1 * simulated / (ended - began)


def test_lateness_is_made_up_for_as_far_as_compensate_play_delay_says(monkeypatch):
    now = [10_000_000_000]
    slept = []

    def sleep(seconds):
        slept.append(round(seconds, 9))
        now[0] += round(seconds * 1e9)

    monkeypatch.setattr(time, "monotonic_ns", lambda: now[0])
    monkeypatch.setattr(time, "sleep", sleep)
    for seconds, expected in ((0.0, [0.1, 0.1, 0.1]), (0.25, [0.05, 0.1, 0.1]), (10.0, [])):
        with App(loop_hz=10, wall_clock=RealClock(), settings={keys.PLAY_DELAY: seconds}) as app:
            app.play()
            app.update(2)  # the first one starts the beat
            slept.clear()
            now[0] += 500_000_000  # half a second lost: five updates' worth
            app.update()
            slept.clear()
            app.update(5 if seconds == 0.25 else 3)
            assert slept == expected, seconds
            assert {app.timeline.delta} == {Fraction(1, 10)}  # a frame keeps its length


def test_the_speed_stands_while_paused_and_is_unknown_before_play():
    with App() as app:
        assert app.speed is None
        app.update(3)
        app.play()
        app.update(6)
        app.pause()
        app.update(60)
        assert app.speed == 1


def test_full_takes_manual_steps_while_playing_only():
    with App(experience="full") as app:
        assert not app.run_loop.manual_mode
        app.play()
        assert app.run_loop.manual_mode
        app.pause()
        assert not app.run_loop.manual_mode


# -- rates that follow ---------------------------------------------------------------------------------------------

GRAPH = """\
tickgraph: 1
clock: {{physics_hz: {physics}, loop_hz: {loop}, experience: {experience}, parity: {parity}}}
settings: {settings}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      gate: {{type: IsaacSimulationGate, inputs: {{step: 2}}}}
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      gated: {{type: ROS2PublishClock, inputs: {{topicName: gated}}}}
    connections:
      - tick.tick -> clock.execIn
      - tick.tick -> gate.execIn
      - gate.execOut -> gated.execIn
      - time.simulationTime -> [clock.timeStamp, gated.timeStamp]
"""
NO_CAP = {keys.MIN_FRAME_RATE: 0, keys.WARM_UP_STEPS: 0}
MODES = {
    # name: (options, settings, updates in a second of wall time, messages of /clock and behind the gate, lidar, camera)
    "coherent 60": ({"physics": 60, "loop": 60}, {}, 60, 30, 5, 15),
    "coherent 120": ({"physics": 120, "loop": 120}, {}, 120, 60, 5, 15),
    "coherent 10": ({"physics": 10, "loop": 10}, {}, 10, 5, 5, 10),
    "fixed 60": ({"physics": 60, "loop": 60, "experience": "full"}, {}, 60, 30, 5, 15),
    "zero delay 60": ({"physics": 60, "loop": 60, "experience": "zero_delay"}, {}, 60, 30, 5, 15),
    "slow motion": ({"physics": 60, "loop": 20, "experience": "full"}, {}, 20, 10, 5 / 3, 5),
    "one in two": ({"physics": 60, "loop": 120, "experience": "full"}, {}, 120, 60, 5, 15),
    "fast mode": ({"physics": 60, "loop": 240, "experience": "full"}, {keys.FAST_MODE: True}, 240, 120, 20, 60),
    "physics slower": ({"physics": 20, "loop": 60}, {}, 60, 30, 5, 15),
    "capped": ({"physics": 60, "loop": 20}, {keys.MIN_FRAME_RATE: 30}, 20, 10, 10 / 3, 10),
}


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
@pytest.mark.parametrize(("options", "settings", "clock", "gated", "lidar", "camera"), MODES.values(), ids=MODES.keys())
def test_rates_that_follow(tmp_path, options, settings, clock, gated, lidar, camera, parity):
    """/clock once per update, behind a gate of 2 every second one, sensors min(tick rate, rate) of simulated time."""
    file = tmp_path / "g.yaml"
    settings = {**NO_CAP, keys.REWRITE_RATE_LIMIT: False, **settings}
    text = ", ".join(f"{path}: {str(value).lower()}" for path, value in settings.items())
    file.write_text(GRAPH.format(**{"experience": "base", **options}, parity=parity, settings="{" + text + "}"))
    with App.from_file(file) as app:
        turning, seeing = add(app, NotingLidar(5), "lidar"), add(app, NotingSensor(15), "camera")
        counter = CountingSink()
        app.bus.subscribe(counter)
        app.play()
        app.update(clock * 3)
        messages = {topic: count.messages for topic, count in counter.topics()}
        assert app.wall_clock.now() == 3
        assert messages == {"/clock": clock * 3, "/gated": gated * 3}
        assert (len(turning.ticks), len(seeing.ticks)) == (round(lidar * 3), round(camera * 3))


@pytest.mark.parametrize("name", ["slow motion", "one in two"])
def test_on_playback_tick_fires_in_every_update_with_the_timeline_s_delta(tmp_path, name):
    options = MODES[name][0]
    file = tmp_path / "g.yaml"
    file.write_text(GRAPH.format(**options, parity="documented", settings="{}"))
    with App.from_file(file) as app:
        app.play()
        tick = app.graphs["/World/G"].nodes["tick"]
        seen = []
        app.on("end", lambda: seen.append(tick.get("deltaSeconds")))
        app.update(6)
        assert tick.fired["tick"] == 6
        assert seen == ([1 / 60] * 6 if name == "slow motion" else [1 / 60, 0.0] * 3)
