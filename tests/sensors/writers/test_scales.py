"""Scales of pictures: what spans them, and where their labels stand."""

import numpy as np
import pytest
from PIL import Image

from sensors.writers.palette import indices, spread, widened
from sensors.writers.scale import TEXT, draw_labels


def test_equal_numbers_get_the_middle_of_the_scale_and_rounding_errors_are_no_pattern() -> None:
    flat = np.full((40, 40), 2.5)
    flat[::2] -= 5e-7  # what float32 leaves of a plane at 2.5 m
    low, high = spread(flat)
    assert high - low == pytest.approx(0.02 * 2.5)  # LEAST_SPAN of the larger end
    assert set(indices(flat, low, high).ravel()) == {128}  # 1 + 254 / 2


def test_zeros_have_a_scale_of_one_about_them() -> None:
    assert widened(0.0, 0.0) == (-0.5, 0.5)


def test_a_scale_that_is_wide_enough_keeps_its_ends() -> None:
    assert widened(1.0, 3.0) == (1.0, 3.0)


@pytest.mark.parametrize("middle", [(2.0, 150.0), (298.0, 150.0), (150.0, 2.0), (150.0, 298.0)])
def test_labels_of_rings_stand_whole_within_the_picture(middle: tuple[float, float]) -> None:
    image = Image.new("RGB", (300, 300))
    draw_labels(image, middle, 90.0)  # rings each metre
    lit = np.argwhere(np.asarray(image).max(axis=2) >= min(TEXT))
    assert len(lit)
    assert lit.min() >= 1
    assert lit.max() <= 298
