from dataclasses import replace

import numpy as np
import pytest

from graph import ComputeError, Context, UserError, compile_graphs
from graph.spec.file_spec import GraphSpec, NodeSpec
from graph.testing import run_node
from tests.support.typed_values import of


def test_break_vector3_gives_plain_numbers_of_the_vectors_kind():
    trace = run_node("BreakVector3", inputs={"tuple": of("vectorf[3]", [1.5, 2.5, 3.5])})
    assert [trace.value(axis) for axis in "xyz"] == [1.5, 2.5, 3.5]
    assert trace.node.types["outputs:x"].name == "float"


def test_break_vector3_refuses_a_vector_of_four():
    with pytest.raises(UserError, match=r"input tuple \(double\[4\]\) must have 3 components; use BreakVector4"):
        run_node("BreakVector3", inputs={"tuple": of("double[4]", [1, 2, 3, 4])})


@pytest.mark.parametrize(
    ("kinds", "made"),
    [
        (["double", "double", "double"], "double[3]"),
        (["int", "int", "int"], "int[3]"),
        (["float", "int", "half"], "float[3]"),
        (["int64", "int", "int"], "double[3]"),
    ],
)
def test_make_vector3_takes_the_common_kind(kinds, made):
    inputs = {axis: of(kind, value) for axis, kind, value in zip("xyz", kinds, (1, 2, 3), strict=True)}
    trace = run_node("MakeVector3", inputs=inputs)
    assert trace.value("tuple").tolist() == [1, 2, 3]
    assert trace.node.types["outputs:tuple"].name == made


def test_make_vector3_of_arrays_gives_an_array_of_vectors():
    inputs = {"x": of("double[]", [1, 2]), "y": of("double[]", [3, 4]), "z": of("double", 5)}
    trace = run_node("MakeVector3", inputs=inputs)
    assert trace.value("tuple").tolist() == [[1, 3, 5], [2, 4, 5]]
    assert trace.node.types["outputs:tuple"].name == "double[3][]"


def test_make_vector3_of_arrays_of_different_length_fails():
    inputs = {"x": of("double[]", [1, 2]), "y": of("double[]", [3]), "z": of("double", 5)}
    with pytest.raises(ComputeError, match="the arrays have 1 and 2 elements"):
        run_node("MakeVector3", inputs=inputs)


def array(size, kind="auto", **elements):
    trace = run_node("ConstructArray", inputs={"arraySize": size, "arrayType": kind, **elements})
    return trace.value("array"), trace.node.types["outputs:array"].name


def test_construct_array_takes_the_type_of_its_inputs():
    value, name = array(2, input0=of("double", 1), input1=of("double", 2))
    assert (value.tolist(), name) == ([1, 2], "double[]")


def test_a_smaller_size_cuts_the_array_off_and_a_larger_one_repeats_the_last_element():
    inputs = {"input0": of("int", 7), "input1": of("int", 8), "input2": of("int", 9)}
    assert array(2, **inputs)[0].tolist() == [7, 8]
    assert array(5, **inputs)[0].tolist() == [7, 8, 9, 9, 9]
    assert array(0, **inputs)[0].tolist() == []


def test_construct_array_of_tokens_and_of_vectors():
    assert array(2, "token[]", input0="left", input1="right") == (["left", "right"], "token[]")
    value, name = array(1, "vectord[3][]", input0=[1.0, 2.0, 3.0])
    assert (value.tolist(), name) == ([[1, 2, 3]], "vectord[3][]")


def test_construct_array_puts_input10_after_input9():
    inputs = {f"input{n}": of("int", n) for n in (10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0)}
    assert array(11, **inputs)[0].tolist() == list(range(11))


def test_construct_array_refuses_a_type_that_is_none():
    with pytest.raises(UserError, match="arrayType"):
        array(1, "doubel[]", input0=1.0)


