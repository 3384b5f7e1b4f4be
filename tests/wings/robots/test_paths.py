"""Planning, following, arriving."""

import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from wings.robots.planar import heading, wrapped
from wings.robots.quintic import Stance, coefficients, plan_path
from wings.robots.stanley import speed_profile, steering_angle


def facing(degrees):
    half = math.radians(degrees) / 2
    return [0, 0, math.sin(half), math.cos(half)]


def run(node, updates=1, **inputs):
    return run_node(node, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates)


@pytest.mark.parametrize("degrees", [0, 30, 90, 170, -45, -179])
def test_a_heading_is_the_angle_about_z(degrees):
    assert heading(facing(degrees)) == pytest.approx(math.radians(degrees))
    assert heading([3 * part for part in facing(degrees)]) == pytest.approx(math.radians(degrees))


def test_no_rotation_has_heading_0_and_angles_are_wrapped():
    assert heading([0, 0, 0, 0]) == heading([math.nan] * 4) == 0
    assert wrapped(3 * math.pi / 2) == pytest.approx(-math.pi / 2)


def test_a_goal_is_reached_in_place_and_heading():
    def reached(position, degrees):
        inputs = {"currentPosition": position, "currentOrientation": facing(degrees)}
        trace = run("CheckGoal2D", **inputs, target=[1, 2, math.pi / 2], targetChanged=True)
        return trace.value("reachedGoal").tolist()

    assert reached([1, 2.05, 7], 92) == [True, True]
    assert reached([1, 2.2, 0], 80) == [False, False]
    assert reached([1, 2, 0], -90) == [True, False]


def test_a_goal_is_taken_over_when_it_is_reported_to_have_changed():
    trace = run("CheckGoal2D", 3, currentPosition=[5, 0, 0], target=[5, 0, 0], targetChanged=lambda update: update == 1)
    assert [one.tolist() for one in trace.values("reachedGoal")] == [[False, True], [True, True], [True, True]]
    assert trace.fired("execOut") == [0, 1, 2]


def test_a_polynomial_from_rest_to_rest():
    # x = 10 s^3 - 15 s^4 + 6 s^5 with s = t / 2.
    assert coefficients((0, 0, 0), (1, 0, 0), 2.0) == pytest.approx([0, 0, 0, 10 / 8, -15 / 16, 6 / 32])


def test_a_straight_path_at_constant_speed_takes_its_time():
    path = plan_path(Stance(0, 0, 0, 1, 0), Stance(10, 0, 0, 1, 0), 1.5, 0.3, 0.5)
    assert path.xs == pytest.approx(np.arange(21) * 0.5)
    assert path.speeds == pytest.approx(np.ones(21))
    assert np.abs(path.ys).max() == np.abs(path.headings).max() == pytest.approx(0)


def test_the_shortest_time_within_the_limits_is_taken():
    # From rest to rest over 20 m the largest jerk, at both ends, is 60 * 20 / T^3: 0.3 m/s3 needs T >= 15.9 s.
    path = plan_path(Stance(0, 0, 0, 0, 0), Stance(20, 0, 0, 0, 0), 1.5, 0.3, 1.0)
    assert len(path.xs) == 21
    assert plan_path(Stance(0, 0, 0, 0, 0), Stance(20, 0, 0, 0, 0), 1.5, 10.0, 1.0).xs.size == 11


def plan(updates=1, **inputs):
    given = {"currentOrientation": facing(0), "targetPosition": [4, 2, 0], "targetOrientation": facing(90), **inputs}
    return run("QuinticPathPlanner", updates, **given)


def test_a_planned_path_goes_from_the_robot_to_the_goal():
    trace = plan()
    speeds, xs, ys, headings = trace.value("pathArrays").reshape(4, -1)
    assert [xs[0], ys[0], headings[0], speeds[0]] == pytest.approx([0, 0, 0, 0.5])
    times = np.arange(len(xs)) * 0.16666666667
    last = int(np.argmin(np.abs(times - round(times[-1] / 5) * 5)))
    assert [xs[last], ys[last], speeds[last]] == pytest.approx([4, 2, 0.5], abs=1e-6)
    assert headings[last] == pytest.approx(math.pi / 2)
    assert trace.value("target") == pytest.approx([4, 2, math.pi / 2])
    assert trace.value("targetChanged")


def test_a_path_is_kept_until_the_goal_moves():
    goals = {0: [4, 2, 0], 1: [4.05, 2.05, 0], 2: [4.2, 2, 0]}
    trace = plan(3, targetPosition=lambda update: goals[update])
    assert trace.values("targetChanged") == [True, False, True]
    first, second, third = trace.values("pathArrays")
    assert np.array_equal(first, second)
    assert not np.array_equal(second, third)
    assert trace.fired("execOut") == [0, 1, 2]


