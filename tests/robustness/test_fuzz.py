"""A few spoiled files of every kind in each test run; `--fuzz N`, or fuzz.py itself, does more."""

import pytest

from tests.robustness.fuzz import fuzz
from tests.robustness.mutations import spoiled
from tests.support.without_wing import needs_wing


def test_spoiled_files_of_every_kind_end_in_a_line(request):
    count = request.config.getoption("--fuzz")
    found = fuzz(seed=request.config.getoption("--fuzz-seed"), first=0, count=count)
    assert found.failures == []
    assert found.done == count


@needs_wing("view")
def test_spoiled_recordings_end_in_a_line_and_nothing_is_written_elsewhere(request):
    count = min(request.config.getoption("--fuzz"), 1000)
    found = fuzz(seed=request.config.getoption("--fuzz-seed"), first=0, count=count, of_runs=True)
    assert found.failures == []
    assert found.done == count


@pytest.mark.parametrize(
    ("seed", "case"),
    [(4, 1717), (4, 2331), (4, 5893), (4, 7727), (5, 4533), (42, 1357), (42, 2777), (44, 1913), (53, 796)],
)
def test_cases_that_once_got_through_no_longer_do(seed, case):
    """Prims without specs, values beyond the end of a binary layer, no known type, paths that are not a tree."""
    assert fuzz(seed=seed, first=case, count=1).failures == []


def test_a_case_is_made_by_its_seed_and_number_alone():
    from random import Random

    right = b'{"a": [1, 2, {"b": "c"}], "d": null}'
    for kind in (".json", ".usda", ".mcap"):
        once, again, other = (spoiled(right, kind, Random(seed)) for seed in ("1:7", "1:7", "1:8"))
        assert once == again
        assert once != other or once != right
