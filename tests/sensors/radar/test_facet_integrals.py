"""Cross sections of canonical targets, against their closed forms (perfect conductors, wavelength 3.9 mm)."""

import itertools

import numpy as np
import pytest

from tests.support.facet_integrals import backscatter, phase_integral, refined
from tests.support.radar_scenes import received

WAVELENGTH = 3.9e-3


def dbsm(field):
    return 10 * np.log10(abs(np.sum(field)) ** 2)


def plate(a, b, tilt_deg=0.0, pieces=1):
    """Two triangles (times pieces^2) around the origin whose normal is +x, turned about y."""
    edge_y, edge_z = np.linspace(-a / 2, a / 2, pieces + 1), np.linspace(-b / 2, b / 2, pieces + 1)
    corners = []
    for y0, y1 in itertools.pairwise(edge_y):
        for z0, z1 in itertools.pairwise(edge_z):
            square = [(0, y0, z0), (0, y1, z0), (0, y1, z1), (0, y0, z1)]
            corners += [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
    tilt = np.radians(tilt_deg)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    return np.array(corners) @ turn.T


def far(distance):
    return np.array([distance, 0.0, 0.0])


@pytest.mark.parametrize(("wavelength", "expected"), [(3.9e-3, 19.17), (7.8e-3, 13.15)])
def test_a_plate_falls_with_the_square_of_the_wavelength(wavelength, expected):
    """4 pi A^2 / wavelength^2."""
    assert dbsm(backscatter(plate(0.1, 0.1), far(1e4), wavelength)) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize(("tilt", "expected"), [(0.5, 16.09), (1.0, 0.40), (3.0, -0.90)])
def test_the_side_lobes_of_a_plate_are_sinc_squared(tilt, expected):
    """cos^2 x sinc^2(2 a sin / wavelength) of the plate at normal incidence."""
    assert dbsm(backscatter(plate(0.1, 0.1, tilt), far(1e4), WAVELENGTH)) == pytest.approx(expected, abs=0.1)


def test_a_plate_vanishes_at_its_null():
    """2 a sin = wavelength: 1.117 degrees."""
    tilt = np.degrees(np.arcsin(WAVELENGTH / 0.2))
    assert dbsm(backscatter(plate(0.1, 0.1, tilt), far(1e4), WAVELENGTH)) < -30


def test_pieces_of_a_plate_sum_to_the_plate():
    whole = np.sum(backscatter(plate(0.1, 0.1, 2.0), far(1e5), WAVELENGTH))
    parts = np.sum(backscatter(plate(0.1, 0.1, 2.0, pieces=7), far(1e5), WAVELENGTH))
    assert abs(parts - whole) < 2e-3 * abs(whole)


def test_the_back_of_a_facet_gives_nothing():
    assert dbsm(backscatter(plate(0.1, 0.1)[:, ::-1], far(100.0), WAVELENGTH) + 1e-30) < -500


def test_the_edge_sum_equals_a_fine_quadrature():
    """Midpoint rule on 400^2 / 2 pieces of one triangle; its error is of second order, 1e-4 relative here."""
    triangle = np.array([[[0.0, 0.01, 0.002], [0.0, -0.008, 0.011], [0.003, 0.001, -0.012]]])
    wave = np.array([[300.0, 450.0, -200.0]])
    count = 400
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    uv = []
    for offset in (1 / 3, 2 / 3):
        keep = i + j + (offset > 0.5) < count
        uv.append(np.stack(((i + offset)[keep], (j + offset)[keep]), 1) / count)
    points = np.concatenate(uv)
    a, b, c = triangle[0] - triangle[0].mean(axis=0)
    positions = a + points[:, :1] * (b - a) + points[:, 1:] * (c - a)
    area = np.linalg.norm(np.cross(b - a, c - a)) / 2
    normal = np.cross(b - a, c - a) / (2 * area)
    tangential = wave[0] - wave[0] @ normal * normal
    expected = area * np.exp(1j * positions @ tangential).mean()
    assert abs(phase_integral(triangle, wave)[0] - expected) < 1e-4 * abs(expected)


@pytest.mark.parametrize(("radius", "expected"), [(0.02, 1.15), (0.05, 17.01), (0.1396, 30.99), (0.3, 29.29)])
def test_a_disc_in_the_near_field_follows_its_fresnel_zones(radius, expected):
    """4 pi R^2 sin^2(k a^2 / 2R) at R = 10 m: the sum rises and falls as zones are added."""
    angles = np.linspace(0, 2 * np.pi, 361)
    rim = np.stack((np.zeros(361), radius * np.cos(angles), radius * np.sin(angles)), 1)
    fan = np.stack((np.zeros((360, 3)), rim[:-1], rim[1:]), 1)
    pieces, origin = refined(fan, far(10.0), WAVELENGTH)
    assert set(origin) == set(range(360))
    assert dbsm(backscatter(pieces, far(10.0), WAVELENGTH)) == pytest.approx(expected, abs=0.1)


def test_a_wall_is_a_mirror():
    """pi R^2 = 24.97 dBsm at 10 m, from the first Fresnel zones; the rim of 6 m adds a ripple below 1 dB."""
    pieces, _ = refined(plate(3.0, 3.0), far(10.0), WAVELENGTH)
    assert dbsm(backscatter(pieces, far(10.0), WAVELENGTH)) == pytest.approx(24.97, abs=1.0)


def test_a_cylinder_from_broadside():
    """2 pi r L^2 / wavelength = 5.08 dBsm for r 0.05, L 0.2; facets of 0.25 mm arc."""
    count = 1256
    angles = np.linspace(-np.pi / 2, np.pi / 2, count // 2 + 1)
    rim = 0.05 * np.stack((np.cos(angles), np.sin(angles)), 1)
    low = np.c_[rim, np.full(len(rim), -0.1)]
    high = np.c_[rim, np.full(len(rim), 0.1)]
    facets = np.concatenate((np.stack((low[:-1], low[1:], high[1:]), 1), np.stack((low[:-1], high[1:], high[:-1]), 1)))
    assert dbsm(backscatter(facets, far(1e4), WAVELENGTH)) == pytest.approx(5.08, abs=0.2)


def test_refined_pieces_cover_their_triangle():
    triangle = np.array([[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]])
    pieces, _ = refined(triangle, far(5.0), WAVELENGTH)
    areas = np.linalg.norm(np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(1.0)
    assert np.all(np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0])[:, 0] > 0)


@pytest.mark.parametrize(("tilt", "distance"), [(0.3, 10.0), (0.8, 15.0), (1.4, 30.0), (2.2, 20.0), (5.0, 12.0)])
def test_the_radar_gives_what_the_exact_sum_over_near_facets_does(tilt, distance):
    """The radar cuts a plate of 0.15 m into the tubes of its rays; facets are split until they are far. A side lobe is
    some percent of the main lobe, so a cut of 1/100 of the plate shows more there: 0.5 dB."""
    facets = plate(0.15, 0.15, tilt)
    radar = far(distance)
    pieces, _ = refined(facets, radar, WAVELENGTH)
    expected = dbsm(backscatter(pieces, radar, WAVELENGTH))
    box = {"type": "Cube", "size": 1.0, "scale": [1e-3, 0.15, 0.15], "translate": [distance + 5e-4, 0, 0]}
    sections, _, _ = received({"/World/Plate": {**box, "rotate": [0, tilt, 0]}})
    assert 10 * np.log10(sections[0]) == pytest.approx(expected, abs=0.5)
