"""Sums and means by key, by hand."""

import numpy as np
import pytest

from sensors.compiled import compiled
from sensors.radar.grouping import FEW, Groups, Sums, add

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


@compiled
def add_all(sums, keys, power):
    """Adds each key's power with the values 1, 2, 3 and the power itself."""
    for row in range(len(keys)):
        add(sums, keys[row], power[row], 1.0, 2.0, 3.0, power[row])


def test_powers_and_values_add_up_by_key():
    """Of 7: 1 + 2 + 8, whose mean by power is (1 + 4 + 64) / 11; of 3: 4, which is its own mean."""
    sums = Sums.room(4)
    add_all(sums, np.array([7, 7, 3, 7]), np.array([1.0, 2.0, 4.0, 8.0]))
    keys, power, values = sums.found
    assert keys.tolist() == [7, 3]
    assert power.tolist() == [11, 4]
    assert values.tolist() == [[1, 1], [2, 2], [3, 3], [69 / 11, 4]]


@pytest.mark.parametrize("count", [FEW // 2, FEW, 5 * FEW])
def test_more_keys_than_the_table_begins_with_are_all_found_again(count):
    """Each key comes twice, so each power is twice its own; keys lie 2^32 apart, so that low bits tell nothing."""
    keys = np.arange(count) << 32
    sums = Sums.room(count)
    add_all(sums, np.tile(keys, 2), np.tile(np.arange(count) + 1.0, 2))
    assert sums.found[0].tolist() == keys.tolist()
    assert sums.found[1].tolist() == (2.0 * np.arange(count) + 2).tolist()


def test_several_sums_become_one():
    """Of 7: 1 + 4 = 5; 3 is in the first alone, 9 in the second."""
    one, two = Sums.room(2), Sums.room(2)
    add_all(one, np.array([7, 3]), np.array([1.0, 2.0]))
    add_all(two, np.array([9, 7]), np.array([3.0, 4.0]))
    keys, power, _ = Sums.merged([one, two], 0).found
    assert dict(zip(keys.tolist(), power.tolist(), strict=True)) == {7: 5, 3: 2, 9: 3}
