"""Texts looked into and changed, and numbers in other storages."""

import numpy as np
import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from tests.support.typed_values import of


@pytest.mark.parametrize(
    ("kind", "output", "inputs", "value"),
    [
        ("StartsWith", "isPrefix", {"prefix": "/World", "value": "/World/Cube"}, True),
        ("StartsWith", "isPrefix", {"prefix": "/World/Cube", "value": "/World"}, False),
        ("EndsWith", "isSuffix", {"suffix": "Cube", "value": "/World/Cube"}, True),
        ("EndsWith", "isSuffix", {"suffix": "cube", "value": "/World/Cube"}, False),
        ("CapitalizeString", "string", {"string": of("token", "a big Day")}, "A BIG DAY"),
        ("CapitalizeString", "string", {"string": of("token", "A big Day"), "operation": "LowerCase"}, "a big day"),
        ("CapitalizeString", "string", {"string": of("string", "a big day"), "operation": "Capitalize"}, "A big day"),
        ("CapitalizeString", "string", {"string": of("string", "a big day"), "operation": "Title"}, "A Big Day"),
        ("GetStringLength", "length", {"string": of("string", "abc")}, 3),
        ("FindString", "index", {"string": of("string", "banana"), "value": of("token", "an")}, 1),
        ("FindString", "index", {"string": of("string", "banana"), "value": of("token", "an"), "pos": 2}, 3),
        ("FindString", "index", {"string": of("string", "banana"), "value": of("token", "x")}, -1),
        ("InsertString", "string", {"string": of("string", "abc"), "value": of("token", "--"), "index": 1}, "a--bc"),
        ("InsertString", "string", {"string": of("string", "abc"), "value": of("token", "!"), "index": 99}, "abc!"),
        (
            "ReplaceString",
            "string",
            {"string": of("string", "banana"), "replace": of("string", "an"), "value": of("string", "o")},
            "boana",
        ),
        (
            "ReplaceString",
            "string",
            {
                "string": of("string", "banana"),
                "replace": of("string", "an"),
                "value": of("string", ""),
                "replaceAll": True,
            },
            "ba",
        ),
        ("SplitString", "elements", {"string": "a/b//c", "delimiter": "/"}, ["a", "b", "", "c"]),
        ("SplitString", "elements", {"string": "a b"}, ["a b"]),
        ("IsEmpty", "isEmpty", {"input": of("string", "")}, True),
        ("IsEmpty", "isEmpty", {"input": of("double[]", [])}, True),
        ("IsEmpty", "isEmpty", {"input": of("token[]", ["a"])}, False),
        ("IsEmpty", "isEmpty", {"input": of("int", 0)}, False),
    ],
)
def test_a_function_of_text_gives_its_value(kind, output, inputs, value):
    assert run_node(kind, inputs=inputs).value(output) == value


@pytest.mark.parametrize(
    ("kind", "value", "role", "converted", "type_name"),
    [
        ("ToFloat", of("double", 0.1), "None", np.float32(0.1), "float"),
        ("ToFloat", of("double[3]", [1, 2, 3]), "Point", [1, 2, 3], "pointf[3]"),
        ("ToFloat", of("int[]", [1, 2]), "None", [1, 2], "float[]"),
        ("ToFloat", of("bool", True), "None", 1, "float"),
        ("ToHalf", of("double", 0.1), "None", np.float16(0.1), "half"),
        ("ToHalf", of("colord[4]", [1, 0.5, 0, 1]), "Color", [1, 0.5, 0, 1], "colorh[4]"),
    ],
)
def test_a_number_is_rounded_to_the_storage_asked_for(kind, value, role, converted, type_name):
    trace = run_node(kind, inputs={"value": value, "role": role})
    assert np.array_equal(trace.value("converted"), converted)
    assert trace.node.types["outputs:converted"].name == type_name


def test_matrices_have_no_float_form():
    with pytest.raises(UserError, match=r"input value \(matrixd\[2\]\) cannot become float; leave it in doubles"):
        run_node("ToFloat", inputs={"value": of("matrixd[2]", [1, 0, 0, 1])})


def test_whole_numbers_of_64_bits_are_cut_off_and_never_negative():
    def converted(value):
        return run_node("ToUint64", inputs={"value": value}).value("converted")

    assert converted(of("double", 3.9)) == 3
    assert converted(of("uint64", 2**64 - 1)) == 2**64 - 1
    assert converted(of("bool[]", [True, False])).tolist() == [1, 0]
    for wrong in (of("int", -3), of("double", 1e30)):
        with pytest.raises(ComputeError, match="no whole number from 0"):
            converted(wrong)


def test_whole_numbers_of_8_bits_come_from_numbers_and_texts():
    def converted(value):
        return run_node("ToUchar", inputs={"value": value}).value("converted")

    assert converted(of("string", "12")) == 12
    assert converted(of("double[]", [1.9, 255.9])).tolist() == [1, 255]
    for wrong in (of("int", 256), of("int", -1)):
        with pytest.raises(ComputeError, match="no whole number from 0 to 255"):
            converted(wrong)
    with pytest.raises(ComputeError, match='"a", which is not a number'):
        converted(of("string", "a"))
