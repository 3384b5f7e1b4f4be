"""Fidelity knobs and warnings."""

from __future__ import annotations

import re
from dataclasses import fields
from fractions import Fraction

import pytest

from graph.base.errors import Mark, UserError
from graph.sim import App
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.physics.solver import CHOICES, SolverOptions
from graph.sim.warnings import WarningList
from tests.support.places import ROOT


def test_every_knob_of_the_table_has_a_value():
    assert set(Fidelity().as_dict()) == set(KNOBS)
    assert Fidelity()["lidar.motion"] == "frozen"


def test_a_knob_takes_what_its_field_holds():
    """Rate [Hz]: a fraction; count: a whole number; number: a float; switch: a bool; choice: one of the words."""
    kinds = {name: KNOBS[name].kind for name in ("physics.hz", "lidar.bins", "mesh.tolerance", "fabric", "tlas")}
    assert list(kinds.values()) == ["rate", "count", "number", "switch", "choice"]
    assert KNOBS["physics.cone"].choices == ("pyramidal", "elliptic")
    assert (KNOBS["lidar.bins"].default, KNOBS["physics.cone"].default) == (8, None)


@pytest.mark.parametrize("name", KNOBS)
def test_every_knob_says_its_cost_error_and_reason_and_takes_its_own_default(name):
    knob = KNOBS[name]
    assert knob.doc
    assert knob.cost
    assert knob.error
    assert knob.why
    if knob.kind in ("choice", "switch"):
        assert knob.finer in ("", *knob.values.split(", "))
    else:
        assert knob.finer in ("higher", "lower")
    if knob.default is not None:
        assert knob.checked(knob.default) == knob.default


def test_a_knob_says_its_values():
    said = {name: KNOBS[name].values for name in ("lidar.motion", "fabric", "lidar.bins", "mesh.tolerance", "loop_hz")}
    assert list(said.values()) == [
        "frozen, update, continuous",
        "on, off",
        "a whole number from 1",
        "a number above 0 [m]",
        "a number above 0 [Hz]",
    ]


def test_the_loop_rate_is_a_knob_that_beats_the_clocks():
    with App(loop_hz=60, fidelity={"loop_hz": "120"}) as app:
        app.play()
        app.update(steps=60)
        assert (app.loop_rate, app.timeline.get_current_time()) == (120, 0.5)


SOLVER = {one.name for one in fields(SolverOptions)}
"""The knobs that `graph.sim.physics.solver` reads by their names."""


@pytest.mark.parametrize("name", [name for name, knob in KNOBS.items() if knob.available is None])
def test_every_knob_is_read(name):
    if name.removeprefix("physics.") not in SOLVER:
        read = re.compile(rf"\b(?:fidelity|knobs)\.{name.replace('.', '_')}\b")
        files = (file for package in ("graph", "sensors") for file in (ROOT / package).rglob("*.py"))
        assert any(read.search(file.read_text(encoding="utf8")) for file in files)


def test_the_solvers_choices_are_the_knobs():
    assert {name: tuple(words) for name, words in CHOICES.items()} == {
        name.removeprefix("physics."): knob.choices
        for name, knob in KNOBS.items()
        if knob.choices and name.removeprefix("physics.") in SOLVER
    }


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
        ("radar.rays", 1e9, "1,000,000,000 is too many; the limit is 10,000,000 rays"),
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


def test_a_warning_is_reported_once_and_counted(caplog):
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
