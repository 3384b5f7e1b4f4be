import math

import numpy as np
import pytest

from graph.testing.expectations import difference, show
from graph.testing.updates import read_range, show_updates
from graph.values.types import TYPES

EQUAL = [
    (1, 1, None),
    (0.5, 0.5 + 1e-10, None),
    (1e9, 1e9 + 0.5, None),  # relative above 1
    (math.nan, math.nan, None),
    (math.inf, math.inf, None),
    (1, 1.0, None),
    ([1, 2], np.array([1.0, 2.0]), None),
    ([], np.zeros(0), None),
    ([1, 2, 3], np.array([1.0, 2.0, 3.0]), TYPES["double[3]"]),
    (0.1, np.float32(0.1), TYPES["float"]),
    ({"a": [1, 2]}, {"a": (1, 2)}, None),
    (["a"], ["a"], TYPES["token[]"]),
]


@pytest.mark.parametrize(("wanted", "got", "type_"), EQUAL, ids=str)
def test_equal_values(wanted, got, type_):
    assert difference(wanted, got, type_, 1e-7 if type_ is TYPES["float"] else 1e-9) is None


DIFFERENT = [
    (1, 2, "expected 1, got 2"),
    (0.5, 0.6, "expected 0.5, got 0.6 (error 0.1, tolerance 1e-09)"),
    (1000.0, 1001.0, "(error 0.001, "),
    (1, True, "expected 1, got true"),
    ("a", "b", 'expected "a", got "b"'),
    ("1", 1, 'expected "1", got 1'),
    (math.nan, 0.0, "expected .nan, got 0.0"),
    (math.inf, -math.inf, "expected .inf, got -.inf"),
    ([1, 2], np.array([1, 2, 3]), "expected [1, 2], got [1, 2, 3]"),
    ([1.0, math.nan], np.array([1.0, 2.0]), "expected [1.0, .nan], got [1.0, 2.0]"),
    ([math.nan, 1.0], np.array([math.nan, 2.0]), "error 1,"),
    ({"a": 1}, {"b": 1}, "expected {a: 1}, got {b: 1}"),
    ([1], 1, "expected [1], got 1"),
    (None, 0, "expected nothing, got 0"),
    (10**20, 10**20 + 1, f"got {10**20 + 1}"),
]


@pytest.mark.parametrize(("wanted", "got", "message"), DIFFERENT, ids=str)
def test_different_values(wanted, got, message):
    assert message in difference(wanted, got, None, 1e-9)


def test_what_an_attribute_cannot_hold_is_reported():
    message = difference("fast", 1.5, TYPES["double"], 1e-9)
    assert message.startswith('expected "fast", which cannot be: ')
    assert message.endswith("; got 1.5")


def test_a_tolerance_of_zero_is_exact():
    assert difference(0.1 + 0.2, 0.3, None, 0.0) is not None
    assert difference(0.3, 0.3, None, 0.0) is None


def test_long_values_are_shortened():
    assert len(show("x" * 1000)) < 130
    assert show(np.zeros(100)).endswith("... 100 in all]")


@pytest.mark.parametrize(
    ("item", "updates"),
    [(3, [3]), ("3", [3]), ("2..4", [2, 3, 4]), ("5..5", [5]), ("4..2", None), (-1, None), (True, None), ("a", None),
     (1.0, None), ("100", None), ("0..100", None)],
)  # fmt: skip
def test_ranges(item, updates):
    found = read_range(item, 100)
    assert (found if found is None else list(found)) == updates


def test_updates_are_shown_as_they_are_written():
    assert show_updates([0, 1, 2, 3, 7, 9, 10, 10]) == "[0..3, 7, 9, 10, 10]"
    assert show_updates([]) == "[]"
    assert show_updates(range(0, 400, 2), 10) == "[0, 2, 4, 6, 8, 10, ..., 394, 396, 398]"