def test_the_goal_may_be_a_prim(stage, world):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    flag = UsdGeom.Xform.Define(stage, "/World/Flag")
    flag.AddTranslateOp().Set((300, 100, 0))
    flag.AddRotateZOp().Set(-90)
    inputs = {"targetPrim": ["/World/Flag"], "currentOrientation": facing(0)}
    trace = run_node("QuinticPathPlanner", inputs=inputs, pulses={"execIn": [0]}, app=world())
    assert trace.value("target") == pytest.approx([3, 1, -math.pi / 2])


def test_a_path_needs_a_step():
    with pytest.raises(ComputeError, match="input step is 0 s; give it a positive time"):
        plan(step=0.0)


def test_wanted_speeds_reach_the_largest_and_fall_over_the_last_third():
    assert speed_profile(np.array([0.5, 1.0, 1.0, 1.0, 1.0, 0.0]), 2.0).tolist() == [1, 2, 2, 2, 2, 0.05]
    profile = speed_profile(np.ones(12), 2.0)
    assert profile[:9].tolist() == [2] * 9
    assert profile[9:] == pytest.approx([2, math.sqrt(2), 2 / math.sqrt(3)])
    assert speed_profile(np.zeros(3), 2.0).tolist() == [0, 0, 0]


def test_steering_turns_to_the_path():
    xs = np.arange(10.0)
    path = (xs, np.zeros(10), np.zeros(10))
    # 1 m to the left of a path along x: arctan(0.5 * 1 / 1) to the right.
    angle, index = steering_angle((2.0, 1.0, 0.0), 1.0, path, 0, 1.0, 0.5)
    assert (angle, index) == (pytest.approx(-math.atan(0.5)), 3)
    angle, index = steering_angle((2.0, 0.0, 0.3), 1.0, path, 5, 0.0, 0.5)
    assert (angle, index) == (pytest.approx(-0.3), 5)


STRAIGHT = [*[1.0] * 9, *range(9), *[0.0] * 9, *[0.0] * 9]


def follow(updates=1, **inputs):
    given = {
        "pathArrays": STRAIGHT,
        "target": [8, 0, math.pi / 2],
        "targetChanged": lambda update: update == 0,
        "currentOrientation": facing(0),
        "maxVelocity": 2.0,
        "gains": [0.5, 0.5, 0.1],
        "wheelBase": 1.0,
        "step": 0.5,
        **inputs,
    }
    return run("StanleyControlPID", updates, **given)


def test_on_the_path_only_the_speed_is_controlled():
    trace = follow(currentSpeed=[1, 0, 0])
    assert trace.value("linearVelocity") == pytest.approx(1.5)  # 1 + 0.5 (2 - 1)
    assert trace.value("angularVelocity") == pytest.approx(0)
    assert trace.fired("execOut") == [0]


def test_beside_the_path_the_robot_turns_to_it_at_most_with_the_largest_angle():
    trace = follow(currentPosition=[1, 1, 0], currentSpeed=[1, 0, 0])
    # 0.1 rad at most on an arm of 0.5 m; on two wheels it turns 1 + w / v * 0.5 / 0.5 times as fast.
    w = math.tan(0.1) / 0.5
    assert trace.value("angularVelocity") == pytest.approx(-w * (1 + w / 1.5))


def test_near_the_goal_it_turns_on_the_spot():
    trace = follow(currentPosition=[8, 0.05, 0], currentOrientation=facing(60))
    assert trace.value("linearVelocity") == 0
    assert trace.value("angularVelocity") == pytest.approx(math.radians(30))  # * 0.5 / 0.5
    assert follow(currentPosition=[8, 0, 0]).value("angularVelocity") == 1.0
    assert follow(currentPosition=[8, 0, 0], currentOrientation=facing(-170)).value("angularVelocity") == -1.0


def test_at_the_goal_it_stands_still():
    trace = follow(reachedGoal=[True, True], currentSpeed=[1, 0, 0])
    assert [trace.value(name) for name in ("linearVelocity", "angularVelocity")] == [0, 0]
    assert trace.fired("execOut") == [0]


def test_without_a_path_nothing_is_computed():
    assert follow(targetChanged=False, currentPosition=[5, 5, 0]).fired("execOut") == []


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"wheelBase": 0.0}, "wheelBase is 0 m and step 0.5 s; give both a positive value"),
        ({"pathArrays": [1.0, 2.0, 3.0]}, "pathArrays has 3 numbers; it holds speeds, x, y and headings"),
    ],
)
def test_what_cannot_be_followed_is_reported(inputs, message):
    with pytest.raises(ComputeError, match=message):
        follow(**inputs)
