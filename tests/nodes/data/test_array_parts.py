"""Arrays filled, shortened, turned and cut."""

import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of

NUMBERS = of("double[]", [1, 2, 3, 2])
TOKENS = of("token[]", ["a", "b", "a"])
VECTORS = of("double[2][]", [[1, 2], [3, 4]])


def array_of(kind, **inputs):
    trace = run_node(kind, inputs=inputs)
    value = trace.value("array")
    return value.tolist() if hasattr(value, "tolist") else value


@pytest.mark.parametrize(
    ("kind", "inputs", "result"),
    [
        ("ArrayAppendValue", {"array": NUMBERS, "value": of("int", 9)}, [1, 2, 3, 2, 9]),
        ("ArrayAppendValue", {"array": TOKENS, "value": of("token", "c")}, ["a", "b", "a", "c"]),
        ("ArrayAppendValue", {"array": VECTORS, "value": of("double[2]", [5, 6])}, [[1, 2], [3, 4], [5, 6]]),
        ("ArrayFill", {"array": NUMBERS, "fillValue": of("int", 7)}, [7, 7, 7, 7]),
        ("ArrayFill", {"array": TOKENS, "fillValue": of("token", "x")}, ["x", "x", "x"]),
        ("ArrayFill", {"array": VECTORS, "fillValue": of("double[2]", [0, 1])}, [[0, 1], [0, 1]]),
        ("ArrayRemoveIndex", {"array": NUMBERS}, [2, 3, 2]),
        ("ArrayRemoveIndex", {"array": TOKENS, "index": -1}, ["a", "b"]),
        ("ArrayRemoveIndex", {"array": VECTORS, "index": 1}, [[1, 2]]),
        ("ArrayRemoveValue", {"array": NUMBERS, "value": of("int", 2)}, [1, 3, 2]),
        ("ArrayRemoveValue", {"array": NUMBERS, "value": of("int", 2), "removeAll": True}, [1, 3]),
        ("ArrayRemoveValue", {"array": TOKENS, "value": of("token", "z")}, ["a", "b", "a"]),
        ("ArrayRotate", {"array": NUMBERS, "steps": 1}, [2, 1, 2, 3]),
        ("ArrayRotate", {"array": TOKENS, "steps": -1}, ["b", "a", "a"]),
        ("ArrayRotate", {"array": VECTORS, "steps": 5}, [[3, 4], [1, 2]]),
        ("ArrayRotate", {"array": of("int[]", []), "steps": 3}, []),
        ("ArraySlice", {"array": NUMBERS, "start": 1}, [2, 3, 2]),
        ("ArraySlice", {"array": NUMBERS, "start": -3, "end": -1, "useLength": False}, [2, 3]),
        ("ArraySlice", {"array": NUMBERS, "start": 3, "end": 1, "useLength": False}, []),
        ("ArraySlice", {"array": TOKENS, "start": -9, "end": 9, "useLength": False}, ["a", "b", "a"]),
        ("ArraySlice", {"array": of("string", "hello"), "end": 2, "useLength": False}, "he"),
    ],
)
def test_an_array_is_made_of_another(kind, inputs, result):
    assert array_of(kind, **inputs) == result


def test_a_value_that_is_not_there_is_not_found():
    for value, found in ((2, True), (9, False)):
        assert (
            run_node("ArrayRemoveValue", inputs={"array": NUMBERS, "value": of("int", value)}).value("found") is found
        )


def test_an_index_beyond_the_array_fails():
    with pytest.raises(ComputeError, match="input index is 4, but the array has 4 elements"):
        array_of("ArrayRemoveIndex", array=NUMBERS, index=4)


def test_partial_sums_leave_the_element_itself_out():
    def sums(array):
        return run_node("PartialSum", inputs={"array": array}).value("partialSum").tolist()

    assert sums([3, 1, 4]) == [0, 3, 4]
    assert sums([]) == []
    with pytest.raises(ComputeError, match="which an int cannot hold"):
        sums([2**31 - 1, 1, 0])
