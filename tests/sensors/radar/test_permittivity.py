"""Reflection at 76.9 GHz (3.9 mm), against the figures of ITU-R P.2040-3 worked out by its formulas."""

import numpy as np
import pytest

from sensors.radar.materials import MEDIA, Medium, fresnel, reflection

WAVELENGTH = 3.9e-3


def decibels(coefficient):
    return 20 * np.log10(np.abs(coefficient))


@pytest.mark.parametrize(
    ("name", "lossy", "expected"),
    [
        ("concrete", 0.32, -8.1),
        ("wood", 0.12, -15.3),
        ("plasterboard", 0.12, -12.2),
        ("chipboard", 0.15, -12.6),
        ("floorboard", 0.36, -10.0),
        ("metal", None, -0.01),
    ],
)
def test_normal_incidence(name, lossy, expected):
    medium = MEDIA[name]
    smooth = Medium(medium.a, medium.c, medium.d)
    if lossy is not None:
        assert smooth.permittivity(WAVELENGTH) == pytest.approx(complex(medium.a, -lossy), abs=0.006)
    assert decibels(reflection(smooth, np.array(1.0), WAVELENGTH)) == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize(("millimetres", "expected"), [(3, -9.2), (4, -8.5), (5, -5.1), (6, -6.6)])
def test_a_pane_of_glass_reflects_at_both_faces(millimetres, expected):
    glass = Medium(6.31, 0.0036, 1.3394, thickness=millimetres * 1e-3)
    assert decibels(reflection(glass, np.array(1.0), WAVELENGTH)) == pytest.approx(expected, abs=0.1)


def test_concrete_at_60_degrees():
    te, tm = fresnel(MEDIA["concrete"].permittivity(WAVELENGTH), np.array(0.5))
    assert decibels(te) == pytest.approx(-4.2, abs=0.06)
    assert decibels(tm) == pytest.approx(-19.4, abs=0.2)


@pytest.mark.parametrize(("height", "expected"), [(0.1e-3, -0.45), (0.3e-3, -4.1), (0.5e-3, -11.3)])
def test_roughness_takes_coherent_power(height, expected):
    """exp(-(2 k h)^2): 4.343 (2 k h)^2 dB."""
    rough, smooth = (Medium(1.0, 1e7, 0.0, roughness=h) for h in (height, 0.0))
    lost = decibels(reflection(rough, np.array(1.0), WAVELENGTH)) - decibels(
        reflection(smooth, np.array(1.0), WAVELENGTH)
    )
    assert lost == pytest.approx(expected, abs=0.06)
