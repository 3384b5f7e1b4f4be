"""Arrays of antennas in the mode WAVEFORM: beams, how narrow they are, and what they see beyond their limit."""

import math

import numpy as np
import pytest

from graph.base.errors import UserError
from sensors.radar.aperture import Aperture
from tests.support.radar_scenes import SCAN, WPM, radar_world

WAVES = {
    **{f"{WPM}cfarMode": "4D", f"{SCAN}datacubeMode": "WAVEFORM", f"{SCAN}maxAzAngDeg": 70.0, f"{SCAN}raysPerDeg": 4.0},
    f"{SCAN}rcsTuningCoefficients": (-60.0, 1.0, 0.0),
}


def plates(*azimuths):
    """Plates of 0.1 m, 20.2 m away (the middle of a cell), that face the radar."""
    prims = {}
    for number, azimuth in enumerate(azimuths):
        turn = math.radians(azimuth)
        box = {"type": "Cube", "size": 1.0, "scale": [1e-4, 0.1, 0.1], "rotate": [0, 0, azimuth]}
        prims[f"/World/P{number}"] = {**box, "translate": [20.2 * math.cos(turn), 20.2 * math.sin(turn), 0]}
    return prims


def detected(prims, **scan):
    """(azimuths [deg], cross sections [dBsm]) of what a frame holds."""
    with radar_world(prims, {**WAVES, **{f"{SCAN}{name}": value for name, value in scan.items()}}) as (app, product):
        app.update()
        return product.frame.channel("azimuth"), product.frame.channel("scalar")


@pytest.mark.parametrize(("elements", "wide"), [(8, 12.8), (12, 8.49), (78, 1.30)])
def test_a_beam_is_1_772_over_the_number_of_elements_wide(elements, wide):
    """Half the power at half of 1.772 / N rad from boresight, for half a wavelength from element to element."""
    beams = math.sin(math.radians(wide / 2)) * elements * 0.5
    assert Aperture(elements).response(np.array([beams])) == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(
    ("window", "half", "one", "two"),
    [("NONE", 0.4105, 0.0, 0.0), ("HANN", 0.7201, 0.25, 0.0), ("HAMMING", 0.6688, 0.1814, 0.0)],
)
def test_windows_widen_beams(window, half, one, two):
    """Of 8 elements: sin(pi / 2) / (8 sin(pi / 16)) = 0.6407 half a beam away, and sin(3 pi / 2) / (8 sin(3 pi / 16)) =
    -0.2250 at one and a half. A window adds c times the neighbours: 0.5 for Hann, 0.46 / 1.08 for Hamming; half a beam
    away (0.6407 + c (0.6407 - 0.2250))^2 and one beam away c^2."""
    found = Aperture(8, window=window).response(np.array([0.0, 0.5, 1.0, 2.0]))
    assert found == pytest.approx([1.0, half, one, two], abs=2e-4)


@pytest.mark.parametrize("mode", ["2D", "4D"])
@pytest.mark.parametrize(("azimuth", "beam"), [(0.0, 0.0), (13.0, 14.478), (45.0, 48.590), (70.0, 90.0)])
def test_beams_are_equal_in_the_sine(mode, azimuth, beam):
    """8 elements: beams at sines of 0, 1/4, 1/2, 3/4 and 1."""
    with radar_world(
        plates(azimuth),
        {**WAVES, f"{WPM}cfarMode": mode, f"{SCAN}arrayAzimuthElements": 8, f"{SCAN}detValFromBinIdx": True},
    ) as (app, product):
        app.update()
        assert product.frame.channel("azimuth") == pytest.approx([beam], abs=0.01)
        assert product.frame.facts["maxAzRad"] == pytest.approx(math.pi / 2)


def test_between_beams_a_target_loses_what_the_response_says_unless_it_is_refined():
    """19.14 dBsm less 3.87 dB half way between two beams (u = 1/8), 10 log10 0.4105; with as many zeros, a beam lies
    there. Refined, the value is the target's, not the beam's."""
    (_, between), (_, padded) = (
        detected(plates(7.181), arrayAzimuthElements=8, azimuthPaddingSamples=more, detValFromBinIdx=True)
        for more in (0, 8)
    )
    _, refined = detected(plates(7.181), arrayAzimuthElements=8)
    assert refined == pytest.approx([19.14], abs=0.15)
    assert between == pytest.approx([19.14 - 3.87], abs=0.15)
    assert padded == pytest.approx([19.14], abs=0.15)


@pytest.mark.parametrize(("elements", "count"), [(8, 1), (16, 1), (64, 2)])
def test_two_targets_are_two_if_a_beam_lies_between(elements, count):
    """0.1 apart in u: beams are 0.22, 0.11 and 0.028 wide."""
    apart = math.degrees(math.asin(0.05))
    found, _ = detected(plates(apart, -apart), arrayAzimuthElements=elements, azimuthPaddingSamples=elements)
    assert len(found) == count


def test_beyond_the_limit_of_an_array_angles_come_in_again():
    """A wavelength from element to element: to sines of 0.5. sin 45 deg - 1 = -0.2929, -17.03 deg."""
    array = {"arrayAzimuthElements": 8, "azimuthElementSpacing": 1.0}
    assert detected(plates(45.0), **array, enAngAliasing=True)[0] == pytest.approx([-17.03], abs=0.02)
    assert len(detected(plates(45.0), **array)[0]) == 0


def test_an_array_has_the_names_of_both_versions_of_the_schema():
    array = {"apertureArrayAzimuthElements": 8, "apertureAzimuthElementSpacing": 1.0, "enAngAliasing": True}
    assert detected(plates(45.0), **array)[0] == pytest.approx([-17.03], abs=0.02)


@pytest.mark.parametrize(
    ("scan", "message"),
    [
        ({"azimuthElementSpacing": 0.00195}, "azimuthElementSpacing = 0.00195; it is in wavelengths, such as 0.5"),
        ({"apertureWindowAzimuth": "FOO"}, "apertureWindowAzimuth = 'FOO' is not one of NONE, RECTANGULAR, HANN"),
        ({"apertureArrayAzimuthElements": 4}, "is 8 and apertureArrayAzimuthElements is 4; give one of them"),
        ({"elevationPaddingSamples": 4}, "elevationPaddingSamples needs arrayElevationElements"),
        ({"azimuthPaddingSamples": 200_000}, "200,008 azimuth and 1 elevation cells; at most 100,000"),
    ],
)
def test_what_no_array_can_have_is_refused_in_a_line(scan, message):
    with pytest.raises(UserError, match=message) as refused:
        detected({}, arrayAzimuthElements=8, **scan)
    assert "\n" not in str(refused.value)
