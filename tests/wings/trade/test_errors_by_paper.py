"""Errors of runs against a reference, each with its number derived on paper: real physics and real rays."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from tests.support.places import ROOT
from wings.trade.errors import Horizon, errors_of, horizon_of
from wings.trade.study import Scene
from wings.trade.trial import UNSTABLE, clock, measure

G = 9.81

FALLING = """\
tickgraph: 1
scene:
  prims:
    /World/Ball: {type: Sphere, radius: 0.1, translate: [0, 0, 100], rigid_body: true, mass: 2.0, velocity: [3, 0, 0]}
"""

SPINNING = """\
tickgraph: 1
scene:
  prims:
    /World/Plate:
      {type: Cube, size: 1.0, scale: [2.0, 1.0, 0.1], translate: [0, 0, 50], rigid_body: true, mass: 1.0,
       angular_velocity: [5000, 20, 3000]}
"""

LIDAR = """
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Cart/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: lidar}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""

DRIVING = f"""\
tickgraph: 1
scene:
  prims:
    /World/Physics: {{type: PhysicsScene, attributes: {{"physics:gravityMagnitude": 0.0}}}}
    /World/Wall: {{type: Cube, size: 1.0, translate: [-10.5, 0, 0]}}
    /World/Cart: {{type: Xform, rigid_body: true, mass: 1.0, velocity: [-2, 0, 0]}}
    /World/Cart/Lidar: {{type: OmniLidar, config: Example_Rotary_2D}}
clock: {{physics_hz: 240, loop_hz: 60}}
graphs:{LIDAR}"""


@pytest.fixture
def measured(tmp_path):
    def run(text, seconds, **setting):
        file = tmp_path / "a.yaml"
        file.write_text(text)
        knobs = {name.replace("__", "."): value for name, value in setting.items()}
        return measure(Scene(file), knobs, Fraction(seconds))

    return run


def test_a_projectile_is_as_far_off_as_the_integrator_s_error_says(measured):
    """Semi-implicit Euler: z after n steps is -g dt^2 n (n + 1) / 2, so g t dt / 2 below the parabola; its velocity is
    exact. Between 60 and 240 Hz after 1 s that is g (1/60 - 1/240) / 2.
    """
    coarse, fine = (measured(FALLING, 1, physics__hz=Fraction(hz)) for hz in (60, 240))
    errors = errors_of(coarse, fine, Horizon(1.0))
    apart = G * (1 / 60 - 1 / 240) / 2
    assert errors["body.position_max"] == pytest.approx(apart, rel=1e-3)
    assert errors["body.position_final"] == pytest.approx(apart, rel=1e-3)
    # It grows evenly: its mean square over t = k / 60, k = 0 ... 60, is apart^2 (60 * 61 * 121 / 6) / 61 / 60^2.
    assert errors["body.position_rms"] == pytest.approx(apart * np.sqrt(60 * 121 / 6 / 60**2), rel=1e-3)
    assert errors["body.orientation_max"] == pytest.approx(0, abs=1e-9)
    # m g apart more has been lost by the lower ball; the kinetic energy is largest at the end.
    kinetic = (G**2 + 3**2) / 2
    assert errors["body.energy_drift"] == pytest.approx(G * apart / kinetic, rel=1e-3)
    assert errors["body.momentum_drift"] == pytest.approx(0, abs=1e-9)
    assert "contact.creep_max" not in errors  # nothing rests
    assert "lidar.range_p99" not in errors


def test_states_are_compared_at_common_times_where_rates_do_not_divide(measured):
    """50 against 240 Hz: at t = k / 50 the finer run is interpolated, which is exact for a parabola with its slopes but
    for the half step by which its velocities are ahead.
    """
    coarse, fine = (measured(FALLING, 1, physics__hz=Fraction(hz)) for hz in (50, 240))
    errors = errors_of(coarse, fine, Horizon(1.0))
    assert errors["body.position_final"] == pytest.approx(G * (1 / 50 - 1 / 240) / 2, rel=1e-2)


