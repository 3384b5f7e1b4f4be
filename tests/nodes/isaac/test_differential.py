import math

import pytest

from graph import ComputeError
from graph.testing import run_node
from nodes.isaac.differential import Drive, approach


def drive(updates=1, pulses=None, **inputs):
    settings = {"wheelRadius": 0.5, "wheelDistance": 1.0, **inputs}
    pulses = {"execIn": range(updates)} if pulses is None else pulses
    return run_node("DifferentialController", inputs=settings, pulses=pulses, updates=updates)


def test_turning_on_the_spot_spins_the_wheels_against_each_other():
    assert list(drive(angularVelocity=2.0).value("velocityCommand")) == [-2.0, 2.0]


def test_driving_straight_spins_both_wheels_alike():
    assert list(drive(linearVelocity=1.5).value("velocityCommand")) == [3.0, 3.0]


def test_a_curve_is_the_sum_of_both():
    # wl = (2 * 1 - 2 * 1) / 1, wr = (2 * 1 + 2 * 1) / 1
    assert list(drive(linearVelocity=1.0, angularVelocity=2.0).value("velocityCommand")) == [0.0, 4.0]


@pytest.mark.parametrize(
    ("limit", "inputs", "command"),
    [
        ("maxLinearSpeed", {"linearVelocity": -3.0}, [-2.0, -2.0]),
        ("maxAngularSpeed", {"angularVelocity": 5.0}, [-1.0, 1.0]),
        ("maxWheelSpeed", {"linearVelocity": 1.0, "angularVelocity": 2.0}, [0.0, 1.0]),
    ],
)
def test_speeds_are_limited(limit, inputs, command):
    assert list(drive(**inputs, **{limit: 1.0}).value("velocityCommand")) == command


def test_speeds_grow_by_maxAcceleration_and_shrink_by_maxDeceleration():
    trace = drive(
        updates=6,
        dt=0.5,
        maxAcceleration=1.0,
        maxDeceleration=2.0,
        linearVelocity=lambda update: 1.25 if update < 3 else -1.0,
    )
    body = [command[0] * 0.5 for command in trace.values("velocityCommand")]
    assert body == [0.5, 1.0, 1.25, 0.25, 0.0, -0.5]


def test_the_turn_rate_changes_by_maxAngularAcceleration():
    trace = drive(updates=3, dt=0.5, maxAngularAcceleration=1.0, angularVelocity=1.2)
    rates = [command[1] - command[0] for command in trace.values("velocityCommand")]
    assert rates == pytest.approx([1.0, 2.0, 2.4])  # wr - wl = w d / r = 2 w


def test_one_of_the_two_acceleration_limits_alone_does_not_limit():
    assert list(drive(linearVelocity=9.0, maxAcceleration=1.0).value("velocityCommand")) == [18.0, 18.0]


def test_acceleration_limits_need_a_time_step():
    trace = drive(updates=2, linearVelocity=1.0, maxAcceleration=1.0, maxDeceleration=1.0)
    assert list(trace.value("velocityCommand")) == [0.0, 0.0]


def test_limits_are_read_once_and_again_after_a_stop():
    def stop_at_2(update, node):
        if update == 2:
            node.graph.reset()

    trace = run_node(
        "DifferentialController",
        inputs={"wheelRadius": lambda update: 0.5 * (update + 1), "wheelDistance": 1.0, "linearVelocity": 3.0},
        pulses={"execIn": range(3)},
        updates=3,
        on_update=stop_at_2,
    )
    assert [command[0] for command in trace.values("velocityCommand")] == [6.0, 6.0, 2.0]


@pytest.mark.parametrize("radius", [0.0, -0.1, math.nan, math.inf])
def test_a_wheel_radius_that_cannot_be_is_refused(radius):
    with pytest.raises(ComputeError, match=r"wheelRadius is .*; give it a positive length"):
        drive(wheelRadius=radius)


@pytest.mark.parametrize(
    ("current", "target", "step"),
    [(0, 5, 1), (1, 5, 2), (3, 1, 1), (0.5, -4, 0), (-3, 4, -1), (-1, -5, -2), (2, 2, 2), (1, 0, 0)],
)
def test_approach_brakes_to_rest_before_it_reverses(current, target, step):
    assert approach(current, target, gain=1, loss=2) == step


def test_the_wheel_speeds_invert_the_unicycle_model():
    left, right = Drive(wheel_radius=0.1, wheel_distance=0.4).wheel_speeds(0.7, -0.3)
    assert 0.1 * (left + right) / 2 == pytest.approx(0.7)
    assert 0.1 * (right - left) / 0.4 == pytest.approx(-0.3)
