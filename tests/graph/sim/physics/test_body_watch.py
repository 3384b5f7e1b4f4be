"""Warnings of a run about bodies: robots that tip over, bodies that move by more than their size in a step."""

import pytest

from graph.sim import App
from tests.support.places import ROOT


def codes(prims, updates=60, hz=240):
    """(code, where, message) of the warnings of an App with these prims that played so many updates."""
    with App(physics_hz=hz, loop_hz=60) as app:
        app.add_prims({"/Ground": {"type": "Plane"}, **prims})
        app.play()
        app.update(updates)
        return [(one.code, one.where, one.message) for one in app.warnings]


def robot(spin, drive=True):
    """A post of 1 m that stands on the ground and turns about y at first [deg/s], with a weight on a driven joint."""
    schemas = ["PhysicsDriveAPI:angular"] if drive else []
    gains = {"drive:angular:physics:damping": 1.0} if drive else {}
    return {
        "/Robot": {"schemas": "PhysicsArticulationRootAPI"},
        "/Robot/Base": {"rigid_body": True, "mass": 4.0, "angular_velocity": [0, spin, 0], "translate": [0, 0, 0.5]},
        "/Robot/Base/Post": {"type": "Cube", "size": 1.0, "scale": [0.2, 0.2, 1.0]},
        "/Robot/Arm": {"type": "Sphere", "radius": 0.05, "rigid_body": True, "mass": 0.1, "translate": [0, 0, 1.1]},
        "/Robot/turn": {
            "type": "PhysicsRevoluteJoint",
            "schemas": schemas,
            "attributes": {
                "physics:axis": "Z",
                "physics:body0": "/Robot/Base",
                "physics:body1": "/Robot/Arm",
                "physics:localPos0": [0, 0, 0.6],
                **gains,
            },
        },
    }


def test_a_robot_that_falls_over_is_named_once():
    ((code, where, message),) = codes(robot(spin=400))
    assert (code, where) == ("body-tipped", "/Robot/Base")
    assert "more than 45 degrees" in message
    assert "casters" in message


@pytest.mark.parametrize(
    "prims", [robot(spin=0), robot(spin=20), robot(spin=400, drive=False)], ids=["stands", "rocks", "is no robot"]
)
def test_what_stays_up_or_is_driven_by_nothing_is_not(prims):
    assert codes(prims) == []


def test_the_robot_that_ships_does_not_tip():
    with App.from_file(ROOT / "graph/cli/templates/diffdrive.yaml") as app:
        app.play()
        app.update(60)
        assert [one.code for one in app.warnings] == []


def ball(speed):
    return {
        "/Ball": {
            "type": "Sphere", "radius": 0.05, "translate": [0, 0, 5], "rigid_body": True, "velocity": [speed, 0, 0]
        }
    }  # fmt: skip


def test_a_body_that_moves_by_more_than_its_size_in_a_step_is_named_with_the_rate_that_it_needs():
    """30 m/s at 240 Hz are 0.125 m a step; the ball of 0.1 m needs a little more than 300 Hz."""
    ((code, where, message),) = codes(ball(30.0), updates=10)
    assert (code, where) == ("body-too-fast", "/Ball")
    assert "by 0.125 m in a physics step" in message
    assert "its size is 0.1 m" in message
    assert "raise physics_hz to 301" in message  # gravity adds a little
    assert codes(ball(23.0), updates=10) == []  # 0.096 m
    assert codes(ball(30.0), updates=10, hz=480) == []
