"""The timeline: states, variable and fixed stepping, the end time."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim import settings as keys
from graph.sim.settings import Settings
from graph.sim.timing.timeline import Timeline

DT = Fraction(1, 60)


def settings_of(**values):
    return Settings({getattr(keys, name.upper()): value for name, value in values.items()})


def timeline(changes=None, settings=None, **values):
    known = settings_of(**values) if settings is None else settings
    return Timeline(known, (lambda change: None) if changes is None else changes.append)


def playing(**values):
    made = timeline(**values)
    made.play()
    made.commit()
    return made


def test_changes_wait_for_commit():
    changes = []
    line = timeline(changes)
    line.play()
    assert (line.is_playing(), changes) == (False, [])
    line.commit()
    assert (line.is_playing(), changes) == (True, ["play"])


def test_each_transition_is_reported_once_and_in_order():
    changes = []
    line = timeline(changes)
    for change in (line.pause, line.play, line.play, line.pause, line.pause, line.play, line.stop, line.stop):
        change()
    line.commit()
    assert changes == ["play", "pause", "resume", "stop"]


def test_paused_is_neither_playing_nor_stopped():
    line = playing()
    line.pause()
    line.commit()
    assert (line.is_playing(), line.is_stopped(), line.is_paused()) == (False, False, True)


def test_time_moves_only_while_playing():
    line = playing()
    assert [line.advance(DT) for _ in range(3)] == [DT] * 3
    line.pause()
    line.commit()
    assert line.advance(DT) == 0
    assert line.current_time == Fraction(3, 60)
    line.play()
    line.commit()
    line.advance(DT)
    assert line.current_time == Fraction(4, 60)


def test_an_hour_has_no_drift():
    line = playing()
    for _ in range(60 * 3600):
        line.advance(DT)
    assert line.current_time == 3600
    assert line.get_current_time() == 3600.0


def test_stop_goes_back_to_the_start_time():
    line = playing()
    line.set_start_time(2)
    line.advance(DT)
    line.stop()
    line.commit()
    assert (line.get_current_time(), line.delta) == (2.0, 0)


def test_a_world_that_cannot_be_built_does_not_play():
    def refuse(change):
        raise UserError("no")

    line = Timeline(Settings(), refuse)
    line.play()
    with pytest.raises(UserError):
        line.commit()
    assert line.is_stopped()


def test_the_end_loops_exactly():
    line = playing()
    line.set_end_time(0.1)
    for _ in range(8):
        line.advance(DT)
    assert line.current_time == Fraction(8, 60) - Fraction(1, 10)


def test_the_end_stops_without_looping():
    line = playing()
    line.set_end_time(0.05)
    line.set_looping(False)
    for _ in range(4):
        line.advance(DT)
    assert line.current_time == Fraction(1, 20)
    line.commit()
    assert line.is_stopped()


def test_without_auto_update_it_holds_still_but_frames_can_be_stepped():
    line = playing()
    line.set_auto_update(False)
    assert line.advance(DT) == 0
    line.forward_one_frame()
    line.forward_one_frame()
    assert line.current_time == Fraction(2, 60)
    line.rewind_one_frame()
    assert line.current_time == Fraction(1, 60)


def fixed(tcps, target=60, fast=False):
    return playing(fixed_stepping=True, time_codes_per_second=tcps, target_framerate=target, fast_mode=fast)


def test_fixed_stepping_moves_by_the_frame_whatever_the_loop_measures():
    line = fixed(60)
    assert [line.advance(dt) for dt in (Fraction(1, 30), Fraction(1, 1000), Fraction(2))] == [DT] * 3


def test_a_loop_slower_than_the_frames_is_slow_motion():
    line = fixed(60, target=30)
    assert line.updates_per_frame == 1
    for _ in range(30):
        line.advance(Fraction(1, 30))
    assert line.current_time == Fraction(1, 2)


def test_a_loop_faster_than_the_frames_accepts_one_update_in_n():
    line = fixed(30, target=50)
    assert line.updates_per_frame == 2
    assert [line.advance(DT) for _ in range(5)] == [Fraction(1, 30), 0, Fraction(1, 30), 0, Fraction(1, 30)]


def test_fast_mode_accepts_every_update():
    line = fixed(60, target=240, fast=True)
    for _ in range(240):
        line.advance(Fraction(1, 240))
    assert line.current_time == 4


@pytest.mark.parametrize(("tcps", "target", "n"), [(30, 50, 2), (60, 60, 1), (60, 100, 2), (60, 120, 2), (24, 60, 3)])
def test_updates_per_frame(tcps, target, n):
    assert fixed(tcps, target).updates_per_frame == n


def test_switching_the_mode_waits_for_the_next_play_from_stopped():
    settings = settings_of()
    line = playing(settings=settings)
    settings.set(keys.FIXED_STEPPING, True)
    assert line.advance(Fraction(1, 30)) == Fraction(1, 30)
    line.stop()
    line.play()
    line.commit()
    assert line.advance(Fraction(1, 30)) == DT


def test_play_rewrites_the_rate_limit_only_where_asked():
    wanted = {"fixed_stepping": True, "time_codes_per_second": 60, "target_framerate": 100}
    for more, limit in (({}, 60), ({"rewrite_rate_limit": True}, 120)):
        settings = settings_of(**wanted, **more)
        playing(settings=settings)
        assert settings.get(keys.RATE_LIMIT_FREQUENCY) == limit


def test_rates_are_exact_and_positive():
    line = timeline()
    line.set_time_codes_per_second(29.97)
    assert line.time_codes_per_second == Fraction(2997, 100)
    with pytest.raises(UserError, match="above 0"):
        line.set_time_codes_per_second(0)
    with pytest.raises(UserError, match="above 0"):
        line.set_target_framerate(-1)
