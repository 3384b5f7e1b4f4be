"""The oracles at one rate, with the defaults, and their orders; `study` measures all rates with every integrator."""

import pytest

from .case import INTEGRATORS
from .free_bodies import drift, precession
from .study import CASES, main, measured

SMOOTH = [case for case in CASES if case.orders]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_physics_agrees_with_the_answer_on_paper(case):
    assert case.error(case.hz, {}) <= case.bound


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("case", SMOOTH, ids=lambda case: case.name)
def test_smooth_motion_errs_by_the_power_of_the_step_that_theory_says(case, integrator):
    result = measured(case, integrator, (60, 120, 240, 480), {})
    if integrator in case.orders:
        assert result.order == pytest.approx(case.orders[integrator], abs=0.3)
    else:  # a parabola is exact
        assert max(result.errors.values()) < 1e-12


def test_rk4_keeps_momentum_and_precession_at_240_hz():
    """The defaults need 2,400 and 960 Hz for these bounds."""
    assert drift(240, {"integrator": "rk4"}) < 5e-4
    assert precession(240, {"integrator": "rk4"}) < 5e-3


def test_the_study_prints_a_row_for_each_integrator_and_writes_the_errors(tmp_path, capsys):
    assert main(["--quick", "--only", "projectile", "--out", str(tmp_path)]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert rows[3] == "| projectile [m] | implicit | 0.082 | 0.02 | 0.0051 | 1.00 | 1 |"
    assert len(rows) == 2 + len(INTEGRATORS)
    assert '"integrator": "rk4"' in (tmp_path / "study.json").read_text()
