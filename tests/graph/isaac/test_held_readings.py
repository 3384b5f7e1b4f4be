"""Periods and units of the sensors of physics, in scripts."""

import ast

import pytest

from graph.isaac.modules.held_readings import between
from graph.isaac.modules.sensor_readings import EffortSensorReading

SCENE = """
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.kit.commands, omni.timeline
from isaacsim.core.experimental.objects import Cube, GroundPlane
from isaacsim.core.experimental.prims import GeomPrim, RigidPrim
from isaacsim.core.experimental.utils.stage import set_stage_units
GroundPlane("/World/ground")
Cube("/World/Cube", sizes=1.0, positions=[0.0, 0.0, 0.5])
GeomPrim("/World/Cube", apply_collision_apis=True)
RigidPrim("/World/Cube", masses=[2.0])
timeline = omni.timeline.get_timeline_interface()
"""


@pytest.fixture
def printed(run_script):
    """The values that a script prints, one a line."""

    def run(text):
        code, out, err = run_script(f"{SCENE}{text}\napp.close()\n")
        assert code == 0, err
        return [ast.literal_eval(line) for line in out.splitlines()]

    return run


def test_numbers_change_linearly_between_two_readings():
    """A quarter of the way from 2 to 6; a first one that is not valid says nothing."""
    before, after = EffortSensorReading(True, 1.0, 2.0), EffortSensorReading(True, 2.0, 6.0)
    assert between(before, after, 1.25) == EffortSensorReading(True, 1.25, 3.0)
    assert between(EffortSensorReading(), after, 1.25) is after


def test_a_sensor_with_a_period_keeps_its_reading_from_one_of_its_times_to_the_next(printed):
    """At 60 steps/s and a period of 1.5 steps the IMU's times are 1.5, 3, 4.5 ...; `latest` reads the newest step.

    A function of the script gets the readings, newest first, and the time; its result is the reading.
    """
    rows = printed("""
from isaacsim.sensors.physics import _sensor
_, imu = omni.kit.commands.execute("IsaacSensorCreateImuSensor", path="/imu", parent="/World/Cube", sensor_period=0.025)
print(round(imu.GetSensorPeriodAttr().Get(), 6))
interface = _sensor.acquire_imu_sensor_interface()
def counted(readings, time):
    return (len(readings), round(60 * readings[0].time, 4), round(60 * time, 4))
timeline.play()
for _ in range(7):
    app.update()
    held, newest = (interface.get_sensor_reading("/World/Cube/imu", use_latest_data=one) for one in (False, True))
    print([round(60 * held.time, 4), round(60 * newest.time, 4)])
print(interface.get_sensor_reading("/World/Cube/imu", counted))
""")
    assert rows == [
        0.025,
        *([1, 1], [1.5, 2], [3, 3], [3, 4], [4.5, 5], [6, 6], [6, 7]),
        (20, 6, 6),
    ]


@pytest.mark.parametrize("kind", ["IMUSensor", "ContactSensor"])
def test_the_frequency_of_a_sensor_is_that_of_its_readings(printed, kind):
    """20 Hz at 60 steps/s: a new reading every third step."""
    (ticks,) = printed(f"""
from isaacsim.sensors.physics import {kind}
sensor = {kind}("/World/Cube/sensor", frequency=20)
timeline.play()
seen = set()
for _ in range(30):
    app.update()
    seen.add(round(60 * sensor.get_current_frame()["time"]))
print(sorted(seen))
""")
    assert [tick for tick in ticks if tick > 2] == list(range(3, 31, 3))


def test_readings_are_in_units_of_the_stage(printed):
    """In centimetres a cube of 2 kg at rest feels 981 cm/s2, and presses with 2 x 981 kg cm/s2."""
    (found,) = printed("""
from isaacsim.sensors.experimental.physics import Contact, ContactSensor, IMUSensor
set_stage_units(meters_per_unit=0.01)
imu = IMUSensor("/World/Cube/imu")
touch = ContactSensor(Contact("/World/Cube/touch", max_threshold=1e7))
timeline.play()
for _ in range(90):
    app.update()
print([round(imu.get_sensor_reading().linear_acceleration_z), round(touch.get_sensor_reading().value)])
""")
    assert found == [981, 1962]


def test_widths_of_averages_count_while_playing(printed):
    """A cube falls; a push adds 1.2 m/s at once, 72 m/s2 in one step of 1/60 s: 7.2 in the average of ten steps."""
    (found,) = printed("""
from isaacsim.sensors.experimental.physics import IMUSensor
cube = RigidPrim("/World/Cube")
cube.set_world_poses(positions=[0.0, 0.0, 100.0])
imu = IMUSensor("/World/Cube/imu")
timeline.play()
felt = []
for update in range(30):
    app.update()
    felt.append(imu.get_sensor_reading(read_gravity=False).linear_acceleration_z)
    if update == 10:
        imu.imu.prim.GetAttribute("linearAccelerationFilterWidth").Set(10)
    if update == 22:
        cube.set_velocities(linear_velocities=cube.get_velocities()[0].numpy() + [0, 0, 1.2])
print([round(felt[update], 2) for update in (9, 22, 23, 29)])
""")
    assert found == [-9.81, -9.81, -2.61, -2.61]
