"""The cases at the extremes, and `graph doctor --stability`, which runs some of them."""

import json
import re

import pytest

from graph.cli.extreme_cases import Case
from graph.cli.main import main
from tests.stability.extremes.table import CASES

FAST = [case for case in CASES if not case.slow]


@pytest.mark.parametrize("case", FAST, ids=lambda case: f"{case.area}: {case.name}")
def test_a_case_at_an_extreme_meets_its_bound(case):
    outcome = case.run()
    assert outcome.ok, f"{outcome.measured}; the bound is {case.limit}: {case.why}"


def lines_of(capsys, *options):
    code = main(["doctor", "--stability", *options])
    return code, capsys.readouterr().out.splitlines()


def test_the_command_prints_case_measured_value_and_bound_and_ends_with_0(capsys):
    code, lines = lines_of(capsys, "--only", "a fall 0 to 1e8 m")
    assert code == 0
    assert re.fullmatch(r"ok +bodies +a fall 0 to 1e8 m from the origin  \S+ m.*  \(bound 2e-06 m\)", lines[0])
    assert lines[1:] == ["1 case, all ok"]


def test_a_case_beyond_its_bound_is_shown_where_and_ends_with_1(capsys, monkeypatch):
    half = Case("tests", "halves", 0.4, "m", "they are too large", lambda value: value / 2, (0.5, 1.0))
    silent = Case("tests", "a refusal", "no", "", "nobody refuses", lambda value: "")
    broken = Case("tests", "a defect", 1.0, "", "it raises", lambda value: 1 / value, (0,))
    monkeypatch.setattr("graph.cli.extreme_cases.CASES", (half, silent, broken))
    code, lines = lines_of(capsys)
    assert code == 1
    assert lines == [
        "FAIL  tests       halves     0.5 m at 1  (bound 0.4 m)",
        'FAIL  tests       a refusal  taken without a word  (bound "no")',
        "FAIL  tests       a defect   ZeroDivisionError: division by zero at 0  (bound 1)",
        "3 of 3 cases FAIL",
    ]


def test_json_has_the_same_cells(capsys):
    _, text = lines_of(capsys, "--only", "rates of 0", "--json")
    assert json.loads("\n".join(text)) == {
        "cases": [
            {
                "area": "clocks",
                "case": "rates of 0, below, 1e10, NaN, Inf",
                "bound": '"rate"',
                "measured": "reported",
                "why": "a rate is finite and above 0",
                "ok": True,
            }
        ]
    }


def test_options_of_the_cases_without_them_are_refused(capsys):
    assert main(["doctor", "--only", "a fall"]) == 2
    assert "chooses among the cases of --stability; add it" in capsys.readouterr().err


def test_a_text_that_no_case_has_is_refused(capsys):
    assert main(["doctor", "--stability", "--only", "nowhere"]) == 2
    assert "--only nowhere: no case has this in its line" in capsys.readouterr().err
