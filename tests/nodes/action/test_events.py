import pytest

from graph.testing import run_node


def test_on_playback_tick_fires_in_every_update_while_playing():
    trace = run_node("OnPlaybackTick", updates=6, playing=lambda update: update in (1, 2, 5))
    assert trace.fired("tick") == [1, 2, 5]


def test_on_playback_tick_tells_the_time_of_the_update():
    trace = run_node("OnPlaybackTick", updates=3, loop_hz=30)
    assert trace.values("deltaSeconds") == [1 / 30] * 3
    assert trace.values("time") == [1 / 30, 2 / 30, 3 / 30]
    assert trace.values("frame") == [2.0, 4.0, 6.0]


def test_on_tick_with_framePeriod_2_fires_in_every_third_update_from_the_first():
    trace = run_node("OnTick", inputs={"framePeriod": 2}, updates=8)
    assert trace.fired("tick") == [0, 3, 6]
    assert trace.values("deltaSeconds")[0] == pytest.approx(1 / 60)
    assert trace.values("deltaSeconds")[6] == pytest.approx(3 / 60)
    assert trace.values("frameCount") == [1, 2, 0, 1, 2, 0, 1, 2]


def test_on_tick_fires_in_every_update_by_default():
    trace = run_node("OnTick", updates=4)
    assert trace.fired("tick") == [0, 1, 2, 3]
    assert trace.values("isPlaying") == [True] * 4


@pytest.mark.parametrize(("only_playback", "fired"), [(True, []), (False, [0, 1])])
def test_on_tick_ignores_updates_without_playback_on_request(only_playback, fired):
    trace = run_node("OnTick", inputs={"onlyPlayback": only_playback}, updates=2, playing=False)
    assert trace.fired("tick") == fired


def test_an_impulse_fires_once_however_often_it_was_set():
    def impulse(update, node):
        if update in (1, 4):
            for _ in range(3):
                node.set("state:enableImpulse", True)

    trace = run_node("OnImpulseEvent", updates=6, on_update=impulse)
    assert trace.fired("execOut") == [1, 4]
    assert trace.value("enableImpulse") is False


def test_an_impulse_waits_for_playback():
    trace = run_node("OnImpulseEvent", inputs={"state:enableImpulse": True}, updates=4, playing=lambda u: u >= 2)
    assert trace.fired("execOut") == [2]
