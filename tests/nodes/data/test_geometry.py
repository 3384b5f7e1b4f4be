import numpy as np
import pytest

from graph import ComputeError, UserError
from graph.testing import run_node
from tests.support.typed_values import of, outcome


@pytest.mark.parametrize(
    ("value", "length", "name"),
    [
        (of("double", -2.5), 2.5, "double"),
        (of("double[3]", [2, 3, 6]), 7, "double"),
        (of("vectorf[3]", [2, 3, 6]), 7, "float"),
        (of("int[2]", [3, 4]), 5, "double"),
        (of("double[]", [-1, 2]), [1, 2], "double[]"),
        (of("double[2][]", [[3, 4], [6, 8]]), [5, 10], "double[]"),
    ],
)
def test_the_magnitude_is_the_length(value, length, name):
    found, found_name = outcome("Magnitude", "magnitude", input=value)
    assert np.array_equal(found, length)
    assert found_name == name


def test_a_matrix_has_no_length():
    with pytest.raises(UserError, match=r"input input \(matrixd\[2\]\) is a matrix, which has no length"):
        run_node("Magnitude", inputs={"input": of("matrixd[2]", [[1, 0], [0, 1]])})


def test_dot_products():
    one, other = of("double[3]", [1, 2, 3]), of("double[3]", [4, 5, 6])
    assert outcome("DotProduct", "product", a=one, b=other) == (32, "double")
    assert outcome("DotProduct", "product", a=of("double[]", [1, 2]), b=of("double[]", [3, 4])) == (11, "double")
    rows, name = outcome("DotProduct", "product", a=of("int[2][]", [[1, 2], [3, 4]]), b=of("int[2]", [1, 10]))
    assert (rows.tolist(), name) == ([21, 43], "int[]")
    with pytest.raises(UserError, match=r"input a \(double\[3\]\) and input b \(double\) have no dot product"):
        outcome("DotProduct", "product", a=of("double[3]", [1, 2, 3]), b=of("double", 2))
    with pytest.raises(UserError, match=r"input a \(double\[3\]\) and input b \(double\[2\]\) have no dot product"):
        outcome("DotProduct", "product", a=of("double[3]", [1, 2, 3]), b=of("double[2]", [1, 2]))


def test_cross_products_follow_the_right_hand():
    value, name = outcome("CrossProduct", "product", a=of("vectord[3]", [1, 0, 0]), b=of("vectord[3]", [0, 1, 0]))
    assert (value.tolist(), name) == ([0, 0, 1], "vectord[3]")


def test_normalized_vectors_have_length_one_unless_they_had_none():
    value, name = outcome("Normalize", "result", vector=of("double[2][]", [[3, 4], [0, 0]]))
    assert (value.tolist(), name) == ([[0.6, 0.8], [0, 0]], "double[2][]")


@pytest.mark.parametrize("size", [2, 3, 4])
def test_vectors_are_taken_apart_and_put_together(size):
    parts = {axis: of("double", index + 0.5) for index, axis in enumerate("xyzw"[:size])}
    whole, name = outcome(f"MakeVector{size}", "tuple", **parts)
    assert (whole.tolist(), name) == ([0.5, 1.5, 2.5, 3.5][:size], f"double[{size}]")
    trace = run_node(f"BreakVector{size}", inputs={"tuple": of(name, whole.tolist())})
    assert [trace.value(axis) for axis in "xyzw"[:size]] == whole.tolist()


def test_a_vector_of_another_size_is_refused():
    with pytest.raises(UserError, match=r"input tuple \(double\[3\]\) must have 4 components; use BreakVector3"):
        run_node("BreakVector4", inputs={"tuple": of("double[3]", [1, 2, 3])})


QUARTER_ABOUT_Z = [[0, 2, 0, 0], [-2, 0, 0, 0], [0, 0, 2, 0], [7, 8, 9, 1]]
"""Row vectors: x goes to y, twice as long, moved to (7, 8, 9)."""


def test_a_matrix_gives_its_translation_and_rotation():
    matrix = of("matrixd[4]", QUARTER_ABOUT_Z)
    assert outcome("GetMatrix4Translation", "translation", matrix=matrix)[0].tolist() == [7, 8, 9]
    quaternion, name = outcome("GetMatrix4Quaternion", "quaternion", matrix=matrix)
    assert (quaternion, name) == (pytest.approx([0, 0, 0.5**0.5, 0.5**0.5]), "quatd[4]")
    assert outcome("GetMatrix4Rotation", "rotation", matrix=matrix)[0] == pytest.approx([0, 0, 90])


def test_an_array_of_matrices_gives_an_array():
    matrices = of("matrixd[4][]", [QUARTER_ABOUT_Z, np.eye(4).tolist()])
    translations, name = outcome("GetMatrix4Translation", "translation", matrix=matrices)
    assert (translations.tolist(), name) == ([[7, 8, 9], [0, 0, 0]], "vectord[3][]")
    assert outcome("GetMatrix4Rotation", "rotation", matrix=matrices)[0].tolist() == pytest.approx(
        np.array([[0, 0, 90], [0, 0, 0]])
    )


def _turn(axis, degrees):
    """Column-vector rotation about one axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    a, b = [(1, 2), (2, 0), (0, 1)]["XYZ".index(axis)]
    matrix = np.eye(3)
    matrix[[a, b], [a, b]] = c
    matrix[a, b], matrix[b, a] = -s, s
    return matrix


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
@pytest.mark.parametrize("angles", [(10.0, 20.0, 30.0), (-100.0, 40.0, 170.0), (25.0, 90.0, 0.0), (25.0, -90.0, 0.0)])
def test_rotation_angles_turn_in_the_given_order(order, angles):
    first, second, third = (_turn(axis, angle) for axis, angle in zip(order, angles, strict=True))
    matrix = of("matrixd[3]", (third @ second @ first).T.tolist())
    found, _ = outcome("GetMatrix4Rotation", "rotation", matrix=matrix, rotationOrder=order)
    assert [found["XYZ".index(axis)] for axis in order] == pytest.approx(angles)


def test_arrays_of_components_need_one_length():
    with pytest.raises(ComputeError, match="the arrays have 1 and 2 elements; they need one length"):
        run_node("MakeVector2", inputs={"x": of("double[]", [1]), "y": of("double[]", [1, 2])})


@pytest.mark.parametrize(
    ("a", "b", "distance", "type_name"),
    [
        (("pointd[3]", [0, 3, 0]), ("pointf[3]", [4, 0, 0]), 5, "double"),
        (("pointf[3][]", [[0, 3, 0], [1, 0, 0]]), ("pointf[3]", [4, 0, 0]), [5, 3], "float[]"),
        (("pointd[3][]", [[0, 0, 0], [1, 0, 0]]), ("pointd[3][]", [[0, 0, 2], [1, 1, 0]]), [2, 1], "double[]"),
    ],
)
def test_a_distance_is_a_number_for_each_pair_of_points(a, b, distance, type_name):
    inputs = {name: {"type": kind, "value": value} for name, (kind, value) in (("a", a), ("b", b))}
    trace = run_node("Distance3D", inputs=inputs)
    assert np.allclose(trace.value("distance"), distance)
    assert trace.node.types["outputs:distance"].name == type_name
