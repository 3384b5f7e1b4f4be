import json
import re

import pytest

from graph import ComputeError, UserError, compile_graphs
from graph.files import loads
from graph.testing import run_node
from tests.support.typed_values import of, result


@pytest.mark.parametrize(
    ("a", "operation", "b", "holds"),
    [
        (of("int", 2), ">", of("int", 1), True),
        (of("int", 2), "<=", of("double", 2.0), True),
        (of("token", "abc"), "==", of("token", "abc"), True),
        (of("string", "abc"), "<", of("string", "abd"), True),
        (of("double[3]", [1, 2, 3]), "<", of("double[3]", [1, 3, 0]), True),
        (of("double[3]", [1, 2, 3]), "!=", of("double[3]", [1, 2, 3]), False),
        (of("bool", True), "==", of("bool", False), False),
    ],
)
def test_compare_single_values(a, operation, b, holds):
    assert result("Compare", a=a, b=b, operation=operation) == (holds, "bool")


def test_compare_goes_through_arrays_and_stretches_a_single_value():
    found = result("Compare", a=of("double[]", [1, 2, 3]), b=of("double", 2), operation=">=")
    assert found == ([False, True, True], "bool[]")
    tuples = of("int[2][]", [[1, 9], [2, 0]])
    assert result("Compare", a=tuples, b=of("int[2]", [2, 0]), operation="==") == ([False, True], "bool[]")


def test_compare_of_arrays_of_different_length_fails():
    with pytest.raises(ComputeError, match="the arrays have 1 and 2 elements"):
        run_node("Compare", inputs={"a": of("int[]", [1]), "b": of("int[]", [1, 2])})


@pytest.mark.parametrize(
    ("kind", "operands", "value"),
    [
        ("BooleanAnd", [True, True], True),
        ("BooleanAnd", [True, False], False),
        ("BooleanAnd", [True, True, False], False),
        ("BooleanOr", [False, False], False),
        ("BooleanOr", [False, False, True], True),
    ],
)
def test_boolean_logic_takes_two_or_more_operands(kind, operands, value):
    assert result(kind, **dict(zip("abc", operands, strict=False))) == (value, "bool")


def test_boolean_logic_goes_through_arrays():
    found = result("BooleanOr", a=of("bool[]", [True, False]), b=False)
    assert found == ([True, False], "bool[]")
    assert result("BooleanNot", "valueOut", valueIn=of("bool[]", [True, False])) == ([False, True], "bool[]")
    assert result("BooleanNot", "valueOut", valueIn=True) == (False, "bool")


@pytest.mark.parametrize(
    ("condition", "if_true", "if_false", "found"),
    [
        (True, of("int", 1), of("int", 2), (1, "int")),
        (False, of("int", 1), of("double", 2.5), (2.5, "double")),
        (False, of("token", "a"), of("token", "b"), ("b", "token")),
        (of("bool[]", [True, False]), of("int", 1), of("int", 2), ([1, 2], "int[]")),
        (of("bool[]", [True, False]), of("int[]", [1, 2]), of("int[]", [3, 4]), ([1, 4], "int[]")),
        (of("bool[]", [True, False]), of("token", "a"), of("token", "b"), (["a", "b"], "token[]")),
    ],
)
def test_select_takes_one_of_two(condition, if_true, if_false, found):
    assert result("SelectIf", condition=condition, ifTrue=if_true, ifFalse=if_false) == found


def test_select_refuses_values_without_a_common_type():
    with pytest.raises(
        UserError, match=r"input ifTrue \(int\) and input ifFalse \(string\) have no common type; give it two numbers"
    ):
        result("SelectIf", condition=True, ifTrue=of("int", 1), ifFalse=of("string", "x"))


@pytest.mark.parametrize(
    ("condition", "if_true", "if_false"),
    [
        (True, of("int", 1), of("half[2]", [1, 2])),
        (True, of("double[3]", [1, 2, 3]), of("double[3][]", [[1, 2, 3]])),
        (of("bool[]", [True]), of("int", 1), of("half[2]", [1, 2])),
    ],
)
def test_select_if_refuses_sides_of_different_shape(condition, if_true, if_false):
    with pytest.raises(UserError, match="differ in shape"):
        result("SelectIf", condition=condition, ifTrue=if_true, ifFalse=if_false)


@pytest.mark.parametrize(
    ("value", "role", "found"),
    [
        (of("int", 3), "None", (3.0, "double")),
        (of("bool", True), "None", (1.0, "double")),
        (of("pointf[3]", [1, 2, 3]), "None", ([1, 2, 3], "double[3]")),
        (of("float[3]", [1, 2, 3]), "Vector", ([1, 2, 3], "vectord[3]")),
        (of("int[]", [1, 2]), "None", ([1, 2], "double[]")),
        (of("float", 2), "Timecode", (2.0, "timecode")),
        (of("float[4]", [0, 0, 0, 1]), "Quaternion", ([0, 0, 0, 1], "quatd[4]")),
    ],
)
def test_to_double_keeps_the_shape_and_takes_the_role(value, role, found):
    assert result("ToDouble", "converted", value=value, role=role) == found


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (("double", 1.0), ("token", "x")),
        (("double", 1.0), ("double[3]", [1, 2, 3])),
        (("double[2]", [1, 2]), ("double[3]", [1, 2, 3])),
        (("double", 1.0), ("matrixd[2][]", [])),
        (("token[]", ["a"]), ("bool", True)),
    ],
)
def test_compare_of_unlike_types_is_refused_before_the_run(a, b):
    names = f"input a ({a[0]}) and input b ({b[0]}) cannot be compared"
    with pytest.raises(UserError, match=re.escape(names)):
        run_node("Compare", inputs={"a": of(*a), "b": of(*b)})


def test_compare_names_where_an_unlike_value_comes_from():
    message = r"input a \(token, from source\.outputs:a\) and input b \(double\) cannot be compared"
    with pytest.raises(UserError, match=message):
        run_node("Compare", inputs={"a": "x", "b": of("double", 1.0)}, connect={"a": "token"})


@pytest.mark.parametrize("role", ["foo", "", "*", 5, of("token", "colour")])
def test_to_double_refuses_an_unknown_role_as_a_mistake_in_the_file(role):
    text = (
        "tickgraph: 1\ngraphs:\n  /G:\n    evaluator: push\n    nodes:\n"
        "      d: {type: ToDouble, inputs: {value: {type: double, value: 1.0}, role: ROLE}}\n"
    ).replace("ROLE", json.dumps(role))
    with pytest.raises(UserError) as caught:
        compile_graphs(loads(text, name="a.yaml").graphs)
    [problem] = caught.value.problems
    assert str(problem).startswith('a.yaml:6:71: node "d": role: ')


def test_to_double_refuses_a_role_that_does_not_fit():
    with pytest.raises(UserError, match=r"input value \(float\[2\]\) cannot have the role Vector; set role to None"):
        result("ToDouble", "converted", value=of("float[2]", [1, 2]), role="Vector")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (of("double", 0.1), "0.1"),
        (of("int", -3), "-3"),
        (of("bool", True), "True"),
        (of("token", "name"), "name"),
        (of("double[3]", [1, 2, 3]), "(1.0, 2.0, 3.0)"),
        (of("int[]", [1, 2]), "[1, 2]"),
        (of("int[2][]", [[1, 2], [3, 4]]), "[(1, 2), (3, 4)]"),
        (of("token[]", ["a", "b"]), "[a, b]"),
    ],
)
def test_to_string_writes_values_down(value, text):
    assert result("ToString", "converted", value=value) == (text, "string")
