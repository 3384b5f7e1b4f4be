"""Metrics: expressions over report and topics, and what they cannot reach."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wings.campaign.measuring import Run, metrics_of, parsed

REPORT = {"updates": 6, "sensors": {"/World/L": {"elements": 30}}, "silent": [], "metrics": {"speed": 2.5}}


@pytest.fixture
def run(tmp_path):
    """A run with a report."""
    (tmp_path / "report.json").write_text(json.dumps(REPORT))
    return Run(tmp_path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("report.updates", 6),
        ("report.sensors['/World/L'].elements / report.updates", 5.0),
        ("-report.updates ** 2 + 1", -35.0),
        ("max(1, 2, 3) - min([4, 5]) if 1 < 2 <= 2 else 0", -1.0),
        ("report.updates > 5 and not report.updates == 7", True),
        ("percentile([0, 10], 25) + mean([1, 2]) + rms([3, 4, 5, 0])", 2.5 + 1.5 + 12.5**0.5),
        ("sum(diff([1, 4, 9])) + norm([3, 4]) + count(report.silent)", 13.0),
        ("hypot(3, 4) + sqrt(16) + abs(-2) + 7 // 2 + 7 % 4", 17.0),
        ("first([5, 6]) + last([5, 6])", 11.0),
    ],
)
def test_an_expression_has_the_value_of_its_arithmetic(run, text, value):
    assert run.value(text) == pytest.approx(value)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "report.__class__",
        "().__class__",
        "(lambda: 1)()",
        "[x for x in [1]]",
        "open('/etc/passwd')",
        "max.__globals__",
        "topic('/a', whole=1)",
        "f'{report}'",
        "b'x'",
        "1j",
        "(x := 1)",
        "report.updates; 1",
        "9 ** 9 ** 9 ** 9 ** 9",
        "'a' * 1000000000",
        "report",
        "report.nothing",
        "sqrt(-1)",
        "mean([])",
        "topic('/nowhere').x",
        "1" + "+1" * 400,
        "(" * 300 + "1" + ")" * 300,
        "",
    ],
)
def test_what_is_no_metric_is_refused_in_one_line(run, text):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        run.value(text)


@given(st.text(max_size=60))
def test_any_text_is_an_expression_or_refused(text):
    try:
        found = str(parsed(text))
    except ValueError as error:
        found = str(error)
    assert "\n" not in found


def test_metrics_that_nodes_wrote_are_metrics_of_the_run(run):
    assert metrics_of(run.folder) == {"speed": 2.5}
