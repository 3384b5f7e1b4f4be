"""Fidelity knobs and warnings."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import Mark, UserError
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.warnings import WarningList


def test_every_knob_of_the_table_has_a_value():
    assert set(Fidelity().as_dict()) == set(KNOBS)
    assert Fidelity()["lidar.motion"] == "frozen"


def test_knobs_are_typed_from_text_as_from_values():
    text = Fidelity.from_mapping(
        {"physics.hz": "240", "lidar.noise": "off", "mesh.tolerance": "1e-2", "physics.iterations": "3"}
    )
    typed = Fidelity.from_mapping(
        {"physics.hz": 240, "lidar.noise": False, "mesh.tolerance": 0.01, "physics.iterations": 3}
    )
    assert text == typed
    assert text.physics_hz == Fraction(240)
    assert (text.lidar_noise, text.mesh_tolerance, text.physics_iterations) == (False, 0.01, 3)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("lidar.moton", "frozen", 'did you mean "lidar.motion"'),
        ("nothing.like.it", 1, "the knobs are physics.hz"),
        ("lidar.motion", "slow", "not one of frozen, update, continuous"),
        ("lidar.noise", 2, "not one of on, off"),
        ("lidar.bins", 0, "not above 0"),
        ("fabric", "false", "not one of on, off"),
        ("radar.rays", 100, "not available yet; leave it out"),
        ("lidar.subrays", 0, "not above 0"),
        ("lidar.subrays", 1.5, "not a whole number"),
        ("physics.hz", "nan", "not a number"),
        ("mesh.tolerance", -1, "not above 0"),
        ("mesh.tolerance", [1], "not a number"),
        ("tlas", ["sensor"], "not one of sensor, frame"),
    ],
)
def test_bad_knobs(name, value, message):
    with pytest.raises(UserError, match=message):
        Fidelity.from_mapping({name: value})


def test_all_bad_knobs_are_reported_with_their_marks():
    with pytest.raises(UserError) as caught:
        Fidelity.from_mapping({"a": 1, "tlas": "x", "fabric": "on"}, lambda name: Mark("g.yaml", len(name), 1))
    assert [str(problem.mark) for problem in caught.value.problems] == ["g.yaml:1:1", "g.yaml:4:1"]


def test_a_warning_is_said_once_and_counted(caplog):
    warnings = WarningList()
    for where in ("/a", "/b", "/a"):
        warnings.add("lidar-partial-scan", where, "tick rate 20, scan rate 10")
    assert [(w.code, w.where, w.count) for w in warnings] == [
        ("lidar-partial-scan", "/a", 2),
        ("lidar-partial-scan", "/b", 1),
    ]
    assert len(caplog.records) == 2
    assert next(iter(warnings)).as_dict() == {
        "code": "lidar-partial-scan",
        "where": "/a",
        "message": "tick rate 20, scan rate 10",
        "count": 2,
    }
