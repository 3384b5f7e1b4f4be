"""Fidelity knobs and output frames of a radar."""

import numpy as np
import pytest

from graph.cli.idle_parts import warn_of_blind_sensors
from sensors.radar.bins import angle_cell
from sensors.radar.config import ScanConfig
from sensors.radar.cube import Grid
from tests.support.radar_scenes import WPM, dbsm, plate, radar_world, received, trihedral


def test_one_reflection_sees_no_corner():
    """14.4 dBsm are three reflections; its faces lie 35 deg off and return nothing near that."""
    sections, _, bounces = received(trihedral(0.1, 20.0), fidelity={"radar.bounces": 1})
    assert not len(sections) or dbsm(sections[0]) < -20
    assert set(bounces.tolist()) <= {1}


@pytest.mark.parametrize("rays", [5_000, 50_000])
def test_the_fan_has_about_as_many_rays_as_are_asked_for(rays):
    """A wall of 8 m fills 23 x 20 deg of the 40 x 20 deg: the Fresnel zones of its mirror point need some rays."""
    with radar_world(plate(8.0, 20.0), fidelity={"radar.rays": rays}) as (app, product):
        app.update()
        across, up = product.sensor.config.scans[0].grid(rays)
        assert across * up == pytest.approx(rays, rel=0.02)
        assert product.frame.channel("distance")[0] == pytest.approx(20.0, abs=0.05)


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ({}, [20.0, 0.0, 0.0]),
        ({f"{WPM}outputFrameOfReference": "WORLD"}, [20.0, 0.0, 5.0]),
        (
            {
                f"{WPM}outputFrameOfReference": "CUSTOM",
                f"{WPM}customFrameOfReferenceTrafo": [1.0, 0.0, 0.0, 0.0, 0.0, 90.0],
            },
            [1.0, 20.0, 0.0],
        ),
    ],
    ids=["sensor", "world", "custom"],
)
def test_points_are_given_in_the_frame_that_is_asked_for(attributes, expected):
    """The radar is 5 m up; in the custom frame it stands at (1, 0, 0), turned by 90 deg to the left."""
    target = {name: {**keys, "translate": [20.00005, 0, 5]} for name, keys in plate(0.2, 20.0).items()}
    with radar_world(target, attributes, translate=[0, 0, 5]) as (app, product):
        app.update()
        frame = product.frame
        assert frame.xyz[0] == pytest.approx(expected, abs=2e-3)
        assert frame.channel("distance")[0] == pytest.approx(np.linalg.norm(expected), abs=2e-3)


def test_angles_beyond_the_field_of_view_fold_only_where_they_are_to():
    """At +-30 deg sines beyond 0.5 come in again at -0.5, 86 cells of sin 1.3 deg or so later."""
    once = Grid.of(ScanConfig(max_az_ang_deg=30.0), 0)
    assert angle_cell(once.bins, 0.6, 0.0)[0] == -1
    grid = Grid.of(ScanConfig(max_az_ang_deg=30.0, en_ang_aliasing=True), 0)
    cell, azimuth, _ = angle_cell(grid.bins, 0.6, 0.0)
    assert cell == grid.angles(np.array([azimuth]), np.array([0.0]))[0] >= 0
    assert azimuth == pytest.approx(0.6 - (grid.azimuth.high - grid.azimuth.low))


@pytest.mark.parametrize(("rays", "said"), [(20, "has 0.15 rays per degree by radar.rays=20"), (None, "not excluded?")])
def test_a_radar_that_sees_nothing_names_the_knob_that_leaves_it_few_rays(rays, said):
    """20 rays over 40 x 20 deg are 6 x 3, one in 6.7 deg; the view holds nothing."""
    with radar_world({}, fidelity={"radar.rays": rays} if rays else {}) as (app, _):
        app.update()
        warn_of_blind_sensors(app)
        [line] = [str(warning) for warning in app.warnings if warning.code == "sensor-saw-nothing"]
    assert said in line
    assert ("raysPerDeg asks for 8" in line) == bool(rays)
