"""Efforts of control laws, motors and delays, each worked out by hand."""

import math

import numpy as np
import pytest

from wings.actuators.laws import (
    ClampingDCMotor,
    ClampingMaxEffort,
    ClampingPositionBased,
    ControllerPD,
    ControllerPID,
    Delay,
    Joint,
)
from wings.actuators.robot import Actuator


def joint(position=0.0, velocity=0.0, target=0.0, target_velocity=0.0, feedforward=0.0):
    return Joint(
        *(np.atleast_1d(np.asarray(one, float)) for one in (position, velocity, target, target_velocity, feedforward))
    )


def test_pd_adds_both_errors_feedforward_and_the_constant():
    law = ControllerPD(kp=100.0, kd=10.0, const_effort=1.0)
    seen = joint(position=0.05, velocity=0.5, target=0.1, target_velocity=1.0, feedforward=2.0)
    assert law.efforts(seen, None, 0.01) == pytest.approx([1 + 2 + 100 * 0.05 + 10 * 0.5])


def test_gains_may_differ_between_robots():
    law = ControllerPD(kp=np.array([1.0, 10.0]), kd=0.0)
    assert law.efforts(joint(position=[0, 0], target=[2, 2]), None, 0.01) == pytest.approx([2, 20])


def test_pid_integrates_the_error_up_to_its_limit():
    law = ControllerPID(kp=0.0, ki=50.0, kd=0.0, integral_max=0.0025)
    memory = law.memory(1)
    found = [float(law.efforts(joint(target=0.1), memory, 0.01)[0]) for _ in range(4)]
    assert found == pytest.approx([0.05, 0.1, 0.125, 0.125])  # 50 x 0.001, 0.002, then 0.0025


def test_a_reset_forgets_the_integral():
    actuator = Actuator(ControllerPID(kp=0.0, ki=1.0, kd=0.0))
    actuator.reset(1)
    assert actuator.step(joint(target=1.0), 0.5) == pytest.approx([0.5])
    assert actuator.step(joint(target=1.0), 0.5) == pytest.approx([1.0])
    actuator.reset(1)
    assert actuator.step(joint(target=1.0), 0.5) == pytest.approx([0.5])


@pytest.mark.parametrize(
    ("velocity", "lowest", "highest"),
    [(0, -100, 100), (5, -100, 60), (-5, -60, 100), (10, -100, 0), (15, -100, -60), (30, -240, -240)],
)
def test_a_dc_motor_gives_less_the_faster_it_turns(velocity, lowest, highest):
    motor = ClampingDCMotor(saturation_effort=120.0, velocity_limit=10.0, max_motor_effort=100.0)
    seen = joint(velocity=velocity)  # 120 (1 - v / 10) above, 120 (-1 - v / 10) below, within 100
    assert motor.limited(np.array([1e3]), seen) == pytest.approx([highest])
    assert motor.limited(np.array([-1e3]), seen) == pytest.approx([lowest])


def test_a_dc_motor_without_a_limit_of_speed_keeps_its_stall_effort():
    motor = ClampingDCMotor(saturation_effort=120.0, velocity_limit=math.inf)
    assert motor.limited(np.array([500.0]), joint(velocity=40.0)) == pytest.approx([120])


@pytest.mark.parametrize(("position", "most"), [(-1, 50), (0.25, 45), (0.75, 30), (3, 20)])
def test_a_table_of_positions_is_interpolated_and_ends_at_its_ends(position, most):
    table = ClampingPositionBased(lookup_positions=[0.0, 0.5, 1.0], lookup_efforts=[50.0, 40.0, 20.0])
    assert table.limited(np.array([-99.0]), joint(position=position)) == pytest.approx([-most])


def test_a_table_may_be_a_file(tmp_path):
    file = tmp_path / "table.txt"
    file.write_text("# position, effort\n0, 50\n\n1 30\n")
    assert ClampingPositionBased(str(file)).limited(np.array([99.0]), joint(position=0.5)) == pytest.approx([40])


def test_limits_act_one_after_the_other():
    actuator = Actuator(ControllerPD(kp=100.0, kd=0.0), [ClampingMaxEffort(30.0), ClampingMaxEffort(20.0)])
    actuator.reset(1)
    assert actuator.step(joint(target=1.0), 0.01) == pytest.approx([20])


def test_commands_arrive_steps_later_and_the_oldest_meanwhile():
    actuator = Actuator(ControllerPD(kp=1.0, kd=0.0), delay=Delay(np.array([0, 2])))
    actuator.reset(2)
    seen = [actuator.step(joint([0, 0], [0, 0], [n, n], [0, 0], [0, 0]), 0.01).tolist() for n in (1, 2, 3, 4, 5)]
    assert seen == [[1, 1], [2, 1], [3, 1], [4, 2], [5, 3]]


def test_a_delay_of_0_steps_delays_nothing():
    delay = Delay(0, 0)
    memory = delay.memory(1)
    assert [float(delay.delayed(joint(target=n), memory).target_position[0]) for n in (1, 2)] == [1, 2]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ControllerPD(kp=-1.0, kd=0.0), "kp must be 0 or more"),
        (lambda: ClampingDCMotor(120.0, 0.0), "velocity_limit must be above 0"),
        (lambda: ClampingDCMotor(math.inf, 1.0), "saturation_effort must be above 0 and finite"),
        (lambda: ClampingPositionBased(lookup_positions=[0.0, 1.0], lookup_efforts=[1.0]), "2 lookup_positions and 1"),
        (lambda: ClampingPositionBased(lookup_positions=[1.0, 0.0], lookup_efforts=[1.0, 1.0]), "must not fall"),
        (lambda: Delay(-1), "delay_steps must be 0 or more"),
    ],
)
def test_wrong_parameters_are_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()
