import math

import numpy as np
import pytest
from typed_values import of, result

from graph import ComputeError, UserError
from graph.testing import run_node


@pytest.mark.parametrize(
    ("kind", "given", "found"),
    [
        ("Sin", 30.0, 0.5),
        ("Cos", 60.0, 0.5),
        ("Tan", 45.0, 1.0),
        ("Asin", 0.5, 30.0),
        ("Acos", 0.5, 60.0),
        ("Atan", 1.0, 45.0),
    ],
)
def test_angles_are_degrees(kind, given, found):
    value, name = result(kind, "value", value=of("double", given))
    assert (value, name) == (pytest.approx(found), "double")
    values, name = result(kind, "value", value=of("float[]", [given, given]))
    assert (values, name) == (pytest.approx([found, found]), "float[]")


def test_an_arcsine_outside_its_domain_fails():
    with pytest.raises(ComputeError, match=r"input value is 1\.5; Asin is not defined there"):
        run_node("Asin", inputs={"value": of("double", 1.5)})


def test_ceil_and_floor_give_whole_numbers_of_the_same_shape():
    assert result("Ceil", a=of("double", -1.5)) == (-1, "int")
    assert result("Floor", a=of("double", -1.5)) == (-2, "int")
    assert result("Floor", a=of("float[3]", [0.5, 1.0, 1.5])) == ([0, 1, 1], "int[3]")
    assert result("Ceil", a=of("double[]", [0.5, 1.0])) == ([1, 1], "int[]")


@pytest.mark.parametrize("value", [3e9, math.inf, math.nan])
def test_what_an_int_cannot_hold_is_not_rounded(value):
    with pytest.raises(ComputeError, match="which has no whole number that an int can hold"):
        run_node("Floor", inputs={"a": of("double", value)})
    with pytest.raises(ComputeError, match="which has no whole number that an int can hold"):
        run_node("Ceil", inputs={"a": of("double[]", [value])})


def test_round_keeps_places_behind_or_before_the_point():
    assert result("Round", "output", input=of("double", 1234.5678), decimals=2) == (1234.57, "double")
    assert result("Round", "output", input=of("double", 1234.5678), decimals=-2) == (1200.0, "double")
    assert result("Round", "output", input=of("double[2]", [0.5, 1.5]))[0] == [0.0, 2.0]


def test_modulo_has_the_sign_of_the_dividend():
    for a, b, remainder in ((7, 3, 1), (-7, 3, -1), (7, -3, 1), (6, 3, 0)):
        assert result("Modulo", a=of("int", a), b=of("int", b)) == (remainder, "int")
    with pytest.raises(ComputeError, match="input b is 0; it must not"):
        result("Modulo", a=of("int", 1), b=of("int", 0))


def test_increment_adds_to_any_shape_and_keeps_the_type():
    assert result("Increment", value=of("int", 4)) == (5, "int")
    assert result("Increment", value=of("int", 4), increment=0.9) == (4, "int")
    assert result("Increment", value=of("double", 4), increment=-0.5) == (3.5, "double")
    assert result("Increment", value=of("int[2]", [1, 2])) == ([2, 3], "int[2]")
    with pytest.raises(ComputeError, match=r"the sum 256\.0 does not fit uchar; connect a double"):
        result("Increment", value=of("uchar", 255))


def test_clamp_keeps_numbers_and_components_within_bounds():
    assert result("Clamp", input=of("double", 5), lower=of("double", 0), upper=of("double", 2)) == (2, "double")
    assert result("Clamp", input=of("int", -5), lower=of("int", 0), upper=of("int", 2)) == (0, "int")
    vector = result("Clamp", input=of("double[3]", [-1, 1, 9]), lower=of("double", 0), upper=of("double[3]", [5, 5, 5]))
    assert vector == ([0, 1, 5], "double[3]")


def test_crossed_bounds_fail():
    with pytest.raises(ComputeError, match=r"input lower \(3\.0\) is above input upper \(2\.0\); swap them"):
        result("Clamp", input=of("double", 5), lower=of("double", 3), upper=of("double", 2))


def test_whole_results_that_do_not_fit_fail():
    with pytest.raises(ComputeError, match=r"the result 4294967294 does not fit int \(-2147483648 to 2147483647\)"):
        run_node("Add", inputs={"a": of("int", 2**31 - 1), "b": of("int", 2**31 - 1)})


def test_an_array_of_numbers_meets_a_tuple_element_by_element():
    value, name = result("Multiply", "product", a=of("double[]", [1, 10]), b=of("double[3]", [1, 2, 3]))
    assert (value, name) == ([[1, 2, 3], [10, 20, 30]], "double[3][]")


def test_operands_take_the_precision_of_the_result_before_they_meet():
    trace = run_node("Add", inputs={"a": of("float[2]", [1, 1]), "b": of("double", 1e-12)})
    assert np.array_equal(trace.value("sum"), [1 + 1e-12, 1 + 1e-12])


def test_matrices_are_not_rounded():
    with pytest.raises(UserError, match="there are no matrices of whole numbers"):
        run_node("Floor", inputs={"a": of("matrixd[2]", [[1, 0], [0, 1]])})