def test_errors_count_only_up_to_the_horizon(measured):
    coarse, fine = (measured(FALLING, 1, physics__hz=Fraction(hz)) for hz in (60, 240))
    errors = errors_of(coarse, fine, Horizon(0.5))
    assert errors["body.position_max"] == pytest.approx(G * 0.5 * (1 / 60 - 1 / 240) / 2, rel=1e-3)


def test_a_reference_agrees_with_its_refinement_on_smooth_motion(measured):
    coarse, fine = (measured(FALLING, 1, physics__hz=Fraction(hz)) for hz in (240, 480))
    assert horizon_of(coarse, fine) == Horizon(1.0)


def test_the_horizon_ends_where_a_spin_is_no_longer_resolved(measured):
    """100 rad/s at 60 Hz is 1.7 rad a step: first order loses it within a few steps."""
    coarse, fine = (measured(SPINNING, 1, physics__hz=Fraction(hz)) for hz in (60, 120))
    found = horizon_of(coarse, fine)
    assert found.time < 0.1
    assert found.why.startswith("beyond, /World/Plate moves otherwise")


def test_a_run_that_diverges_is_a_result(measured):
    run = measured(SPINNING, 1, physics__hz=Fraction(60), physics__integrator="euler")
    assert run.status == UNSTABLE
    assert run.ended.startswith("/World/Plate: the simulation diverged")
    assert 0 < run.ended_at < 1


def test_a_frozen_scan_of_a_moving_lidar_is_off_by_its_speed_times_the_rest_of_the_turn(measured):
    """The lidar drives at v = 2 m/s towards a wall 10 m away along -x, which beams within 2.9 degrees meet.

    A beam fired t after the start of a turn of T = 0.1 s is cast at T instead: v (T - t) short. Turns begin along +x,
    so the wall is met in their middle: v T / 2 = 0.1 m, give or take v T 3 / 360; 1 / cos of the beam is below 1.002.
    """
    frozen, moving = (measured(DRIVING, "0.5", lidar__motion=motion) for motion in ("frozen", "continuous"))
    errors = errors_of(frozen, moving, Horizon(0.5))
    assert errors["lidar.range_p50"] == pytest.approx(0.1, abs=1e-3)
    assert errors["lidar.range_max"] == pytest.approx(0.1 + 0.2 * 3 / 360, abs=1e-3)
    assert errors["frames.missing"] == 0
    assert errors["body.position_max"] == 0


def test_casting_each_update_is_off_by_at_most_an_update(measured):
    """`update` casts the firings of an update at its end: v (t_update - t), between 0 and v / 60 = 0.033 m."""
    each, moving = (measured(DRIVING, "0.5", lidar__motion=motion) for motion in ("update", "continuous"))
    errors = errors_of(each, moving, Horizon(0.5))
    assert 0.001 < errors["lidar.range_max"] <= 2 / 60 + 1e-3


def test_a_slower_loop_changes_no_return_of_whole_scans(measured):
    """Returns are matched by turn, tick and emitter, whichever update delivers them."""
    slow, fast = (measured(DRIVING, "0.5", loop_hz=Fraction(hz)) for hz in (20, 60))
    errors = errors_of(slow, fast, Horizon(0.5))
    assert errors["lidar.range_max"] == 0
    assert errors["lidar.lost"] == errors["lidar.extra"] == 0


def test_a_run_equals_itself(measured):
    run = measured(DRIVING, "0.3")
    errors = errors_of(run, run, Horizon(0.3))
    assert {name: value for name, value in errors.items() if value} == {}
    assert {"lidar.range_p99", "body.position_max", "frames.stamp_max"} <= errors.keys()


