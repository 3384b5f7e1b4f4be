"""Fields add up within a group and a cell's size, by hand."""

import numpy as np

from sensors.radar.interference import added
from sensors.radar.scattering import Arrivals

WIDTHS = (0.4, 0.1, 0.02, 0.02)


def arrivals(ranges, groups):
    """Fields of 1 straight ahead; their Fresnel zones are smaller than a cell."""
    count, one = len(ranges), np.ones(len(ranges), np.float32)
    return Arrivals(
        np.stack((np.array(ranges), *np.zeros((3, count)))).astype(np.float32),
        one,
        field=one.astype(np.complex64),
        group=np.array(groups, np.uint64),
        zone=np.zeros(count, np.float32),
    )


def test_fields_of_a_group_within_a_cell_add_up_before_they_are_squared():
    power, values = added(arrivals([10.0, 10.1], [5, 5]), WIDTHS)
    assert power.tolist() == [4.0]
    assert values[:, 0].tolist() == np.float32([10.05, 0, 0, 0]).tolist()


def test_fields_of_two_groups_never_add_up():
    """The first group's lie a cell before and a cell behind its middle, the other's in its own middle."""
    power, values = added(arrivals([10.0, 10.8, 50.0], [5, 5, 9]), WIDTHS)
    assert power.tolist() == [1.0, 1.0, 1.0]
    assert sorted(values[0].tolist()) == np.float32([10.0, 10.8, 50.0]).tolist()
