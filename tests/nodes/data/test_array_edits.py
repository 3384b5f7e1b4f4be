import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from tests.support.typed_values import of, result


def edited(kind, output="array", **inputs):
    return result(kind, output, **inputs)


NUMBERS = of("double[]", [1, 2, 3])
TEXTS = of("token[]", ["a", "b"])


@pytest.mark.parametrize(("array", "size"), [(NUMBERS, 3), (TEXTS, 2), (of("float[3][]", [[1, 2, 3]]), 1)])
def test_the_size_of_an_array_counts_its_elements(array, size):
    assert edited("ArrayGetSize", "size", array=array) == (size, "int")


@pytest.mark.parametrize(
    ("array", "value", "index"),
    [
        (of("int[]", [4, 5, 5]), 5, 1),
        (of("int[]", [4, 5, 5]), 6, -1),
        (of("int[]", []), 6, -1),
        (of("int[2][]", [[1, 2], [1, 3]]), [1, 3], 1),
        (of("int[2][]", [[1, 2], [1, 3]]), [1, 4], -1),
        (TEXTS, "b", 1),
        (TEXTS, "c", -1),
    ],
)
def test_a_value_is_found_at_its_first_place(array, value, index):
    assert edited("ArrayFindValue", "index", array=array, value=value) == (index, "int")


def test_set_index_replaces_one_element_and_counts_negative_ones_from_the_end():
    assert edited("ArraySetIndex", array=NUMBERS, index=0, value=9) == ([9.0, 2.0, 3.0], "double[]")
    assert edited("ArraySetIndex", array=NUMBERS, index=-1, value=9) == ([1.0, 2.0, 9.0], "double[]")
    assert edited("ArraySetIndex", array=TEXTS, index=1, value="z") == (["a", "z"], "token[]")


def test_set_index_grows_the_array_only_when_it_may():
    grown = edited("ArraySetIndex", array=NUMBERS, index=5, value=9, resizeToFit=True)
    assert grown == ([1.0, 2.0, 3.0, 0.0, 0.0, 9.0], "double[]")
    with pytest.raises(ComputeError, match="input index is 5, but the array has 3 elements; set resizeToFit"):
        edited("ArraySetIndex", array=NUMBERS, index=5, value=9)
    with pytest.raises(ComputeError, match="input index is -4, but the array has 3 elements"):
        edited("ArraySetIndex", array=NUMBERS, index=-4, value=9, resizeToFit=True)


def test_set_index_leaves_the_array_that_it_was_given_alone():
    trace = run_node("ArraySetIndex", inputs={"array": NUMBERS, "index": 0, "value": 9})
    assert trace.value("inputs:array").tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("index", "array"),
    [(0, [9, 1, 2, 3]), (2, [1, 2, 9, 3]), (-1, [1, 2, 9, 3]), (7, [1, 2, 3, 9]), (-7, [9, 1, 2, 3])],
)
def test_insert_puts_the_element_before_the_index_and_clamps_it(index, array):
    assert edited("ArrayInsertValue", array=of("int[]", [1, 2, 3]), index=index, value=9) == (array, "int[]")


def test_insert_works_on_texts_and_tuples():
    assert edited("ArrayInsertValue", array=TEXTS, index=1, value="x")[0] == ["a", "x", "b"]
    pairs = edited("ArrayInsertValue", array=of("double[2][]", [[1, 2]]), index=1, value=[3, 4])
    assert pairs == ([[1.0, 2.0], [3.0, 4.0]], "double[2][]")


def test_a_real_number_enters_an_array_of_whole_numbers_cut_off():
    assert edited("ArraySetIndex", array=of("int[]", [1]), index=0, value=of("double", 2.9)) == ([2], "int[]")


def test_an_element_of_another_kind_is_refused_when_the_graph_is_compiled():
    with pytest.raises(
        UserError, match=r"input value \(token\) cannot go into input array \(double\[\]\); give it double"
    ):
        edited("ArraySetIndex", array=NUMBERS, index=0, value=of("token", "x"))


def test_resize_cuts_off_or_fills_with_zeros():
    assert edited("ArrayResize", array=NUMBERS, newSize=2) == ([1.0, 2.0], "double[]")
    assert edited("ArrayResize", array=NUMBERS, newSize=4) == ([1.0, 2.0, 3.0, 0.0], "double[]")
    assert edited("ArrayResize", array=TEXTS, newSize=3) == (["a", "b", ""], "token[]")
    with pytest.raises(ComputeError, match="input newSize is -1; give it 0 or more"):
        edited("ArrayResize", array=NUMBERS, newSize=-1)


def test_arrays_are_appended_in_the_order_of_their_inputs():
    three = {
        "input0": NUMBERS,
        "input1": of("double[]", [4]),
        "input10": of("double[]", [6]),
        "input2": of("double[]", [5]),
    }
    assert edited("AppendArray", **three) == ([1, 2, 3, 4, 5, 6], "double[]")
    assert edited("AppendArray", input0=TEXTS, input1=TEXTS) == (["a", "b", "a", "b"], "token[]")


def test_arrays_of_two_types_cannot_be_appended():
    with pytest.raises(
        UserError, match=r"input input0 \(double\[\]\) and input input1 \(token\[\]\) cannot be put into one"
    ):
        edited("AppendArray", input0=NUMBERS, input1=TEXTS)
