"""Antenna tables: gains [dB] over azimuth and elevation, of the sending and the receiving side."""

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim import App
from sensors import Radar
from sensors.radar.antenna import Antenna, Pattern
from tests.support.radar_scenes import RADAR, SCAN, WPM, dbsm, plate, radar_world, received, trihedral


def table(side, azimuth, elevation, gain):
    names = (f"{SCAN}{side}Antenna{each}" for each in ("AzDeg", "ElDeg", "CoGain"))
    return dict(zip(names, (azimuth, elevation, gain), strict=True))


def aside(azimuth):
    """A plate 20 m away that faces the radar."""
    turn = np.radians(azimuth)
    (box,) = plate(0.1, 20.0).values()
    place = [20.00005 * np.cos(turn), 20.00005 * np.sin(turn), 0]
    return {"/World/Plate": {**box, "translate": place, "rotate": [0, 0, azimuth]}}


def test_a_power_from_where_a_falling_antenna_hears_nothing_is_no_target_of_any_size():
    """A false alarm of an array's outermost beam, 90 deg off; cos 80 deg = 0.1736, squared for both ways."""
    turn = np.radians([0.0, 80.0, 90.0])
    directions = np.stack((np.cos(turn), np.sin(turn), np.zeros(3)))
    ahead, aside, rim = Antenna(3.9e-3).cross_section(np.ones(3), np.full(3, 20.0), directions)
    assert aside / ahead == pytest.approx(1 / 0.1736**2, rel=1e-3)
    assert rim / ahead == pytest.approx(1e4)


def test_both_gains_multiply_what_is_received():
    """10 dB out and 5 dB back on a target of 14.40 dBsm, by three reflections."""
    tables = table("tx", [-20, 20], [-10, 10], [10] * 4) | table("rx", [0], [0], [5])
    sections, *_ = received(trihedral(0.1, 20.0), tables)
    assert dbsm(sections[0]) == pytest.approx(14.40 + 15.0, abs=0.2)


def test_a_cross_section_is_that_of_the_target_whatever_the_gains():
    tables = table("tx", [-20, 20], [-10, 10], [12] * 4) | {f"{SCAN}rcsTuningCoefficients": [-60.0, 1.0, 0.0]}
    with radar_world(trihedral(0.1, 20.0), tables) as (app, product):
        app.update()
        assert product.frame.channel("scalar").max() == pytest.approx(14.40, abs=0.2)


@pytest.mark.parametrize(("azimuth", "loss"), [(0.0, 0.0), (5.0, 5.0), (-10.0, 10.0)])
def test_decibels_are_interpolated_between_angles(azimuth, loss):
    """0 dB ahead, -20 dB at 20 deg on both sides: 1 dB a degree; ahead, the plate's halves of 0.14 deg take 0.07 dB."""
    tables = table("rx", [-20, 0, 20], [-10, 10], [-20, -20, 0, 0, -20, -20])
    with_table, without = (received(aside(azimuth), each)[0][0] for each in (tables, {}))
    assert dbsm(with_table / without) == pytest.approx(-loss, abs=0.1)


def test_a_table_of_pairs_is_that_of_its_grid():
    """The same gains, listed pair by pair and in another order."""
    grid = Pattern.of_table([0, 10], [-5, 5], [1, 2, 3, 4])
    pairs = Pattern.of_table([10, 0, 10, 0], [5, -5, -5, 5], [4, 1, 3, 2])
    assert np.array_equal(grid.gain, pairs.gain)
    assert np.array_equal(grid.gain, [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (([0, 10], [0], [1, 2, 3]), "rxAntennaCoGain: 3 gains at 2 azimuths and 1 elevations"),
        (([0, 10], [0, 5], []), "rxAntennaCoGain: 0 gains at 2 azimuths and 2 elevations"),
        (([0, 0, 1, 1], [0, 0, 1, 1], [1, 2, 3, 4]), "a pair of angles comes twice and another is missing"),
    ],
)
def test_a_table_that_makes_no_grid_is_reported_in_a_line(values, message):
    with pytest.raises(UserError, match=message), radar_world({}, table("rx", *values)):
        pass


def test_a_scan_may_have_a_mode_of_its_own():
    """Under a Hann window a plate at 20.1 m, between two cells of 0.4 m, is one peak, and power lies in more cells."""
    for mode, beside in (("FAST", False), ("WAVEFORM", True)):
        attributes = {f"{SCAN}datacubeMode": mode, f"{SCAN}rcsTuningCoefficients": [-300.0, 1.0, 0.0]}
        attributes |= {f"{SCAN}cfarMinVal": 1e-30, f"{SCAN}detValFromBinIdx": True}
        with radar_world(plate(0.1, 20.1), attributes) as (app, product):
            app.update()
            assert product.frame.count == 1
            strongest = float(product.frame.channel("scalar")[0])
        if not beside:
            whole = strongest
    assert strongest < whole - 0.1


def test_attributes_that_are_not_modelled_are_named_in_one_warning():
    """Chirps count in the mode WAVEFORM only; 0 samples say nothing."""
    attributes = {f"{SCAN}chirpBandwidth": 1e9, f"{SCAN}enableRangeAliasing": True, f"{SCAN}fastTimeSamples": 0}
    attributes |= {f"{SCAN}rxAntennaCrossGain": [1.0], f"{SCAN}exponentialDecayFactor": 1.0}
    with radar_world({}, attributes) as (app, _):
        (one,) = [each for each in app.warnings if each.code == "radar-attribute-ignored"]
    assert one.where == RADAR
    assert one.message.startswith(
        "scan:s001:chirpBandwidth, scan:s001:enableRangeAliasing, scan:s001:rxAntennaCrossGain: "
    )


def test_a_radar_is_of_its_own_model():
    with App(None) as app:
        prim = Radar("/World/Radar", attributes={f"{WPM}auxOutputType": "BASIC"}, app=app).prim
        assert prim.GetAttribute("omni:sensor:modelName").Get() == "RadarWPMDMAT"
        assert prim.GetAttribute(f"{WPM}auxOutputType").Get() == "BASIC"
