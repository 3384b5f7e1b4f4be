"""Matrices, quaternions and what lies between two rotations: every case that divides by something small."""

import math
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graph.sim.transforms import (
    apply,
    from_xyzw,
    inverse_rigid,
    pose_matrices,
    quaternion,
    quaternions,
    rigid_part,
    rigid_parts,
    rotation_matrices,
    rotations_and_scales,
    slerp,
    to_xyzw,
)

SINE = math.sin(math.pi / 8)
COSINE = math.cos(math.pi / 8)

HALF = math.sqrt(0.5)
KNOWN = {
    "no turn": ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [1, 0, 0, 0]),
    "90 deg about x": ([[1, 0, 0], [0, 0, -1], [0, 1, 0]], [HALF, HALF, 0, 0]),
    "90 deg about y": ([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [HALF, 0, HALF, 0]),
    "90 deg about z": ([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [HALF, 0, 0, HALF]),
    "-90 deg about z": ([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], [HALF, 0, 0, -HALF]),
    "180 deg about x": ([[1, 0, 0], [0, -1, 0], [0, 0, -1]], [0, 1, 0, 0]),
    "180 deg about y": ([[-1, 0, 0], [0, 1, 0], [0, 0, -1]], [0, 0, 1, 0]),
    "180 deg about z": ([[-1, 0, 0], [0, -1, 0], [0, 0, 1]], [0, 0, 0, 1]),
    "180 deg about x = y": ([[0, 1, 0], [1, 0, 0], [0, 0, -1]], [0, HALF, HALF, 0]),
    "180 deg about y = -z": ([[-1, 0, 0], [0, 0, -1], [0, -1, 0]], [0, 0, HALF, -HALF]),
    "x to y to z to x": ([[0, 0, 1], [1, 0, 0], [0, 1, 0]], [0.5, 0.5, 0.5, 0.5]),
}


@pytest.mark.parametrize(("rotation", "expected"), KNOWN.values(), ids=KNOWN)
def test_a_known_rotation_is_this_quaternion_and_back(rotation, expected):
    rotation = np.array(rotation, np.float64)
    assert quaternion(rotation) == pytest.approx(expected, abs=1e-15)
    assert quaternions(rotation[None])[0].tolist() == quaternion(rotation).tolist()
    assert rotation_matrices(np.array(expected)) == pytest.approx(rotation, abs=1e-15)


unit = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: math.hypot(*q) > 1e-3)


@given(unit)
def test_any_rotation_comes_back_with_w_not_negative_by_both_ways_alike(q):
    q = np.array(q) / math.hypot(*q)
    rotation = rotation_matrices(q)
    one = quaternion(rotation)
    assert one[0] >= 0
    assert abs(one @ q) == pytest.approx(1, abs=1e-14)
    assert quaternions(rotation[None])[0].tolist() == one.tolist()


@pytest.mark.parametrize("angle", [1e-3, 1e-8, 1e-12, 1e-160])
def test_a_tiny_turn_keeps_its_angle(angle):
    """A turn by a small angle about z: q = (1, 0, 0, angle / 2) to float64's last bit."""
    rotation = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    assert quaternion(rotation)[3] == pytest.approx(math.sin(angle / 2), rel=1e-15)


@pytest.mark.parametrize("short_of", [1e-3, 1e-8, 1e-12])
def test_a_turn_just_short_of_half_a_turn_keeps_what_is_missing(short_of):
    """By pi - short_of about y: w = sin(short_of / 2), which the trace, near -1, no longer has."""
    cos, sin = -math.cos(short_of), math.sin(short_of)
    rotation = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    assert quaternion(rotation)[0] == pytest.approx(math.sin(short_of / 2), rel=1e-14)


