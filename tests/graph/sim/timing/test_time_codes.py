"""A scene that says from which time code to which it plays: the timeline starts, loops and ends there."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.sim import App

SCENE = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
    METADATA
)
def Xform "World"
{
    def Cube "Door"
    {
        double3 xformOp:translate.timeSamples = {12: (0, 0, 0), 36: (24, 0, 0)}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""
RANGE = "timeCodesPerSecond = 24\nstartTimeCode = 12\nendTimeCode = 36"  # 0.5 s to 1.5 s


@pytest.fixture
def scene(tmp_path):
    def write(metadata):
        path = tmp_path / "scene.usda"
        path.write_text(SCENE.replace("METADATA", metadata))
        return path

    return write


def test_the_timeline_starts_at_the_scene_s_start_and_goes_back_there_at_its_end(scene):
    with App(scene(RANGE), loop_hz=10, physics_hz=10) as app:
        line = app.timeline
        assert (line.get_start_time(), line.get_end_time(), line.get_current_time()) == (0.5, 1.5, 0.5)
        app.play()
        times = []
        for _ in range(21):
            app.update()
            times.append(line.current_time)
        assert times[:10] == times[10:20] == [Fraction(5 + k, 10) for k in range(1, 11)]  # 1.5 s is still shown
        assert app.simulation.time == Fraction(21, 10)  # the physics clock goes on
        app.stop()
        assert line.current_time == Fraction(1, 2)


def test_what_is_animated_goes_back_with_the_timeline(scene):
    """The door moves by 1 a time code, 24 a second: at 0.7 s it is at 4.8, one loop later again."""
    with App(scene(RANGE), loop_hz=10, physics_hz=10) as app:
        door = app.fabric.get_prim_at_path("/World/Door").get_attribute("omni:fabric:worldMatrix")
        app.play()
        for updates in (2, 10):
            app.update(updates)
            assert door.get()[3][0] == pytest.approx(4.8)


def test_without_looping_the_timeline_stops_at_the_scene_s_end(scene):
    with App(scene(RANGE), loop_hz=10) as app:
        app.timeline.set_looping(False)
        app.play()
        app.update(12)
        assert app.timeline.is_stopped()
        assert app.timeline.get_current_time() == 0.5


@pytest.mark.parametrize(
    "metadata",
    [
        "timeCodesPerSecond = 24",
        "startTimeCode = 1",  # endless
        "startTimeCode = 0\nendTimeCode = 0",  # a still scene
        "startTimeCode = 1\nendTimeCode = 1",
    ],
)
def test_a_scene_that_names_no_span_plays_on(scene, metadata):
    with App(scene(metadata)) as app:
        rate = app.timeline.time_codes_per_second
        assert (app.timeline.start_time, app.timeline.end_time) == (0, 1_000_000 / rate)
        assert list(app.warnings) == []


@pytest.mark.parametrize("end", ["-5", "nan", "inf"])
def test_time_codes_that_end_before_they_start_are_reported_and_ignored(scene, end):
    with App(scene(f"startTimeCode = 3\nendTimeCode = {end}")) as app:
        (warning,) = app.warnings
        assert warning.code == "time-range-ignored"
        assert f"from 3 to {end}" in warning.message
        assert app.timeline.start_time == 0


def test_without_a_rate_of_its_own_a_scene_has_usd_s_24_time_codes_a_second(scene):
    with App(scene("startTimeCode = 0\nendTimeCode = 48")) as app:
        assert app.timeline.get_end_time() == 2.0


def test_a_new_stage_has_isaac_sim_s_time_codes_and_plays_on():
    """0 to 100 at 60 a second would end after 1.667 s; nobody asked for that."""
    with App() as app:
        stage = app.stage
        assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (0, 100, 60)
        app.play()
        app.update(120)
        assert (app.timeline.current_time, app.timeline.end_time) == (2, Fraction(1_000_000, 60))


def test_a_stage_in_memory_brings_its_time_codes_too():
    from graph.sim import register_schemas

    register_schemas()
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(30)
    stage.SetStartTimeCode(-15)
    stage.SetEndTimeCode(15)
    with App(stage) as app:
        assert (app.timeline.start_time, app.timeline.end_time) == (Fraction(-1, 2), Fraction(1, 2))
