"""The parameters of chirps: cells, ambiguity, and where ranges and velocities are seen; c = 299,792,458 m/s."""

import numpy as np
import pytest

from graph.base.errors import UserError
from tests.support.radar_scenes import SCAN, WPM, plate, radar_world

LIGHT = 299_792_458.0
BALL = {"type": "Sphere", "radius": 0.3, "rigid_body": True}


def chirps(**values):
    """Attributes of a scan of sampled chirps that detects the ball in more than 20 m."""
    scan = {"rcsTuningCoefficients": [-60.0, 1.0, 0.0], "cfarMinVal": 1e-30, "cfarOffset": 0.1, "velResMps": 0.05}
    return {f"{WPM}datacubeMode": "WAVEFORM", **{f"{SCAN}{name}": value for name, value in {**scan, **values}.items()}}


def strongest(prims, attributes, steps=1):
    """Range and velocity of the strongest detection, and the facts of its frame."""
    with radar_world(prims, attributes) as (app, product):
        app.update(steps=steps)
        frame = product.frame
        at = int(np.argmax(frame.channel("scalar")))
        return float(frame.channel("distance")[at]), float(frame.channel("rv_ms")[at]), frame.facts


def grid(attributes):
    with radar_world({}, attributes) as (_, product):
        scan = product.sensor.config.scans[0]
        return scan.ranges(), scan.cycles


def test_a_bandwidth_makes_range_cells_of_c_over_twice_it():
    """600 MHz: 0.2498 m, 201 of them to 50 m."""
    ranges, cycles = grid(chirps(chirpBandwidth=6e8))
    assert ranges.width == pytest.approx(LIGHT / 12e8)
    assert ranges.count == 201
    assert cycles == (50.0, 55.0)


def test_samples_end_the_ranges_and_padding_makes_the_cells_finer():
    """128 samples at 600 MHz reach 31.98 m; as many zeros after them halve the cells."""
    ranges, _ = grid(chirps(chirpBandwidth=6e8, fastTimeSamples=128, fastTimePaddingSamples=128))
    assert ranges.high == pytest.approx(128 * LIGHT / 12e8)
    assert (ranges.count, ranges.width) == (256, pytest.approx(LIGHT / 24e8))


def test_the_repetition_time_limits_velocities_instead_of_the_sequence():
    """Wavelength / 4P: 3.9 mm and 50 us give 19.5 m/s; a ball of 30 m/s is seen at -9."""
    ball = {"/World/Ball": {**BALL, "translate": [20, 0, 0], "velocity": [30.0, 0, 0]}}
    _, velocity, facts = strongest(ball, chirps(chirpRepetitionTime=5e-5))
    assert facts["maxVelMps"] == pytest.approx(19.5)
    assert velocity == pytest.approx(30.0 - 39.0, abs=0.03)


def test_the_carrier_decides_the_wavelength():
    """38.5 GHz is half of 77: velocities up to twice as many m/s by the same chirps."""
    _, slow = grid(chirps(carrierFrequency=77e9, chirpRepetitionTime=5e-5))
    _, fast = grid(chirps(carrierFrequency=38.5e9, chirpRepetitionTime=5e-5))
    assert slow[0] == pytest.approx(LIGHT / (4 * 77e9 * 5e-5))
    assert fast[0] == pytest.approx(2 * slow[0])


def test_what_recedes_seems_farther_by_the_carrier_times_the_duration_over_the_bandwidth():
    """20 m/s, 76.87 GHz, 50 us, 150 MHz: 20 x 76.87e9 x 5e-5 / 1.5e8 = 0.5125 m."""
    ball = {"/World/Ball": {**BALL, "translate": [20, 0, 0], "velocity": [20.0, 0, 0]}}
    own = {"chirpBandwidth": 1.5e8, "chirpRepetitionTime": 4e-5}
    there, _, _ = strongest(ball, chirps(**own))
    seen, _, _ = strongest(ball, chirps(**own, chirpDuration=4e-5))
    assert seen - there == pytest.approx(20 * LIGHT / 3.9e-3 * 4e-5 / 1.5e8, abs=0.01)


def test_a_step_from_chirp_to_chirp_makes_the_far_seem_fast():
    """A plate in 20 m, steps of 1 MHz, 50 us: 20 x 1e6 / (76.87e9 x 5e-5) = 5.203 m/s."""
    own = {"chirpRepetitionTime": 5e-5, "frequencyStepBetweenChirps": 1e6}
    _, velocity, _ = strongest(plate(0.2, 20.0), chirps(**own))
    assert velocity == pytest.approx(20 * 1e6 * 3.9e-3 / (LIGHT * 5e-5), abs=0.03)


@pytest.mark.parametrize("folds", [True, False])
def test_ranges_beyond_the_samples_come_in_again_only_where_they_are_to(folds):
    """64 samples at 600 MHz end at 15.99 m: 20 m are seen at 4.01."""
    attributes = chirps(chirpBandwidth=6e8, fastTimeSamples=64, enableRangeAliasing=folds)
    with radar_world(plate(0.2, 20.0), attributes) as (app, product):
        app.update()
        seen = product.frame.channel("distance").tolist()
    assert seen == (pytest.approx([20.0 - 64 * LIGHT / 12e8], abs=0.01) if folds else [])


def test_padding_keeps_one_target_one_detection_where_it_is():
    attributes = chirps(chirpBandwidth=6e8, fastTimeSamples=128, fastTimePaddingSamples=384)
    with radar_world(plate(0.2, 20.33), attributes) as (app, product):
        app.update()
        assert product.frame.channel("distance").tolist() == [pytest.approx(20.33, abs=5e-3)]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"chirpDuration": 1e-3}, "chirpDuration = 0.001 s is longer than from chirp to chirp, 1.77e-05 s"),
        ({"fastTimePaddingSamples": 8}, "fastTimePaddingSamples needs fastTimeSamples"),
        ({"carrierFrequency": 77.0}, "carrierFrequency = 77; give 3e8 to 3e13 Hz"),
        ({"chirpBandwidth": -1.0}, "chirpBandwidth is negative"),
        ({"chirpBandwidth": 1e-30}, "chirpBandwidth = 1e-30; give 1 Hz up to the carrier's 7.68699e"),
        ({"frequencyStepBetweenChirps": -1e30}, r"frequencyStepBetweenChirps = -1e\+30 is more than the carrier"),
    ],
)
def test_chirps_that_cannot_be_are_refused_in_a_line(values, message):
    with pytest.raises(UserError, match=message), radar_world({}, chirps(**values)):
        pass
