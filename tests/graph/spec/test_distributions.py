"""Seeded distributions: what they draw, and what their texts must be."""

from __future__ import annotations

from hashlib import sha256
from statistics import NormalDist, fmean, pstdev

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.spec.distributions import Stream, parse


def draws(text, count, seed=0):
    distribution = parse(text)
    return [distribution.draw(Stream(seed, f"x{number}")) for number in range(count)]


def test_a_number_is_the_hash_of_seed_purpose_and_place_alone():
    first = int.from_bytes(sha256(b"17\0wheel\0000").digest()[:8], "big") >> 11
    second = int.from_bytes(sha256(b"17\0wheel\0001").digest()[:8], "big") >> 11
    stream = Stream(17, "wheel")
    assert [stream.unit(), stream.unit()] == [first / 2**53, second / 2**53]


def test_uniform_is_low_plus_the_share_of_the_span():
    unit = Stream(3, "x").unit()
    assert parse("uniform(2, 6)").draw(Stream(3, "x")) == float(f"{2 + 4 * unit:.9g}")


def test_uniform_has_the_mean_and_the_deviation_of_its_span():
    values = draws("uniform(0, 1)", 4000)
    assert min(values) >= 0
    assert max(values) <= 1
    assert fmean(values) == pytest.approx(0.5, abs=4 / (12 * 4000) ** 0.5)
    assert pstdev(values) == pytest.approx(1 / 12**0.5, rel=0.03)


def test_normal_is_the_inverse_of_its_distribution_function():
    unit = Stream(5, "x").unit()
    expected = 10 + 2 * NormalDist().inv_cdf(unit + 2.0**-54)
    assert parse("normal(10, 2)").draw(Stream(5, "x")) == float(f"{expected:.9g}")


def test_bounds_of_a_normal_are_kept_and_a_deviation_of_0_gives_the_mean():
    assert all(-1 <= value <= 2 for value in draws("normal(0, 5, -1, 2)", 500))
    assert draws("normal(3, 0)", 2) == [3.0, 3.0]
    assert draws("normal(3, 0, 4, 5)", 1) == [4.0]


def test_a_logarithm_is_uniform():
    below = sum(value < 10 for value in draws("loguniform(1, 100)", 2000))
    assert below == pytest.approx(1000, abs=4 * 500**0.5)


def test_integers_reach_both_ends_and_nothing_else():
    assert set(draws("integers(2, 4)", 200)) == {2, 3, 4}


def test_choices_are_numbers_texts_and_lists():
    assert {str(one) for one in draws("choice(1, 2.5, steel, [0, 1], 'a, b', true)", 300)} == {
        "1",
        "2.5",
        "steel",
        "[0, 1]",
        "a, b",
        "True",
    }


def test_a_list_draws_each_of_its_numbers_and_a_number_stands_for_all():
    value = parse("uniform([0, 10, 5], [1, 20, 5])").draw(Stream(1, "x"))
    assert 0 <= value[0] <= 1
    assert 10 <= value[1] <= 20
    assert value[2] == 5
    assert len({*parse("normal([0, 0, 0], 1)").draw(Stream(1, "x"))}) == 3


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("unifrom(0, 1)", 'there is no distribution "unifrom"; did you mean "uniform"?'),
        ("uniform(0)", "uniform has 1 arguments; write uniform(LOW, HIGH)"),
        ("uniform(2, 1)", "the first number is above the second; exchange them: uniform(LOW, HIGH)"),
        ("uniform([0, 1], [1, 2, 3])", "its lists have different lengths, 2, 3"),
        ("uniform(a, 1)", "a is not a number; write uniform(LOW, HIGH)"),
        ("uniform(nan, 1)", "nan is not a number; write uniform(LOW, HIGH)"),
        ("uniform(0, 1", "uniform(0, 1 is not a distribution"),
        ("loguniform(0, 1)", "its numbers must be above 0: loguniform(LOW, HIGH)"),
        ("normal(0, -1)", "the standard deviation is below 0"),
        ("normal(0, 1, 2)", "give both bounds, or none"),
        ("integers(0.5, 2)", "its numbers must be whole"),
        ("choice()", "choice has 0 arguments"),
        ("choice(1,,2)", "a value is missing between two commas"),
        ("choice([1, 2)", "its brackets or quotes are not closed"),
        (5, "5 is not a distribution"),
    ],
)
def test_a_wrong_text_is_refused_with_what_to_write(text, why):
    with pytest.raises(ValueError, match=r".") as caught:
        parse(text)
    assert why in str(caught.value)


@given(st.text(alphabet="uniformnalchoce(),[]'\"0123456789.- ", max_size=40))
def test_any_text_draws_or_is_refused(text):
    try:
        found = parse(text)
    except ValueError:
        return
    assert found.draw(Stream(0, "x")) is not None
