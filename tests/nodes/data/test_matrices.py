"""Matrices and transformations: row vectors, the translation in the last row."""

import math

import numpy as np
import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from tests.support.typed_values import of, outcome

HALF = math.sqrt(0.5)
QUARTER_TURN = of("quatd[4]", [0, 0, HALF, HALF])
"""90 degrees about z: x becomes y."""


def placed(**inputs):
    return run_node("MakeTransform", inputs=inputs).value("transform")


SWAP = of("matrixd[2]", [[0, 1], [1, 0]])
M = of("matrixd[2]", [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("a", "b", "product", "type_name"),
    [
        (M, SWAP, [[2, 1], [4, 3]], "matrixd[2]"),
        (SWAP, M, [[3, 4], [1, 2]], "matrixd[2]"),
        (of("double[2]", [1, 2]), M, [7, 10], "double[2]"),
        (M, of("float[2]", [1, 10]), [21, 43], "float[2]"),
        (of("float[2]", [1, 2]), of("double[2]", [3, 4]), 11, "double"),
        (of("double[2][]", [[1, 2], [3, 4]]), SWAP, [[2, 1], [4, 3]], "double[2][]"),
        (of("matrixd[2][]", [M["value"], SWAP["value"]]), SWAP, [[[2, 1], [4, 3]], [[1, 0], [0, 1]]], "matrixd[2][]"),
        (of("double[2][]", [[1, 2], [3, 4]]), of("double[2]", [1, 1]), [3, 7], "double[]"),
    ],
)
def test_a_product_is_matrix_vector_or_number(a, b, product, type_name):
    value, name = outcome("MatrixMultiply", "output", a=a, b=b)
    assert np.array_equal(value, product)
    assert name == type_name


def test_factors_of_two_sizes_have_no_product():
    with pytest.raises(UserError, match="differ in size"):
        outcome("MatrixMultiply", "output", a=M, b=of("double[3]", [1, 2, 3]))


def test_a_matrix_without_an_inverse_gives_the_largest_float():
    both = of("matrixd[2][]", [[[2, 0], [0, 4]], [[1, 1], [1, 1]]])
    value, _ = outcome("OgnInvertMatrix", "invertedMatrix", matrix=both)
    assert np.array_equal(value, [[[0.5, 0], [0, 0.25]], np.eye(2) * np.finfo(np.float32).max])


def test_transposing_turns_rows_into_columns():
    assert outcome("Transpose", "result", matrix=M)[0].tolist() == [[1, 3], [2, 4]]


def test_matrices_come_apart_into_rows_and_together_again():
    matrix = placed(rotationXYZ=[10, 20, 30], translation=[5, 6, 7])
    trace = run_node("BreakMatrix4", inputs={"matrix": of("matrixd[4]", matrix.tolist()), "outputType": "double[3]"})
    rows = {axis: of("double[3]", trace.value(axis).tolist()) for axis in "xyzw"}
    assert rows["w"]["value"] == [5, 6, 7]
    assert np.array_equal(outcome("MakeMatrix4", "matrix", **rows)[0], matrix)
    whole = run_node("BreakMatrix4", inputs={"matrix": of("matrixd[4]", matrix.tolist())})
    assert whole.value("w").tolist() == [5, 6, 7, 1]
    for size in (2, 3):
        square = np.arange(size * size, dtype=float).reshape(size, size)
        apart = run_node(f"BreakMatrix{size}", inputs={"matrix": of(f"matrixd[{size}]", square.tolist())})
        parts = {axis: of(f"double[{size}]", apart.value(axis).tolist()) for axis in "xyz"[:size]}
        assert np.array_equal(outcome(f"MakeMatrix{size}", "matrix", **parts)[0], square)


def test_arrays_of_rows_make_an_array_of_matrices():
    value, name = outcome("MakeMatrix2", "matrix", x=of("double[2][]", [[1, 2], [3, 4]]), y=of("double[2]", [5, 6]))
    assert value.tolist() == [[[1, 2], [5, 6]], [[3, 4], [5, 6]]]
    assert name == "matrixd[2][]"


def test_a_transformation_scales_then_turns_about_x_first_then_moves():
    """By hand: the x axis, untouched by the turn about x, goes to (cos 30, sin 30, 0), ten times as long."""
    matrix = placed(rotationXYZ=[20, 0, 30], translation=[1, -2, 3], scale=[10, 5, 1])
    c, s = math.cos(math.radians(30)), 0.5
    c20, s20 = math.cos(math.radians(20)), math.sin(math.radians(20))
    rows = [[10 * c, 10 * s, 0], [-5 * s * c20, 5 * c * c20, 5 * s20], [s * s20, -c * s20, c20], [1, -2, 3]]
    assert np.allclose(matrix[:, :3], rows, atol=1e-12)
    assert matrix[:, 3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_angles_go_into_a_transformation_and_come_out_again(order):
    matrix = of("matrixd[4]", placed(rotationXYZ=[20, 40, -30], rotationOrder=order, scale=[2, 3, 4]).tolist())
    assert np.allclose(outcome("GetMatrix4Rotation", "rotation", matrix=matrix, rotationOrder=order)[0], [20, 40, -30])
    assert np.allclose(outcome("GetMatrix4Scale", "scale", matrix=matrix)[0], [2, 3, 4])


def test_something_that_looks_at_a_point_has_it_along_minus_z():
    matrix = run_node("MakeTransformLookAt", inputs={"eye": [0, -5, 0], "center": [0, 0, 0], "up": [0, 0, 1]})
    assert np.array_equal(matrix.value("transform"), [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, -5, 0, 1]])
    with pytest.raises(ComputeError, match="one point, or up points along the look"):
        run_node("MakeTransformLookAt", inputs={"up": [1, 0, 0]})


GIVEN = of("matrixd[4]", [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0], [5, 6, 7, 1]])
TURNED = [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [5, 6, 7, 1]]


