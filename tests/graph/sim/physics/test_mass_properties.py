import numpy as np
import pytest

from graph.base.errors import UserError
from tests.support.physics_worlds import GROUND, steps

BODY = """
def Xform "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = {mass}
    {lines}
}}
"""


def body(*lines, mass=1):
    return BODY.format(mass=mass, lines="\n    ".join(lines))


def moments(physics):
    return sorted(physics.model.body_inertia[1])


@pytest.mark.parametrize("written", [(0.1, 0.2, 0.3), (0.3, 0.1, 0.2), (0.7, 0.1, 0.8)])
def test_the_inertia_of_a_flat_body_is_not_rounded_to_a_ball(usda, written):
    """In float32 0.1 + 0.2 < 0.3 by 1.5e-8: less than the rounding of a third number to float32, 3e-8 of it."""
    physics, warnings = usda(body(f"float3 physics:diagonalInertia = {written}"))
    assert moments(physics) == pytest.approx(sorted(written), rel=1e-7)
    assert warnings == []


def test_an_inertia_that_no_body_has_is_reported(usda):
    """0.1 + 0.2 < 0.31: the mean of the three is (0.1 + 0.2 + 0.31) / 3."""
    physics, warnings = usda(body("float3 physics:diagonalInertia = (0.1, 0.2, 0.31)"))
    assert moments(physics) == pytest.approx([0.61 / 3] * 3, rel=1e-6)
    assert [code for code, *_ in warnings] == ["impossible-inertia"]


@pytest.mark.parametrize(
    ("line", "name", "message"),
    [
        ("float3 physics:diagonalInertia = (nan, 1, 1)", "diagonalInertia", "is (nan, 1, 1), not finite"),
        ("float3 physics:diagonalInertia = (1, -1, 1)", "diagonalInertia", "is (1, -1, 1), not all above 0"),
        ("float3 physics:diagonalInertia = (1, 0, 1)", "diagonalInertia", "is (1, 0, 1), not all above 0"),
        ("point3f physics:centerOfMass = (inf, 0, 0)", "centerOfMass", "is (inf, 0, 0), not finite"),
        ("quatf physics:principalAxes = (nan, 0, 0, 0)", "principalAxes", "is not finite"),
        ("float physics:density = nan", "density", "is nan, not a number from 0"),
    ],
)
def test_a_mass_property_that_is_not_a_number_is_reported_and_counts_as_not_written(usda, line, name, message):
    physics, warnings = usda(body(line))
    told = [(where, text) for code, where, text in warnings if code == "bad-mass"]
    name = f"physics:{name}"
    assert told == [(f"/A.{name}", f"{name} {message}; it counts as not written")]
    assert np.isfinite(physics.model.body_inertia[1]).all()


@pytest.mark.parametrize(
    "line",
    [
        "float3 physics:diagonalInertia = (0, 0, 0)",
        "point3f physics:centerOfMass = (-inf, -inf, -inf)",
        "quatf physics:principalAxes = (0, 0, 0, 0)",
    ],
)
def test_the_words_of_the_schema_for_nothing_are_silent(usda, line):
    _, warnings = usda(body(line))
    assert {code for code, *_ in warnings} <= {"body-without-volume"}


def test_a_body_too_heavy_for_the_engine_is_refused_and_the_heaviest_rests(world):
    box = {"type": "Cube", "size": 1.0, "translate": [0, 0, 0.5], "rigid_body": True}
    physics, _, _ = world({**GROUND, "/Box": {**box, "mass": 1e13}})
    steps(physics, 240)
    assert physics.positions[0, 2] == pytest.approx(0.5, abs=1e-4)
    with pytest.raises(UserError, match=r"/Box: a mass of 1e\+30 kg is too much for the engine"):
        world({**GROUND, "/Box": {**box, "mass": 1e30}})


@pytest.mark.parametrize("mass", [1e-300, 1e300])
def test_a_mass_that_float32_does_not_hold_is_refused(world, mass):
    with pytest.raises(UserError, match="is not from 1e-30 to 1e30"):
        world({"/Box": {"type": "Cube", "rigid_body": True, "mass": mass}})