@pytest.mark.parametrize(("index", "element"), [(0, 1.5), (2, 3.5), (-1, 3.5), (-3, 1.5)])
def test_array_index_counts_from_both_ends(index, element):
    inputs = {"array": of("double[]", [1.5, 2.5, 3.5]), "index": index}
    assert run_node("ArrayIndex", inputs=inputs).value("value") == element


@pytest.mark.parametrize("index", [3, -4])
def test_array_index_out_of_range_fails(index):
    with pytest.raises(ComputeError, match=f"index is {index}, but the array has 3 elements"):
        run_node("ArrayIndex", inputs={"array": of("double[]", [1, 2, 3]), "index": index})


def test_array_index_of_an_array_of_vectors_gives_a_vector():
    trace = run_node("ArrayIndex", inputs={"array": of("float[3][]", [[1, 2, 3], [4, 5, 6]]), "index": 1})
    assert np.array_equal(trace.value("value"), [4, 5, 6])


def test_read_variable_takes_the_variables_type():
    trace = run_node("ReadVariable", inputs={"variableName": "gain"}, variables={"gain": ("double", 2.5)})
    assert trace.value("value") == 2.5
    assert trace.node.types["outputs:value"].name == "double"


def test_write_variable_changes_it_and_passes_the_value_on():
    trace = run_node(
        "WriteVariable",
        inputs={"variableName": "gain", "value": lambda update: update + 0.5},
        pulses={"execIn": [0, 2]},
        updates=3,
        variables={"gain": ("double", 2.5)},
    )
    assert trace.fired("execOut") == [0, 2]
    assert trace.values("outputs:value")[2] == 2.5
    assert trace.graph.variables["gain"] == 2.5


def test_a_variable_that_the_graph_does_not_have_is_an_error():
    with pytest.raises(UserError, match='no variable "gian"; did you mean "gain"'):
        run_node("ReadVariable", inputs={"variableName": "gian"}, variables={"gain": ("double", 2.5)})
    for name in ("ReadVariable", "WriteVariable"):
        with pytest.raises(UserError, match="input variableName is empty; give it the name of a graph variable"):
            run_node(name, variables={"gain": ("double", 2.5)}, inputs={"value": 1.0} if name[0] == "W" else {})


def test_an_unfinished_graph_needs_the_variable_only_when_it_runs():
    spec = GraphSpec("/G", (NodeSpec("read", "ReadVariable", {"variableName": "gain"}),), evaluator="push")
    [graph] = compile_graphs([replace(spec, unfinished=True)])
    with pytest.raises(ComputeError, match='the graph has no variable "gain"'):
        graph.evaluate(Context.standalone())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ConstantDouble", 2.5),
        ("ConstantInt", -3),
        ("ConstantBool", True),
        ("ConstantString", "text"),
        ("ConstantToken", "token"),
    ],
)
def test_a_constant_is_its_value_and_never_computes(name, value):
    trace = run_node(name, inputs={"value": value}, updates=3)
    assert trace.values("inputs:value") == [value] * 3
    assert trace.computes == 0


def test_constants_start_at_the_zero_of_their_type():
    assert run_node("ConstantQuatd").value("inputs:value").tolist() == [0, 0, 0, 1]
    assert run_node("ConstantMatrix3d").value("inputs:value").tolist() == np.eye(3).tolist()
    assert run_node("ConstantColor4f").value("inputs:value").tolist() == [0, 0, 0, 0]


def test_construct_array_refuses_what_cannot_go_into_its_type():
    with pytest.raises(UserError, match=r"input input0 \(half\[4\]\) cannot go into normalf\[3\]\[\]; set arrayType"):
        run_node("ConstructArray", inputs={"arrayType": "normalf[3][]", "input0": of("half[4]", [1, 2, 3, 4])})


def test_construct_array_refuses_a_number_beyond_its_type():
    with pytest.raises(ComputeError, match="an input does not fit int; choose a wider arrayType"):
        run_node("ConstructArray", inputs={"arrayType": "int[]", "input0": of("int64", 2**40)})
