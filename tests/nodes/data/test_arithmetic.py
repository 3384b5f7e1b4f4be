import numpy as np
import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from nodes.data.promotion import common_storage
from tests.support.typed_values import of, outcome


def combined(kind, a, b, output, **more):
    return outcome(kind, output, a=a, b=b, **more)


@pytest.mark.parametrize(
    ("a", "b", "total", "type_name"),
    [
        (of("int", 2), of("int", 3), 5, "int"),
        (of("int", 2), of("double", 0.5), 2.5, "double"),
        (of("float", 1.5), of("double", 0.25), 1.75, "double"),
        (of("uchar", 200), of("uchar", 50), 250, "uchar"),
        (of("int", -1), of("uint", 1), 0, "int64"),
        (of("double[3]", [1, 2, 3]), of("double", 10), [11, 12, 13], "double[3]"),
        (of("pointd[3]", [1, 2, 3]), of("vectord[3]", [1, 1, 1]), [2, 3, 4], "double[3]"),
        (of("vectorf[3]", [1, 2, 3]), of("float", 1), [2, 3, 4], "vectorf[3]"),
        (of("double[]", [1, 2]), of("double[]", [3, 4]), [4, 6], "double[]"),
        (of("double[2][]", [[1, 2], [3, 4]]), of("double[2]", [10, 20]), [[11, 22], [13, 24]], "double[2][]"),
        (of("int[]", [1, 2]), of("int", 1), [2, 3], "int[]"),
    ],
)
def test_add_promotes_its_operands(a, b, total, type_name):
    value, name = combined("Add", a, b, "sum")
    assert np.array_equal(value, total)
    assert name == type_name


def test_add_takes_further_operands_by_letters():
    value, _ = combined("Add", of("double", 1), of("double", 2), "sum", c=of("double", 3), d=of("double", 4))
    assert value == 10


def test_subtract_takes_all_further_operands_from_the_first():
    assert combined("Subtract", of("int", 10), of("int", 2), "difference", c=of("int", 3)) == (5, "int")


def test_multiply_works_element_by_element():
    value, name = combined("Multiply", of("double[3]", [1, 2, 3]), of("double[3]", [4, 5, 6]), "product")
    assert value.tolist() == [4, 10, 18]
    assert name == "double[3]"


def test_arrays_of_different_length_do_not_add_up():
    with pytest.raises(ComputeError, match="the arrays have 1 and 3 elements; they need one length"):
        combined("Add", of("double[]", [1]), of("double[]", [1, 2, 3]), "sum")


def test_tuples_of_different_size_are_refused_when_the_graph_is_compiled():
    with pytest.raises(
        UserError, match=r"input a \(double\[2\]\) and input b \(double\[3\]\) have different numbers of components"
    ):
        combined("Add", of("double[2]", [1, 2]), of("double[3]", [1, 2, 3]), "sum")


def test_an_operand_that_is_not_set_is_an_error_naming_it():
    with pytest.raises(UserError, match="input b is not set"):
        run_node("Add", inputs={"a": 1.0})


@pytest.mark.parametrize(
    ("a", "b", "quotient", "type_name"),
    [
        (of("int", 7), of("int", 2), 3.5, "double"),
        (of("float", 7), of("float", 2), 3.5, "float"),
        (of("double[3]", [2, 4, 6]), of("int", 2), [1, 2, 3], "double[3]"),
        (of("int[]", [1, 2]), of("int", 4), [0.25, 0.5], "double[]"),
    ],
)
def test_divide_gives_doubles_for_integers(a, b, quotient, type_name):
    value, name = combined("Divide", a, b, "result")
    assert np.array_equal(value, quotient)
    assert name == type_name


@pytest.mark.parametrize("b", [of("double", 0), of("double[]", [1, 0])])
def test_divide_by_zero_fails(b):
    with pytest.raises(ComputeError, match="input b contains 0"):
        combined("Divide", of("double", 1), b, "result")


@pytest.mark.parametrize(
    ("storages", "common"),
    [
        (["int", "uchar"], "int"),
        (["uint", "int64"], "int64"),
        (["uint64", "uint64"], "uint64"),
        (["half", "float", "int64"], "float"),
        (["double", "half"], "double"),
    ],
)
def test_the_common_storage_holds_both_operands(storages, common):
    assert common_storage(storages) == common
