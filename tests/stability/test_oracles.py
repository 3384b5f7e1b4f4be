"""The oracles at one rate, with the defaults; `study` measures them at ten rates with every integrator."""

import pytest

from . import contacts, free_bodies, joints

CASES = (*free_bodies.CASES, *joints.CASES, *contacts.CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_physics_agrees_with_the_answer_on_paper(case):
    assert case.error(case.hz, {}) <= case.bound
