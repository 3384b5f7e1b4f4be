"""Angles, powers, signs and zeros: expected values by hand."""

import math

import numpy as np
import pytest

from graph import UserError
from tests.support.typed_values import of, outcome


@pytest.mark.parametrize(
    ("kind", "output", "inputs", "value", "type_name"),
    [
        ("ToDeg", "degrees", {"radians": of("double", math.pi)}, 180, "double"),
        ("ToDeg", "degrees", {"radians": of("float[2]", [0, math.pi / 2])}, [0, 90], "float[2]"),
        ("ToRad", "radians", {"degrees": of("double[]", [90, -180])}, [math.pi / 2, -math.pi], "double[]"),
        ("ATan2", "result", {"a": of("double", 1), "b": of("double", -1)}, 135, "double"),
        ("ATan2", "result", {"a": of("double", -1), "b": of("double", 0)}, -90, "double"),
        ("ATan2", "result", {"a": of("float[]", [1, 0]), "b": of("float", 0)}, [90, 0], "float[]"),
        ("Exponent", "result", {"base": of("int", 3)}, 9, "double"),
        ("Exponent", "result", {"base": of("float[2]", [2, 4]), "exponent": -1}, [0.5, 0.25], "float[2]"),
        ("Exponent", "result", {"base": of("matrixd[2]", [[1, 2], [3, 4]])}, [[1, 4], [9, 16]], "matrixd[2]"),
        ("NthRoot", "result", {"value": of("int[]", [9, 16])}, [3, 4], "double[]"),
        ("NthRoot", "result", {"value": of("double[3]", [-8, 27, 64]), "nthRoot": 3}, [-2, 3, 4], "double[3]"),
        ("NthRoot", "result", {"value": of("double", 2), "nthRoot": 0}, math.inf, "double"),
        ("NthRoot", "result", {"value": of("double", 4), "nthRoot": -2}, 0.5, "double"),
        ("ConstantE", "value", {}, math.e, "double"),
        ("ConstantE", "value", {"exponent": 1000.0}, math.inf, "double"),
        ("ConstantPi", "value", {"factor": 0.5}, math.pi / 2, "double"),
        ("Absolute", "absolute", {"input": of("double[3]", [-1, 2, -3])}, [1, 2, 3], "double[3]"),
        ("Absolute", "absolute", {"input": of("int", -7)}, 7, "int"),
        ("Negate", "output", {"input": of("vectorf[3]", [1, -2, 0])}, [-1, 2, 0], "vectorf[3]"),
        ("FMod", "result", {"a": of("double", -7.5), "b": of("double", 2)}, -1.5, "double"),
        ("FMod", "result", {"a": of("double[3]", [7.5, 1, -2]), "b": of("double", 0)}, [0, 0, 0], "double[3]"),
        ("FMod", "result", {"a": of("double", 5), "b": of("double", 0)}, 0, "double"),
        ("IsZero", "result", {"value": of("double[]", [0, 1e-9]), "tolerance": 1e-6}, True, "bool"),
        ("IsZero", "result", {"value": of("double[]", [0, 1e-9])}, False, "bool"),
        ("AnyZero", "result", {"value": of("int[3]", [1, 0, 2])}, True, "bool"),
        ("AnyZero", "result", {"value": of("int", 5)}, False, "bool"),
        ("EachZero", "result", {"value": of("int", 0)}, True, "bool"),
        ("EachZero", "result", {"value": of("double[3]", [0, 0, 1])}, [True, True, False], "bool[]"),
        ("EachZero", "result", {"value": of("double[2][]", [[0, 0], [0, 1]])}, [True, False], "bool[]"),
        ("EachZero", "result", {"value": of("matrixd[2]", [[0, 1], [0, 0]])}, [False, True], "bool[]"),
        ("EachZero", "result", {"value": of("double[]", [])}, [], "bool[]"),
    ],
)
def test_a_function_of_numbers_gives_its_value_in_its_type(kind, output, inputs, value, type_name):
    result, name = outcome(kind, output, **inputs)
    assert name == type_name
    assert np.allclose(result, value, rtol=1e-6, atol=0)


def test_an_even_root_of_a_negative_number_is_none():
    assert math.isnan(outcome("NthRoot", "result", value=of("double", -4))[0])


def test_numbers_without_signs_cannot_be_negated():
    with pytest.raises(UserError, match=r"input input \(uint\) has no negative numbers"):
        outcome("Negate", "output", input=of("uint", 3))
