import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of


def built(**inputs):
    trace = run_node("BuildString", inputs=inputs)
    return trace.value("value"), trace.node.types["outputs:value"].name


def test_texts_are_put_together_in_the_type_of_the_first():
    assert built(a=of("string", "a"), b=of("token", "b")) == ("ab", "string")
    assert built(a=of("token", "/World"), b=of("token", "/Box"), c=of("token", "_1")) == ("/World/Box_1", "token")


def test_an_array_takes_a_text_for_each_element():
    assert built(a=of("token[]", ["x", "y"]), b=of("token", "!")) == (["x!", "y!"], "token[]")
    assert built(a=of("token", "-"), b=of("token[]", ["x", "y"])) == (["-x", "-y"], "token[]")
    with pytest.raises(ComputeError, match="the arrays have 1 and 2 elements; they need one length"):
        built(a=of("token[]", ["x"]), b=of("token[]", ["x", "y"]))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (of("int", 3), "3"),
        (of("double", 0.5), "0.5"),
        (of("token", "a"), "a"),
        (of("double[2]", [1, 2]), "(1.0, 2.0)"),
        (of("int[]", [1, 2]), "[1, 2]"),
        (of("bool", True), "True"),
    ],
)
def test_a_value_is_written_down_as_a_token(value, text):
    assert run_node("ToToken", inputs={"value": value}).value("converted") == text


@pytest.mark.parametrize(
    ("operator", "rows"),
    [
        ("AND", [False, False, False, True]),
        ("OR", [False, True, True, True]),
        ("NAND", [True, True, True, False]),
        ("NOR", [True, False, False, False]),
        ("XOR", [False, True, True, False]),
        ("XNOR", [True, False, False, True]),
    ],
)
def test_the_truth_tables_of_boolean_expr(operator, rows):
    pairs = [(False, False), (False, True), (True, False), (True, True)]
    found = [run_node("BooleanExpr", inputs={"a": a, "b": b, "operator": operator}).value("result") for a, b in pairs]
    assert found == rows


@pytest.mark.parametrize(
    ("kind", "rows"),
    [
        ("BooleanNand", [True, True, True, False]),
        ("BooleanNor", [True, False, False, False]),
        ("BooleanXor", [False, True, True, False]),
    ],
)
def test_the_truth_tables_of_the_other_boolean_nodes(kind, rows):
    pairs = [(False, False), (False, True), (True, False), (True, True)]
    found = [run_node(kind, inputs={"a": of("bool", a), "b": of("bool", b)}).value("result") for a, b in pairs]
    assert found == rows
    inputs = {"a": of("bool[]", [False, False, True, True]), "b": of("bool[]", [False, True, False, True])}
    assert run_node(kind, inputs=inputs).value("result").tolist() == rows


def test_nand_takes_further_operands():
    three = {name: of("bool", True) for name in "abc"}
    assert run_node("BooleanNand", inputs=three).value("result") is False
    assert run_node("BooleanNand", inputs=three | {"c": of("bool", False)}).value("result") is True


def test_an_operator_that_comes_by_a_connection_is_checked_too():
    inputs = {"operator": "MAYBE"}
    with pytest.raises(ComputeError, match="input operator is 'MAYBE'; it must be one of AND OR NAND NOR XOR XNOR"):
        run_node("BooleanExpr", inputs=inputs, connect={"operator": "token"})