def test_a_box_at_rest_creeps_on_a_slope_and_sinks_in(measured):
    """Softness multiplies creep: 3 times as soft, about 3 times as fast (the metric is of the run, not a difference).

    The box begins 0.5 mm above the slope: its centre is 0.7505 m from the slope's, at (sin 15, cos 15) degrees.
    """
    slope = """\
tickgraph: 1
scene:
  prims:
    /World/Slope: {type: Cube, size: 1.0, scale: [20.0, 20.0, 1.0], rotate: [0, 15, 0], translate: [0, 0, -0.5]}
    /World/Box: {type: Cube, size: 0.5, rotate: [0, 15, 0], translate: [0.19424, 0, 0.22494], rigid_body: true, mass: 1}
"""
    soft, firm = (measured(slope, 2, physics__contact_softness=value) for value in (3.0, 1.0))
    same, other = errors_of(firm, firm, Horizon(2.0)), errors_of(soft, firm, Horizon(2.0))
    assert same["body.position_max"] == 0
    assert 0 < same["contact.creep_max"] < 0.05
    assert other["contact.creep_max"] > 2 * same["contact.creep_max"]
    assert 1e-5 < same["contact.penetration_max"] < 5e-3


def test_what_rests_has_no_drift(measured):
    """10 um of sinking under 9.81 N are 1e-4 J, and no share of a kinetic energy that is nearly 0."""
    rest = """\
tickgraph: 1
scene: {prims: {/Ground: {type: Plane}, /Box: {type: Cube, size: 0.5, translate: [0, 0, 0.25], rigid_body: true}}}
"""
    coarse, fine = (measured(rest, 1, physics__hz=Fraction(hz)) for hz in (120, 480))
    errors = errors_of(coarse, fine, Horizon(1.0))
    assert 0 < errors["body.position_max"] < 1e-3
    assert not {"body.energy_drift", "body.momentum_drift", "body.spin_drift"} & set(errors)


def test_a_timed_run_charges_every_part_once(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_text(DRIVING)
    recording = tmp_path / "run.mcap"
    timed = clock(Scene(file), {}, Fraction(1, 2), 0.1, recording)
    assert timed.ended == ""
    assert all(timed.parts[part].wall > 0 for part in ("physics", "casts", "post", "graph", "io", "rest"))
    assert timed.whole.wall == pytest.approx(sum(cost.wall for cost in timed.parts.values()))
    assert timed.start > 0
    assert not recording.exists()
    from sensors.raycast.world import CastWorld

    assert not hasattr(CastWorld.cast, "__wrapped__")  # nothing stays installed


FILMED = """\
tickgraph: 1
scene:
  prims:
    /World/Box: {type: Cube, size: 2.0, translate: [0, 0, -11], rigid_body: true, mass: 1.0}
    /World/Camera: {type: Camera, schemas: [OmniSensorAPI], attributes: {"omni:sensor:tickRate": 10}}
clock: {physics_hz: 240, loop_hz: 60}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 64, height: 48}}
      depth: {type: ROS2CameraHelper, inputs: {type: depth, topicName: depth, frameId: camera}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> depth.execIn
      - product.renderProductPath -> depth.renderProductPath
"""


def test_the_depth_of_a_falling_box_is_off_as_the_box_is(measured):
    """A camera looks down -z at a box that falls: the depth of its top is off by g t dt / 2, at most at t = 1 s."""
    coarse, fine = (measured(FILMED, 1, physics__hz=Fraction(hz)) for hz in (60, 240))
    errors = errors_of(coarse, fine, Horizon(1.0))
    assert errors["camera.depth_max"] == pytest.approx(G * (1 / 60 - 1 / 240) / 2, rel=1e-3)
    assert 0 <= errors["camera.changed"] < 0.1  # its edge moves over few pixels
    assert errors["frames.missing"] == errors["frames.stamp_max"] == 0
    assert "camera.colour_rms" not in errors  # nothing reads colours


def test_a_radar_finds_in_itself_what_it_found():
    run = measure(Scene(ROOT / "graphs/radar.yaml"), {}, Fraction(1, 2))
    errors = errors_of(run, run, Horizon(0.5))
    assert (errors["radar.recall"], errors["radar.false_alarms"], errors["radar.velocity_p99"]) == (1, 0, 0)
    assert sum(len(frame.arrays["distance"]) for one in run.sensors.values() for frame in one.frames) > 5
