import math

import pytest

from graph import ComputeError
from graph.testing import run_node
from wings.robots.ackermann import Car, ramped

CAR = {"wheelBase": 2.0, "trackWidth": 1.0, "frontWheelRadius": 0.25, "backWheelRadius": 0.5}


def drive(updates=1, **inputs):
    return run_node("AckermannController", inputs={**CAR, **inputs}, pulses={"execIn": range(updates)}, updates=updates)


def test_straight_ahead_all_wheels_roll_alike():
    trace = drive(speed=1.0)
    assert trace.value("wheelAngles").tolist() == [0, 0]
    assert trace.value("wheelRotationVelocity").tolist() == [4, 4, 2, 2]
    assert trace.fired("execOut") == [0]


def test_in_a_left_turn_the_left_wheels_turn_more_and_roll_less():
    # tan(angle) = 1: the centre of the turn is 2 m to the left of the middle of the back axle.
    trace = drive(speed=1.0, steeringAngle=math.pi / 4)
    assert trace.value("wheelAngles") == pytest.approx([math.atan(2 / 1.5), math.atan(2 / 2.5)])
    # The body turns with 1 / 2 rad/s; the front wheels are hypot(1.5, 2) = 2.5 and hypot(2.5, 2) m from the centre.
    expected = [0.5 * 2.5 / 0.25, 0.5 * math.hypot(2.5, 2) / 0.25, 0.5 * 1.5 / 0.5, 0.5 * 2.5 / 0.5]
    assert trace.value("wheelRotationVelocity") == pytest.approx(expected)


def test_a_right_turn_is_the_mirror_of_a_left_one():
    left, right = (drive(speed=1.0, steeringAngle=angle) for angle in (0.3, -0.3))
    assert right.value("wheelAngles") == pytest.approx(-left.value("wheelAngles")[::-1])
    assert right.value("wheelRotationVelocity") == pytest.approx(left.value("wheelRotationVelocity")[[1, 0, 3, 2]])


def test_a_car_that_steers_behind_has_its_near_wheels_in_front():
    trace = drive(speed=1.0, steeringAngle=math.pi / 4, invertSteering=True)
    assert trace.value("wheelAngles") == pytest.approx([math.atan(2 / -2.5), math.atan(2 / -1.5)])
    expected = [0.5 * 1.5 / 0.25, 0.5 * 2.5 / 0.25, 0.5 * 2.5 / 0.5, 0.5 * math.hypot(2.5, 2) / 0.5]
    assert trace.value("wheelRotationVelocity") == pytest.approx(expected)


def test_a_wheel_beside_the_centre_of_the_turn_stands_across():
    car = Car(1.0, 2.0, 0.5, 0.5)
    (left, right), _ = car.wheels(1.0, math.atan(1.0))
    assert left == pytest.approx(math.pi / 2)
    assert right == pytest.approx(math.atan(0.5))


@pytest.mark.parametrize(("angle", "steers"), [(0.0156, False), (0.0158, True), (-0.0156, False), (-0.0158, True)])
def test_less_than_nine_tenths_of_a_degree_is_straight(angle, steers):
    assert bool(drive(speed=1.0, steeringAngle=angle).value("wheelAngles").any()) is steers


def test_limits_hold_the_wheels():
    trace = drive(speed=100.0, maxWheelVelocity=3.0)
    # 3 rad/s of the larger wheels are 1.5 m/s; the smaller ones would turn with 6 rad/s.
    assert trace.value("wheelRotationVelocity").tolist() == [3, 3, 3, 3]
    trace = drive(steeringAngle=1.0, maxWheelRotation=0.5)
    inner = math.atan(2 / (2 / math.tan(0.5) - 0.5))
    assert inner > 0.5
    assert trace.value("wheelAngles") == pytest.approx([0.5, math.atan(2 / (2 / math.tan(0.5) + 0.5))])


def test_speed_and_angle_are_ramped():
    trace = drive(4, trackWidth=0.0, speed=1.0, acceleration=2.0, steeringAngle=0.4, steeringAngleVelocity=0.5, dt=0.25)
    assert [speeds[2] * 0.5 for speeds in trace.values("wheelRotationVelocity")] == pytest.approx([0.5, 1, 1, 1])
    assert [left for left, _ in trace.values("wheelAngles")] == pytest.approx([0.125, 0.25, 0.375, 0.4])


def test_ramps_are_limited():
    trace = drive(3, speed=1.0, acceleration=4.0, maxAcceleration=1.0, dt=0.25)
    assert [speeds[2] * 0.5 for speeds in trace.values("wheelRotationVelocity")] == [0.25, 0.5, 0.75]


def test_a_ramp_without_time_step_warns_and_leaves_the_wheels():
    trace = drive(2, speed=1.0, acceleration=1.0)
    assert trace.value("wheelRotationVelocity").size == 0
    assert trace.fired("execOut") == [0, 1]
    assert [(one.code, one.count) for one in trace.warnings] == [("time-step-missing", 2)]


@pytest.mark.parametrize(
    ("current", "target", "result"),
    [(0, 1, 0.25), (0.9, 1, 1), (1, 0, 0.75), (0.1, 0, 0), (0, -1, -0.25), (1, 1.00005, 1)],
)
def test_a_ramp_takes_one_step_and_ignores_tiny_ones(current, target, result):
    assert ramped(current, target, 0.25, 1e-4) == result


@pytest.mark.parametrize("name", ["wheelBase", "frontWheelRadius", "backWheelRadius"])
def test_a_length_that_is_not_set_is_reported(name):
    with pytest.raises(ComputeError, match=f"input {name} is 0 m; give it a positive length"):
        drive(**{name: 0.0})
