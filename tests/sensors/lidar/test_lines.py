"""Lines of lidars: what messages number as rings, from 0 upwards by elevation."""

from fractions import Fraction

import numpy as np
import pytest

from graph.base.errors import UserError
from sensors.configs.catalog import assets
from sensors.lidar.config import EmitterState, LidarConfig
from sensors.lidar.lines import lines_of
from sensors.lidar.pattern import firing_pattern
from tests.support.lidar_worlds import add_box, add_lidar, frames_of, rotary, weightless

# Of the makers' data sheets; 1 for the many lidars of one plane.
LINES = {
    **{"XT32": 32, "Example_Rotary": 32, "Example_Solid_State": 3, "Simple_Example_Solid_State": 3, "VLS128": 128},
    **{"OS0": 128, "OS1": 32, "OS2": 128, "MRS1000": 4, "multiScan100": 16, "ML30S": 160, "MLXS": 180},
}


@pytest.mark.parametrize("asset", assets(), ids=lambda asset: asset.short_name)
def test_the_rings_of_every_configuration_count_its_lines_from_the_lowest_up(asset):
    for config in {
        variant.number_of_emitters: variant for variant in map(asset.config, asset.variants or (None,))
    }.values():
        lines = lines_of(config)
        [heights] = [state.elevation_deg.astype(float) for state in config.emitter_states]
        means = [heights[lines.ring[0] == number].mean() for number in range(lines.count)]
        assert np.all(np.diff(means) >= -1e-6)
        # Every emitter has its own place in its line.
        assert len(np.unique(lines.ring[0] * lines.longest + lines.place[0])) == config.number_of_emitters


@pytest.mark.parametrize("asset", assets(), ids=lambda asset: asset.short_name)
def test_every_configuration_has_the_lines_of_its_data_sheet(asset):
    assert lines_of(asset.config()).count == LINES.get(asset.short_name, 1)


def test_the_rings_of_a_frame_are_those_of_its_elevations():
    """Emitters at 5, -5 and 0 deg: rings 2, 0 and 1."""
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        lidar = add_lidar(
            app, config=rotary(4, elevations=(5.0, -5.0, 0.0)), channels={"ring", "column", "elevation", "tickId"}
        )
        [frame] = frames_of(app, lidar, 6)
    assert frame.channel("ring").dtype == np.uint16
    expected = np.select([frame.channel("elevation") > 1, frame.channel("elevation") < -1], [2, 0], 1)
    np.testing.assert_array_equal(frame.channel("ring"), expected)
    np.testing.assert_array_equal(frame.channel("column"), frame.channel("tickId"))


def solid_state(elevations, azimuths=None, **fields):
    states = tuple(
        EmitterState(np.zeros(len(each)) if azimuths is None else azimuths, each) for each in np.atleast_2d(elevations)
    )
    rates = {"scan_rate_base_hz": Fraction(10), "pattern_firing_rate_hz": Fraction(10)}
    return LidarConfig(scan_type="SOLID_STATE", emitter_states=states, **rates, **fields)


def test_declared_lines_are_ordered_by_their_mean_elevation_also_equal_ones_and_aslant():
    """Lines of three rays with means 2, -1 and 2 deg."""
    config = solid_state([1, 2, 3, -2, -1, 0, 3, 2, 1], np.arange(9.0), num_rays_per_line=(3, 3, 3), num_lines=3)
    lines = lines_of(config)
    assert lines.ring.tolist() == [[1, 1, 1, 0, 0, 0, 2, 2, 2]]
    assert lines.place.tolist() == [[0, 1, 2] * 3]


def test_emitter_states_share_the_lines_of_equal_elevation():
    lines = lines_of(solid_state([[0, 2], [1, 2 + 1e-6]]))
    assert lines.ring.tolist() == [[0, 2], [1, 2]]
    assert (lines.count, lines.longest) == (3, 1)


def test_more_lines_than_a_ring_field_holds_are_refused():
    config = solid_state(np.linspace(-60, 60, 65_537).astype(np.float64))
    with pytest.raises(UserError, match="65,537 elevations, more than a ring field"):
        firing_pattern(config).ring  # noqa: B018
    assert firing_pattern(solid_state(np.linspace(-70, 70, 65_536))).ring.max() == 65_535
