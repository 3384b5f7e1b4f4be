"""What is asked: values of knobs, the finest of them, the grid, the refined reference."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.knob import word
from wings.trade.study import (
    finest,
    is_open,
    label,
    overrides_of,
    plan_settings,
    read_values,
    read_varied,
    references,
    refined,
    text_of,
)


def test_values_are_those_of_the_knob_and_each_is_run_once():
    varied = read_varied(["physics.hz=60,1/2,60.0", "lidar.motion=frozen,continuous", "lidar.noise=on,off"])
    assert varied == {
        "physics.hz": (Fraction(60), Fraction(1, 2)),
        "lidar.motion": ("frozen", "continuous"),
        "lidar.noise": (True, False),
    }


def test_every_mistake_is_told_in_a_line():
    with pytest.raises(UserError) as caught:
        read_varied(["physics.hzz=1", "lidar.motion=slow", "lidar.bins=0", "tlas", "lidar.bins=2"])
    assert [problem.message for problem in caught.value.problems] == [
        '--vary physics.hzz=1: there is no such knob; did you mean "physics.hz"?',
        "--vary lidar.motion=slow: 'slow' is not one of frozen, update, continuous",
        "--vary lidar.bins=0: '0' is not above 0",
        "--vary tlas: write it as KEY=V1,V2,...",
    ]


def test_a_knob_is_varied_once():
    with pytest.raises(UserError, match="varied twice"):
        read_varied(["lidar.bins=2", "lidar.bins=4"])


@pytest.mark.parametrize(
    ("name", "values", "best"),
    [
        ("physics.hz", "60,480,240", Fraction(480)),
        ("mesh.tolerance", "0.01,0.001", 0.001),
        ("lidar.motion", "frozen,update", "update"),
        ("lidar.motion", "continuous,frozen", "continuous"),
        ("tlas", "frame,sensor", "sensor"),
        ("physics.cone", "elliptic,pyramidal", "elliptic"),
        ("lidar.noise", "on,off", False),  # no value is more exact: the default
        ("physics.integrator", "euler,rk4", "euler"),  # no default either: the first of the candidates
    ],
)
def test_the_reference_is_the_finest_value(name, values, best):
    assert finest(name, read_varied([f"{name}={values}"])[name]) == best


def test_the_finest_of_one_value_is_that_value_for_every_knob():
    samples = {"choice": lambda knob: (knob.available or knob.choices)[0], "switch": lambda knob: True}
    for name, knob in KNOBS.items():
        value = samples.get(knob.kind, lambda knob: knob.checked("7"))(knob)
        assert finest(name, [value]) == value


def test_choices_without_order_and_default_are_all_candidates_for_the_reference():
    decided = ["physics.hz=60,120", "lidar.noise=on,off", "physics.cone=pyramidal,elliptic"]
    varied = read_varied(["physics.integrator=euler,rk4", *decided])
    fixed = {"physics.hz": Fraction(120), "lidar.noise": False, "physics.cone": "elliptic"}
    assert references(varied, {}) == tuple({"physics.integrator": one} | fixed for one in ("euler", "rk4"))
    assert references(varied, {"physics.integrator": "euler"}) == ({"physics.integrator": "euler"} | fixed,)
    assert {name for name in KNOBS if is_open(name)} == {"physics.integrator", "physics.jacobian"}


def test_a_choice_of_physics_without_a_finest_one_is_refined_by_the_step():
    present = Fidelity(physics_hz=Fraction(240))
    found = refined({"physics.integrator": "rk4"}, present)
    assert found == {"physics.integrator": "rk4", "physics.hz": Fraction(480)}


def test_a_grid_has_every_combination_and_one_at_a_time_only_single_changes():
    varied = {"physics.hz": (1, 2, 3), "lidar.bins": (4, 5, 6)}
    assert len(plan_settings(varied)) == 9
    assert [tuple(one.values()) for one in plan_settings(varied, {"physics.hz": 3, "lidar.bins": 6})] == [
        *((3, 6), (1, 6), (2, 6)),
        *((3, 4), (3, 5)),
    ]


def test_a_grid_that_would_never_end_is_refused():
    with pytest.raises(UserError, match="1,331 settings are too many"):
        plan_settings({name: tuple(range(11)) for name in ("a", "b", "c")})


def test_single_changes_that_would_never_end_are_refused_too():
    with pytest.raises(UserError, match="1,001 settings are too many"):
        plan_settings({"a": tuple(range(1000))}, {"a": 0})


def test_a_knob_of_the_reference_is_given_once():
    with pytest.raises(UserError, match=r"^--reference lidar.bins=4: the knob is given twice; leave one of them out$"):
        read_values(["lidar.bins=2", "lidar.bins=4"], "--reference")


def test_a_number_is_written_with_all_its_digits():
    """The block to paste is the setting that was measured."""
    assert [word(0.5), word(1e-08), word(0.0012345678)] == ["0.5", "1e-08", "0.0012345678"]


def test_a_reference_is_refined_by_a_step_of_each_knob():
    setting = {"physics.hz": Fraction(480), "mesh.tolerance": 0.001, "tlas": "sensor", "lidar.motion": "continuous"}
    assert refined(setting, Fidelity()) == {
        "physics.hz": Fraction(960),
        "mesh.tolerance": 0.0005,
        "tlas": "sensor",
        "lidar.motion": "continuous",
        "lidar.bins": 16,
    }


def test_what_cannot_be_refined_is_not():
    assert refined({"tlas": "sensor", "lidar.noise": False}, Fidelity()) is None


def test_settings_are_written_as_files_have_them():
    setting = read_values(["physics.hz=30000/1001", "lidar.noise=on", "mesh.tolerance=0.0005"], "--reference")
    assert text_of(setting) == "physics.hz=30000/1001 lidar.noise=on mesh.tolerance=0.0005"
    assert word(Fraction(60)) == "60"


RATES = "/World/Lidar.omni:sensor:tickRate+/World/Lidar.omni:sensor:Core:scanRateBaseHz"


def test_attributes_are_varied_as_text_and_joined_ones_take_the_same_value():
    varied = read_varied(
        [f"{RATES}=5,20,10", "/W/Box.translate=[0, 0, 1],[0, 0, 2]", "wait.duration=1,2"], lambda: ["wait"]
    )
    assert varied == {
        RATES: ("5", "20", "10"),
        "/W/Box.translate": ("[0, 0, 1]", "[0, 0, 2]"),
        "wait.duration": ("1", "2"),
    }
    assert overrides_of({RATES: "5", "physics.hz": 60}) == dict.fromkeys(RATES.split("+"), "5")
    assert label(RATES) == "Lidar.tickRate+scanRateBaseHz"


def test_the_reference_of_a_rate_is_the_highest_of_other_attributes_the_first():
    assert finest(RATES, ["5", "20", "10"]) == "20"
    assert finest("/World/Lidar.translate", ["[0, 0, 1]", "[0, 0, 2]"]) == "[0, 0, 1]"


def test_an_attribute_has_no_finer_value():
    assert refined({RATES: "20"}, Fidelity()) is None
    assert refined({RATES: "20", "physics.hz": Fraction(60)}, Fidelity()) == {RATES: "20", "physics.hz": Fraction(120)}


def test_what_is_neither_knob_nor_attribute_says_how_an_attribute_is_named():
    with pytest.raises(UserError, match="an attribute is"):
        read_varied(["tickRate=5,10"])
