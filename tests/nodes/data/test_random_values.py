"""Random values: within their bounds, distributed as they say, and the same again with the same seed."""

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of


def drawn(kind, count=400, **inputs):
    trace = run_node(kind, inputs=inputs, pulses={"execIn": range(count)}, updates=count)
    assert trace.fired("execOut") == list(range(count))
    return trace.values("random"), trace.node.types["outputs:random"].name


def test_a_coin_falls_on_both_sides():
    values, _ = drawn("RandomBoolean")
    # 400 tosses: 200 +- 6 standard deviations of 10.
    assert 140 < sum(values) < 260


def test_whole_numbers_reach_both_ends_and_real_ones_stay_within():
    values, name = drawn("RandomNumeric", min=of("int", -1), max=of("int", 1))
    assert set(values) == {-1, 0, 1}
    assert name == "int"
    values, name = drawn("RandomNumeric", min=of("float[2]", [0, 10]), max=of("float", 20))
    assert name == "float[2]"
    values = np.array(values)
    assert (values >= [0, 10]).all()
    assert (values < 20).all()
    assert np.allclose(values.mean(axis=0), [10, 15], atol=2)


def test_an_array_is_drawn_element_by_element():
    values, name = drawn("RandomNumeric", count=1, min=of("double[]", [0, 100]), max=of("double[]", [1, 101]))
    assert name == "double[]"
    assert 0 <= values[0][0] < 1
    assert 100 <= values[0][1] < 101


def test_a_range_the_wrong_way_round_fails():
    with pytest.raises(ComputeError, match="is above input max"):
        drawn("RandomNumeric", count=1, min=of("int", 2), max=of("int", 1))


def test_a_normal_distribution_has_its_mean_and_deviation():
    values, name = drawn("RandomGaussian", mean=of("double", 5), stdev=of("double", 2))
    # Of 400 draws: the mean is off by 2 / 20, the deviation by 2 / sqrt(800), each times four.
    assert name == "double"
    assert abs(np.mean(values) - 5) < 0.4
    assert abs(np.std(values) - 2) < 0.3
    logs, _ = drawn("RandomGaussian", mean=of("double", 0), stdev=of("double", 1), useLog=True)
    assert min(logs) > 0
    assert abs(np.log(logs).mean()) < 0.2
    with pytest.raises(ComputeError, match="give it 0 or more"):
        drawn("RandomGaussian", count=1, mean=of("double", 0), stdev=of("double", -1))


@pytest.mark.parametrize(("kind", "name"), [("RandomUnitVector", "vectorf[3]"), ("RandomUnitQuaternion", "quatf[4]")])
def test_directions_have_length_one_and_point_everywhere(kind, name):
    values, found = drawn(kind)
    values = np.array(values)
    assert found == name
    assert np.allclose(np.linalg.norm(values, axis=1), 1, atol=1e-6)
    assert (np.abs(values.mean(axis=0)) < 0.15).all()


def test_a_seed_repeats_and_another_gives_other_numbers():
    inputs = {"min": of("double", 0), "max": of("double", 1), "useSeed": True}
    first, second = (drawn("RandomNumeric", 3, **inputs, seed=7)[0] for _ in range(2))
    assert first == second
    assert len(set(first)) == 3
    assert drawn("RandomNumeric", 3, **inputs, seed=8)[0] != first


def test_noise_is_one_value_for_a_seed():
    inputs = {"min": of("double", 0), "max": of("double", 1), "isNoise": True}
    values, _ = drawn("RandomNumeric", 4, **inputs, seed=lambda update: update // 2)
    assert values[0] == values[1] != values[2] == values[3]


def test_a_deviation_of_minus_zero_is_none():
    values, _ = drawn("RandomGaussian", count=2, mean=of("double", 3), stdev=of("double", -0.0))
    assert values == [3, 3]


def test_a_whole_bound_and_a_real_one_give_real_numbers():
    values, name = drawn("RandomNumeric", count=20, min=of("int", 0), max=of("float[2]", [1, 2]))
    assert name == "float[2]"
    assert (np.array(values) > 0).all()
    assert (np.array(values) < [1, 2]).all()
