"""Sums and means by key, by hand."""

import numpy as np
import pytest

from sensors.radar.grouping import Groups

KEYS = np.array([7, 7, 3, 3, 3, 7])


def test_keys_are_brought_together_across_runs():
    groups = Groups(KEYS)
    assert groups.keys.tolist() == [7, 3]
    assert groups.which.tolist() == [0, 0, 1, 1, 1, 0]


def test_means_count_each_value_by_its_weight():
    """Of 3: (1 x 2 + 2 x 4 + 1 x 6) / 4 = 4; of 7: (1 x 1 + 1 x 3 + 3 x 7) / 5 = 5."""
    weight = np.array([1, 1, 1, 2, 1, 3], np.float32)
    values = np.array([1, 3, 2, 4, 6, 7], np.float32)
    total, means = Groups(KEYS).means([values, -values, 2 * values, np.full(6, np.float32(0.5))], weight)
    assert total.tolist() == [5, 4]
    assert means.tolist() == [[5, 4], [-5, -4], [10, 8], [0.5, 0.5]]


@pytest.mark.parametrize("dtype", [np.complex64, np.complex128])
def test_fields_that_cancel_leave_what_is_left(dtype):
    """1e8 - 1e8 + 1 is 0 or 1 in single precision, and 1 in double."""
    field = np.array([0, 0, 1e8 + 2j, 1, -1e8, 1j], dtype)
    assert Groups(KEYS).sums(field).tolist() == [1j, 1 + 2j]


def test_no_keys_have_no_sums():
    groups = Groups(np.zeros(0, np.int64))
    total, means = groups.means([np.zeros(0, np.float32)] * 4, np.zeros(0, np.float32))
    assert (len(groups), total.tolist(), means.shape) == (0, [], (4, 0))