@pytest.mark.parametrize("shape", [(), (0,), (1,), (5,), (2, 3)])
def test_batches_of_any_shape_are_their_rows(shape):
    random = np.random.default_rng(3)
    q = random.normal(size=(*shape, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    rotations = rotation_matrices(q)
    found = quaternions(rotations)
    assert found.shape == q.shape
    assert found.dtype == np.float64
    for row in np.ndindex(*shape):
        assert found[row].tolist() == quaternion(rotations[row]).tolist()
    assert from_xyzw(to_xyzw(q)).tolist() == q.tolist()


def test_orders_of_components():
    assert to_xyzw(np.array([[1.0, 2, 3, 4]])).tolist() == [[2, 3, 4, 1]]
    assert from_xyzw(np.array([1.0, 2, 3, 4])).tolist() == [4, 1, 2, 3]


def test_matrices_of_single_precision_are_worked_out_in_double():
    rotation = np.array(KNOWN["180 deg about x = y"][0], np.float32)
    assert quaternions(rotation).dtype == np.float64
    assert quaternions(rotation) == pytest.approx([0, HALF, HALF, 0], abs=1e-15)


def test_half_way_between_no_turn_and_90_degrees_is_45_degrees():
    middle = slerp(np.array([1.0, 0, 0, 0]), np.array([HALF, 0, 0, HALF]), 0.5)
    assert middle == pytest.approx([COSINE, 0, 0, SINE], abs=1e-15)


def test_the_shorter_way_is_taken_whatever_the_sign():
    first, second = np.array([1.0, 0, 0, 0]), np.array([HALF, 0, 0, HALF])
    assert slerp(first, -second, 0.5) == pytest.approx(slerp(first, second, 0.5), abs=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-7, 1e-5, 0.5, 3.0, math.pi])
def test_shares_of_a_turn_about_z_are_turns_by_that_share(angle):
    """Up to half a turn, where the quaternions are at right angles; below 1e-6 the line replaces the arc."""
    shares = np.array([0.0, 0.25, 0.5, 1.0])
    end = np.array([math.cos(angle / 2), 0, 0, math.sin(angle / 2)])
    found = slerp(np.tile([1.0, 0, 0, 0], (4, 1)), np.tile(end, (4, 1)), shares)
    assert 2 * np.arctan2(found[:, 3], found[:, 0]) == pytest.approx(shares * angle, rel=1e-12, abs=1e-15)


def test_slerp_of_batches_is_that_of_their_rows():
    random = np.random.default_rng(4)
    first, second = random.normal(size=(2, 2, 3, 4))
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second /= np.linalg.norm(second, axis=-1, keepdims=True)
    shares = random.random((2, 3))
    found = slerp(first, second, shares)
    for row in np.ndindex(2, 3):
        assert found[row] == pytest.approx(slerp(first[row], second[row], shares[row]), abs=1e-15)
    assert np.linalg.norm(found, axis=-1) == pytest.approx(np.ones((2, 3)), abs=1e-15)


def test_a_mirrored_matrix_has_a_negative_x_scale_and_a_flat_axis_counts_as_1():
    turn = np.array(KNOWN["90 deg about z"][0], np.float64)
    matrices = np.zeros((3, 4, 4))
    for matrix, scale in zip(matrices, ([2, 3, 4], [-2, 3, 4], [2, 0, 4]), strict=True):
        matrix[:3, :3] = turn * scale
    rotations, scales = rotations_and_scales(matrices)
    assert scales.tolist() == [[2, 3, 4], [-2, 3, 4], [2, 0, 4]]
    assert rotations[0] == pytest.approx(turn)
    assert rotations[1] == pytest.approx(turn)
    assert rotations[2] == pytest.approx(turn * [1, 0, 1])


def test_the_rigid_part_and_its_inverse_of_a_scaled_pose():
    pose = pose_matrices(np.array([1.0, 2, 3]), np.array([HALF, 0, 0, HALF]))
    scaled = pose @ np.diag([2.0, 3, 4, 1])
    assert rigid_part(scaled) == pytest.approx(pose, abs=1e-15)
    assert inverse_rigid(pose) @ pose == pytest.approx(np.eye(4), abs=1e-15)


@pytest.mark.parametrize("side", [0, 1, 2])
@pytest.mark.parametrize("mirrored", [0, 1, 2])
def test_a_reflection_turns_round_the_side_axis_and_leaves_the_others_where_they_point(side, mirrored):
    pose = pose_matrices(np.array([1.0, 2, 3]), np.array([0.6, 0, 0.8, 0]))
    scale = np.array([2.0, 2, 2, 1])
    scale[mirrored] = -2.0
    axes = pose @ np.diag(scale)
    found = rigid_part(axes, side)
    assert np.linalg.det(found[:3, :3]) == pytest.approx(1)
    others = [axis for axis in range(3) if axis != side]
    assert found[:3, others] == pytest.approx(axes[:3, others] / 2)
    assert found[:3, side] == pytest.approx(-axes[:3, side] / 2)
    assert found[:3, 3].tolist() == [1, 2, 3]
    assert rigid_parts(axes[None])[0] == pytest.approx(rigid_part(axes))


@pytest.mark.parametrize("shape", [(5, 3), (2, 4, 3), (0, 3)])
def test_a_matrix_times_vectors_along_either_axis(shape):
    matrix = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 4.0]])
    vectors = np.arange(np.prod(shape), dtype=float).reshape(shape)
    expected = vectors @ matrix.T  # whole numbers: exact in any order
    assert np.array_equal(apply(matrix, vectors), expected)
    assert np.array_equal(apply(matrix, np.moveaxis(vectors, -1, 0), axis=0), np.moveaxis(expected, -1, 0))


def test_a_matrix_times_many_vectors_takes_no_other_thread():
    vectors, matrix = np.ones((200_000, 3)), np.eye(3)
    everywhere, here = time.process_time(), time.thread_time()
    for _ in range(20):
        apply(matrix, vectors)
    assert time.process_time() - everywhere < 1.2 * (time.thread_time() - here)


def test_vectors_of_single_precision_stay_so():
    assert apply(np.eye(3, dtype=np.float32), np.ones((2, 3), np.float32)).dtype == np.float32


def test_one_vector_is_turned_as_many_are():
    assert apply(np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([2.0, 3.0])).tolist() == [-3.0, 2.0]
