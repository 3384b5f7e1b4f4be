"""What four neighbouring rays of a fan tell of the places between them."""

import math

import numpy as np
import pytest

from sensors.radar.setting import Faces
from sensors.radar.sight import HIDDEN, NO_STEPS, SEEN, UNKNOWN, Sights, Steps, looks

STEPS = Steps(across=3, up=3, left=-0.3, wide=0.2, lowest=-0.3, tall=0.2)
"""Rays at -0.2, 0 and 0.2 rad, across and up."""

WALL, PART, SCREEN, BALL = range(4)
"""Planes: two triangles of one wall 10 m ahead, a screen 5 m ahead, and a face of a curved surface 5 m ahead."""


def seen(plane, face, out, azimuth=0.1, steps=STEPS):
    """What a fan whose rays all meet `plane`, or each its own, tells of a place at an elevation of 0.1 rad."""
    count = 4
    normal, distance = np.tile([1.0, 0.0, 0.0], (count, 1)), np.array([10.0, 10.0, 5.0, 5.0])
    numbers, curved = np.zeros(count, np.int32), np.arange(count) == BALL
    none, still = np.zeros((1, 3)), np.zeros(count, np.int64)
    faces = Faces(normal, distance, numbers, numbers, curved, still, np.eye(3)[None], none, none, none, count)
    sights = Sights(steps, np.broadcast_to(np.asarray(plane, np.int32), 9).copy(), np.array([WALL, WALL, SCREEN, BALL]))
    back = math.cos(0.1) * math.cos(azimuth), math.cos(0.1) * math.sin(azimuth), math.sin(0.1)
    return looks(sights, faces, face, back, out)


@pytest.mark.parametrize("around", [WALL, [WALL, PART, WALL] * 3])
def test_a_place_on_the_flat_patch_that_all_four_meet_is_seen(around):
    assert seen(around, PART, 10.0) == SEEN


def test_a_place_behind_the_patch_that_all_four_meet_is_hidden():
    """The screen is 5 m / (cos 0.1)^2 = 5.05 m away in this direction."""
    assert seen(SCREEN, WALL, 10.0) == HIDDEN
    assert seen(SCREEN, WALL, 5.06) == HIDDEN


def test_a_place_before_the_patch_that_all_four_meet_is_not_known():
    """The rays passed what stands there: it is narrower than their steps."""
    assert seen(WALL, SCREEN, 5.0) == UNKNOWN
    assert seen(SCREEN, WALL, 5.05) == UNKNOWN


@pytest.mark.parametrize(
    "around", [[WALL] * 5 + [SCREEN] * 4, [-1] * 9, [WALL, WALL, -1] * 3, BALL], ids=["edge", "sky", "one", "curved"]
)
def test_rays_that_do_not_agree_on_one_flat_patch_tell_nothing(around):
    assert seen(around, WALL, 10.0) == UNKNOWN


def test_beside_the_fan_and_without_one_nothing_is_known():
    assert seen(WALL, WALL, 10.0, azimuth=0.25) == UNKNOWN
    assert seen(WALL, WALL, 10.0, steps=NO_STEPS) == UNKNOWN