@pytest.mark.parametrize(
    ("kind", "inputs", "matrix"),
    [
        ("SetMatrix4Rotation", {"rotationAngle": of("double", 90), "fixedRotationAxis": "Z"}, TURNED),
        (
            "SetMatrix4Rotation",
            {"rotationAngle": of("double", 90), "fixedRotationAxis": "Custom", "rotationAxis": [0, 0, 5]},
            TURNED,
        ),
        ("SetMatrix4Rotation", {"rotationAngle": of("vectord[3]", [0, 0, 90])}, TURNED),
        ("SetMatrix4Rotation", {"rotationAngle": QUARTER_TURN}, TURNED),
        ("SetMatrix4Rotation", {"rotationAngle": of("matrixd[3]", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])}, TURNED),
        ("SetMatrix4Quaternion", {"quaternion": QUARTER_TURN}, TURNED),
        (
            "SetMatrix4Translation",
            {"translation": of("vectord[3]", [1, 1, 1])},
            [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0], [1, 1, 1, 1]],
        ),
        (
            "SetMatrix4Scale",
            {"scale": of("vectord[3]", [1, 1, 9])},
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 9, 0], [5, 6, 7, 1]],
        ),
    ],
)
def test_one_part_of_a_transformation_is_changed(kind, inputs, matrix):
    value, name = outcome(kind, "matrix", matrix=GIVEN, **inputs)
    assert np.allclose(value, matrix, atol=1e-12)
    assert name == "matrixd[4]"


def test_parts_of_an_array_of_transformations_are_changed_one_by_one():
    two = of("matrixd[4][]", [GIVEN["value"], GIVEN["value"]])
    value, _ = outcome(
        "SetMatrix4Translation", "matrix", matrix=two, translation=of("vectord[3][]", [[1, 1, 1], [2, 2, 2]])
    )
    assert value[:, 3, :3].tolist() == [[1, 1, 1], [2, 2, 2]]
    with pytest.raises(ComputeError, match="has 3 elements"):
        outcome("SetMatrix4Translation", "matrix", matrix=two, translation=of("vectord[3][]", [[1, 1, 1]] * 3))


@pytest.mark.parametrize(
    ("rotation", "turned"),
    [
        (QUARTER_TURN, [0, 1, 0]),
        (of("quatf[4]", [0, 0, 1, 1]), [0, 1, 0]),
        (of("vectord[3]", [0, 0, 90]), [0, 1, 0]),
        (of("matrixd[3]", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), [0, 1, 0]),
        (of("matrixd[4]", [[0, 2, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [9, 9, 9, 1]]), [0, 2, 0]),
    ],
)
def test_a_vector_is_turned_by_every_form_of_a_rotation(rotation, turned):
    assert np.allclose(
        outcome("RotateVector", "result", rotation=rotation, vector=of("vectord[3]", [1, 0, 0]))[0], turned
    )


def test_one_rotation_turns_an_array_of_vectors():
    vectors = of("vectorf[3][]", [[1, 0, 0], [0, 1, 0]])
    value, name = outcome("RotateVector", "result", rotation=QUARTER_TURN, vector=vectors)
    assert np.allclose(value, [[0, 1, 0], [-1, 0, 0]], atol=1e-7)
    assert name == "vectorf[3][]"


def test_a_point_is_sent_through_a_transformation():
    point = of("vectord[3]", [1, 2, 3])
    assert outcome("TransformVector", "result", matrix=GIVEN, vector=point)[0].tolist() == [7, 12, 19]
    linear = of("matrixd[3]", [[2, 0, 0], [0, 3, 0], [0, 0, 4]])
    assert outcome("TransformVector", "result", matrix=linear, vector=point)[0].tolist() == [2, 6, 12]
