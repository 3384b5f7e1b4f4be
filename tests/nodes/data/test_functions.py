import math
import re

import numpy as np
import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from tests.support.typed_values import of, result


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
    with pytest.raises(ComputeError, match="input b is 0; division by zero"):
        result("Modulo", a=of("int", 1), b=of("int", 0))


def test_increment_adds_to_any_shape_and_keeps_the_type():
    assert result("Increment", value=of("int", 4)) == (5, "int")
    assert result("Increment", value=of("int", 4), increment=0.9) == (4, "int")
    assert result("Increment", value=of("double", 4), increment=-0.5) == (3.5, "double")
    assert result("Increment", value=of("int[2]", [1, 2])) == ([2, 3], "int[2]")
    with pytest.raises(ComputeError, match=r"the result 256 does not fit uchar \(0 to 255\); make an operand wider"):
        result("Increment", value=of("uchar", 255))


def test_clamp_keeps_numbers_and_components_within_bounds():
    assert result("Clamp", input=of("double", 5), lower=of("double", 0), upper=of("double", 2)) == (2, "double")
    assert result("Clamp", input=of("int", -5), lower=of("int", 0), upper=of("int", 2)) == (0, "int")
    vector = result("Clamp", input=of("double[3]", [-1, 1, 9]), lower=of("double", 0), upper=of("double[3]", [5, 5, 5]))
    assert vector == ([0, 1, 5], "double[3]")


def test_crossed_bounds_fail():
    with pytest.raises(ComputeError, match=r"input lower \(3\.0\) is above input upper \(2\.0\); swap them"):
        result("Clamp", input=of("double", 5), lower=of("double", 3), upper=of("double", 2))


LEAST, MOST = -(2**31), 2**31 - 1
UNFIT = [
    ("Add", {"a": of("int", MOST), "b": of("int", MOST)}, "4294967294 does not fit int (-2147483648 to 2147483647)"),
    ("Add", {"a": of("int[2]", [0, MOST]), "b": of("int[2]", [0, 1])}, "2147483648 does not fit int[2] ("),
    ("Add", {"a": of("int[]", [LEAST]), "b": of("int", -1)}, "-2147483649 does not fit int[] ("),
    ("Add", {"a": of("int", MOST), "b": of("int", 1), "c": of("int", 0)}, "2147483648 does not fit int ("),
    ("Add", {"a": of("uint64[]", [2**64 - 1]), "b": of("uint64[]", [1])}, "18446744073709551616 does not fit uint64[]"),
    ("Add", {"a": of("uint64[]", [2**63]), "b": of("int", 0)}, "9223372036854775808 does not fit int64[] ("),
    ("Subtract", {"a": of("uchar[]", [3]), "b": of("uchar[]", [4])}, "-1 does not fit uchar[] (0 to 255)"),
    ("Multiply", {"a": of("int64[]", [2**62]), "b": of("int64[]", [2])}, "9223372036854775808 does not fit int64[] ("),
    ("Increment", {"value": of("uchar[]", [255])}, "256 does not fit uchar[] (0 to 255)"),
    ("Increment", {"value": of("int", 1), "increment": float("inf")}, "inf does not fit int ("),
    ("Absolute", {"input": of("int", LEAST)}, "2147483648 does not fit int ("),
    ("Absolute", {"input": of("int[]", [LEAST])}, "2147483648 does not fit int[] ("),
    ("Magnitude", {"input": of("int[]", [LEAST])}, "2147483648 does not fit int[] ("),
    ("Negate", {"input": of("int[2]", [0, LEAST])}, "2147483648 does not fit int[2] ("),
    ("DotProduct", {"a": of("int[2]", [MOST, 0]), "b": of("int[2]", [2, 0])}, "4294967294 does not fit int ("),
]


@pytest.mark.parametrize(("node", "inputs", "message"), UNFIT)
def test_whole_results_that_do_not_fit_fail_in_every_shape(node, inputs, message):
    with pytest.raises(ComputeError, match=re.escape(f"the result {message}")):
        run_node(node, inputs=inputs)


def test_whole_results_at_the_ends_of_their_type_are_exact():
    most = 2**64 - 1
    assert result("Add", "sum", a=of("uint64[]", [most - 1]), b=of("uint64[]", [1])) == ([most], "uint64[]")
    assert result("Subtract", "difference", a=of("uint64[]", [most]), b=of("uint64[]", [most])) == ([0], "uint64[]")
    assert result("Multiply", "product", a=of("int[2]", [LEAST, MOST]), b=of("int", 1)) == ([LEAST, MOST], "int[2]")
    low = -(2**63)
    assert result("Multiply", "product", a=of("int64[]", [2**62]), b=of("int64", -2)) == ([low], "int64[]")
    assert result("Add", "sum", a=of("int[]", []), b=of("int[]", [])) == ([], "int[]")


@pytest.mark.parametrize(("kind", "large"), [("half", 6e4), ("float", 3e38), ("double", 1e308)])
@pytest.mark.parametrize("shape", ["", "[2]", "[]"])
@pytest.mark.filterwarnings("error")
def test_real_results_beyond_their_type_are_infinite_in_every_shape(kind, large, shape):
    def given(number):
        return of(kind + shape, [number] * 2 if shape else number)

    def ends(node, output, *operands):
        inputs = dict(zip("abc", map(given, operands), strict=False))
        return np.unique(run_node(node, inputs=inputs).value(output)).tolist()

    assert ends("Add", "sum", large, large) == [math.inf]
    assert ends("Add", "sum", -large, -large, 0) == [-math.inf]
    assert ends("Multiply", "product", -large, large) == [-math.inf]
    assert ends("Divide", "result", large, 0.25) == [math.inf]
    assert np.isnan(ends("Subtract", "difference", math.inf, math.inf)).all()


def test_an_array_of_numbers_meets_a_tuple_element_by_element():
    value, name = result("Multiply", "product", a=of("double[]", [1, 10]), b=of("double[3]", [1, 2, 3]))
    assert (value, name) == ([[1, 2, 3], [10, 20, 30]], "double[3][]")


def test_operands_take_the_precision_of_the_result_before_they_meet():
    trace = run_node("Add", inputs={"a": of("float[2]", [1, 1]), "b": of("double", 1e-12)})
    assert np.array_equal(trace.value("sum"), [1 + 1e-12, 1 + 1e-12])


def test_matrices_are_not_rounded():
    with pytest.raises(UserError, match="there are no matrices of whole numbers"):
        run_node("Floor", inputs={"a": of("matrixd[2]", [[1, 0], [0, 1]])})
