"""Radar cross sections of canonical targets as the sensor measures them, against closed forms (lambda = 3.9 mm, PEC).

Flat targets are cut into the tubes of rays: an edge is right to half a tube, 1/128 of a target's width. On both sides
that is up to 1.5 % of an area, 3 % of a cross section: 0.13 dB; corners have more edges.
"""

import math

import numpy as np
import pytest

from tests.support.radar_scenes import SCAN, WPM, dbsm, dihedral, plate, radar_world, received, trihedral

FAR = {f"{SCAN}maxRangeM": 250.0}


@pytest.mark.parametrize(("wavelength", "expected"), [(3.9, 19.17), (7.8, 13.15)])
def test_a_plate_is_4_pi_area_squared_over_wavelength_squared(wavelength, expected):
    """At 20 m the near field takes 0.03 dB."""
    sections, ranges, _ = received(plate(0.1, 20.0), {f"{WPM}waveLengthMm": wavelength})
    assert dbsm(sections[0]) == pytest.approx(expected, abs=0.1)
    assert ranges[0] == pytest.approx(20.0, abs=1e-3)


@pytest.mark.parametrize(("tilt", "expected"), [(0.5, 16.09), (1.0, 0.40), (3.0, -0.90)])
def test_the_side_lobes_of_a_plate_are_sinc_squared(tilt, expected):
    """cos^2 x sinc^2(2 a sin / wavelength); 200 m away, so that the near field does not fill the valleys."""
    sections, _, _ = received(plate(0.1, 200.0, tilt), FAR)
    assert dbsm(sections[0]) == pytest.approx(expected, abs=0.2)


@pytest.mark.parametrize(("azimuth", "elevation"), [(2.0, 1.0), (1.71, 3.67), (6.96, 5.05), (2.41, 3.02)])
def test_two_triangles_in_a_plane_are_one_plate_whatever_their_points_are_rounded_to(azimuth, elevation):
    """0.1 m at 60 m, facing the radar: 19.17 dBsm. Points are float32, 4e-6 m there; two halves that added up as
    powers would give 3 dB less."""
    a, e = math.radians(azimuth), math.radians(elevation)
    ahead = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    across = np.array([-math.sin(a), math.cos(a), 0.0])
    up = np.cross(ahead, across)
    corners = [60 * ahead + 0.05 * (i * across + j * up) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh = {"type": "Mesh", "points": [corner.tolist() for corner in corners], "faces": [[0, 1, 2, 3]]}
    sections, *_ = received({"/World/Plate": mesh}, FAR)
    assert dbsm(sections[0]) == pytest.approx(19.17, abs=0.2)


@pytest.mark.parametrize("tiles", [2, 3])
def test_a_plate_of_tiles_returns_what_a_whole_one_does(tiles):
    """Cubes side by side, 0.1 m in all: 19.17 dBsm. Tiles that added up as powers would give 1 / n^2 of it."""
    side = 0.1 / tiles
    prims = {
        f"/World/Tile{i}{j}": {
            "type": "Cube",
            "size": 1.0,
            "scale": [0.01, side, side],
            "translate": [20.005, (i + 0.5) * side - 0.05, (j + 0.5) * side - 0.05],
        }
        for i in range(tiles)
        for j in range(tiles)
    }
    sections, *_ = received(prims)
    assert dbsm(sections[0]) == pytest.approx(19.17, abs=0.15)


def test_a_finely_meshed_plate_is_flat_though_its_points_are_rounded():
    """5,000 triangles of 2 mm at 50 m, where float32 is 4e-6 m: their normals differ by 2 mrad. 19.17 dBsm."""
    places = np.linspace(-0.05, 0.05, 51)
    azimuth, elevation = np.radians([1.7, -4.2])
    ahead = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    across = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.cross(ahead, across)
    points = [(50 * ahead + one * across + two * up).tolist() for one in places for two in places]
    corner = [51 * i + j for i in range(50) for j in range(50)]
    faces = [each for at in corner for each in ([at, at + 51, at + 52], [at, at + 52, at + 1])]
    sections, *_ = received({"/World/Plate": {"type": "Mesh", "points": points, "faces": faces}}, FAR)
    assert dbsm(sections[0]) == pytest.approx(19.17, abs=0.2)


def test_a_square_trihedral_of_three_cubes_returns_12_pi_a4_over_wavelength_squared():
    """23.94 dBsm for a = 0.1 m: the corner's effective aperture is sqrt(3) a^2. Its axis, (1, 1, 1), turned to -x."""
    axis = np.cross([1, 1, 1], [-1, 0, 0]) / math.sqrt(2)
    turn = math.acos(-1 / math.sqrt(3))
    orient = [math.cos(turn / 2), *(math.sin(turn / 2) * axis).tolist()]
    prims = {"/World/Corner": {"type": "Xform", "translate": [30, 0, 0], "orient": orient}}
    for side in range(3):
        scale, place = [0.1] * 3, [0.05] * 3
        scale[side], place[side] = 1e-3, -5e-4
        prims[f"/World/Corner/Side{side}"] = {"type": "Cube", "size": 1.0, "scale": scale, "translate": place}
    sections, ranges, bounces = received(prims)
    assert dbsm(sections[0]) == pytest.approx(23.94, abs=0.3)
    assert (ranges[0], bounces[0]) == (pytest.approx(30.0, abs=2e-3), 3)


@pytest.mark.parametrize("radii", [(0.2, 0.1, 0.3), (0.1, 0.3, 0.2), (0.5, 0.5, 0.2)])
def test_an_ellipsoid_is_pi_b2_c2_over_a2(radii):
    """Along its axis a, by the radii of curvature b^2 / a and c^2 / a there; facets of 1 mm error, 0.2 dB."""
    a, b, c = radii
    ellipsoid = {"type": "Sphere", "radius": 1.0, "scale": [a, b, c], "translate": [40, 0, 0]}
    sections, *_ = received({"/World/Ellipsoid": ellipsoid})
    assert dbsm(sections[0]) == pytest.approx(dbsm(math.pi * (b * c / a) ** 2), abs=0.3)


def test_a_plate_vanishes_between_its_lobes():
    """2 a sin = wavelength at 1.117 deg."""
    sections, _, _ = received(plate(0.1, 200.0, math.degrees(math.asin(3.9e-3 / 0.2))), FAR)
    assert dbsm(sections[0]) < -20


@pytest.mark.parametrize("distance", [10.0, 20.0, 40.0])
def test_a_trihedral_returns_what_three_reflections_do(distance):
    """4 pi a^4 / (3 wavelength^2) = 14.40 dBsm for a = 0.1 m, at every distance."""
    sections, ranges, bounces = received(trihedral(0.1, distance))
    assert dbsm(sections[0]) == pytest.approx(14.40, abs=0.2)
    assert ranges[0] == pytest.approx(distance, abs=2e-3)
    assert bounces[0] == 3


@pytest.mark.parametrize(("turn", "expected"), [(0.0, 22.18), (10.0, 20.36)])
def test_a_dihedral_returns_what_two_reflections_do(turn, expected):
    """(4 pi / wavelength^2) (2 a b sin(45 deg - turn))^2."""
    sections, _, bounces = received(dihedral(0.1, 20.0, turn))
    assert dbsm(sections[0]) == pytest.approx(expected, abs=0.2)
    assert bounces[0] == 2


def test_a_cylinder_from_broadside():
    """2 pi r L^2 / wavelength = 5.08 dBsm; its facets' lobes overlap with a ripple of 0.1 dB, a polygon is smaller than
    its circle by 0.1 dB."""
    cylinder = {"type": "Cylinder", "radius": 0.05, "height": 0.2, "axis": "Z"}
    found = [
        received({"/World/C": {**cylinder, "translate": [40, 0, 0], "rotate": [0, 0, turn]}})[0].sum()
        for turn in (0, 4, 8, 13)
    ]
    assert dbsm(float(np.mean(found))) == pytest.approx(5.08, abs=0.25)


@pytest.mark.parametrize("turn", [0, 4, 8, 11, 15])
@pytest.mark.parametrize("kind", ["Cylinder", "Capsule"])
@pytest.mark.parametrize("radius", [0.004, 0.006, 0.010, 0.016])
def test_a_thin_pole_is_round_however_it_is_turned(radius, kind, turn):
    """2 pi r L^2 / wavelength for L = 0.2 m at 20 m, of which the near field takes 0.27 dB: (C^2 + S^2)(w) / w^2 with
    w = L / sqrt(wavelength x 20 m) = 0.716. Its polygon is smaller by 0.1 to 0.2 dB."""
    pole = {"type": kind, "radius": radius, "height": 0.2, "axis": "Z", "translate": [20 + radius, 0, 0]}
    sections, *_ = received({"/World/Pole": {**pole, "rotate": [0, 0, turn]}})
    assert dbsm(sections.sum()) == pytest.approx(dbsm(2 * math.pi * radius * 0.2**2 / 3.9e-3) - 0.27, abs=0.25)


@pytest.mark.parametrize("radius", [0.006, 0.016])
def test_a_small_ball_is_round_however_it_is_turned(radius):
    """pi r^2; its facets are smaller by up to 0.4 dB."""
    ball = {"type": "Sphere", "radius": radius, "translate": [20 + radius, 0, 0]}
    found = [
        dbsm(received({"/World/Ball": {**ball, "rotate": [0, t, t]}})[0].sum() / (math.pi * radius**2))
        for t in (0, 7, 19)
    ]
    assert found == pytest.approx([0.0] * 3, abs=0.4)


def test_plates_that_are_not_one_face_add_up_as_powers():
    """Two plates side by side, one a quarter wavelength behind: their fields would cancel, 4 pi (A^2 + A^2) /
    wavelength^2 is 3.01 dB more than one of them, 7.13 dBsm for 0.05 m at 20 m. Where in a cell different faces are is
    known to no simulated scene to a fraction of a wavelength, so their phases are taken as random."""
    prims = {}
    for side, back in ((-1, 0.0), (1, 3.9e-3 / 4)):
        [box] = plate(0.05, 20.0 + back).values()
        prims[f"/World/Plate{side + 1}"] = {**box, "translate": [20.00005 + back, side * 0.1, 0]}
    sections, *_ = received(prims)
    assert dbsm(sections[0]) == pytest.approx(7.13 + 3.01, abs=0.3)


@pytest.mark.parametrize(("tilt", "expected"), [(0.2, -1.40), (0.4, -2.85), (0.6, -5.54), (1.0, -19.71), (2.0, -20.18)])
def test_the_side_lobes_of_a_cylinder_are_sinc_squared_of_its_length(tilt, expected):
    """-0.94 dBsm for r = 0.05 m and L = 0.1 m x sinc^2(2 L sin / wavelength); the first null is at 1.117 deg. 80 m
    away, so that the near field does not fill it."""
    cylinder = {"type": "Cylinder", "radius": 0.05, "height": 0.1, "axis": "Z", "rotate": [0, tilt, 0]}
    sections, *_ = received({"/World/C": {**cylinder, "translate": [80, 0, 0]}}, FAR)
    assert dbsm(sections.sum()) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(
    ("radius", "length", "distance", "expected"),
    [
        *((0.05, 0.2, distance, found) for distance, found in ((3, -5.63), (5, 0.78), (10, 4.04), (20, 4.82))),
        *((0.1, 0.3, distance, found) for distance, found in ((3, -1.86), (5, 2.25), (10, 6.12), (20, 10.30))),
    ],
)
def test_a_cylinder_in_the_near_field_follows_its_fresnel_zones(radius, length, distance, expected):
    """2 pi r L^2 / wavelength x (C^2 + S^2)(w) / w^2, the Fresnel integrals at w = L / sqrt(wavelength x distance), x
    distance / (distance + r), by which the circle spreads: w = 1.01 at 10 m for L = 0.2 m, where C = 0.78, S = 0.45."""
    cylinder = {"type": "Cylinder", "radius": radius, "height": length, "axis": "Z"}
    sections, *_ = received({"/World/C": {**cylinder, "translate": [distance + radius, 0, 0]}})
    assert dbsm(sections.sum()) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(("tilt", "expected"), [(0.1, 5.78), (0.3, 5.61), (0.5, 4.74), (0.8, 0.15), (1.2, -5.62)])
def test_a_tilted_cylinder_in_the_near_field_is_the_integral_of_its_phase(tilt, expected):
    """r = 0.1 m, L = 0.3 m at 10 m: 2 pi r L^2 / wavelength x |mean of exp(-j k (z^2 / distance + 2 z sin))|^2 over its
    length x distance / (distance + r); by the trapezoidal rule with 20,000 steps."""
    cylinder = {"type": "Cylinder", "radius": 0.1, "height": 0.3, "axis": "Z", "rotate": [0, tilt, 0]}
    sections, *_ = received({"/World/C": {**cylinder, "translate": [10.1, 0, 0]}})
    assert dbsm(sections.sum()) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(
    ("radius", "length", "tilt", "expected"),
    [(0.1, 0.3, 0, 11.28), (0.1, 0.3, 0.2, 6.90), (0.05, 0.2, 0, 5.01), (0.1, 0.3, 10, -15.03), (0.1, 0.3, 30, -15.03)],
)
def test_a_capsule_is_its_cylinder_from_the_side_and_its_ball_beyond(radius, length, tilt, expected):
    """Both by their closed forms, at 40 m: 2 pi r L^2 / wavelength = 11.61 and 5.09 dBsm, of which the near field takes
    0.33 and 0.08 dB (0.2 deg: the integral of the phase), and pi r^2. The seams to the caps do not bend the strips."""
    capsule = {"type": "Capsule", "radius": radius, "height": length, "axis": "Z", "rotate": [0, tilt, 0]}
    sections, *_ = received({"/World/C": {**capsule, "translate": [40 + radius, 0, 0]}})
    assert dbsm(sections.sum()) == pytest.approx(expected, abs=0.4)


def drawn_out(profile, turns, offset):
    """A mesh around z of rings (radius, height), with corners at `turns`, whose axis is at x = offset."""
    count = len(turns)
    points = [[offset + r * math.cos(turn), r * math.sin(turn), z] for r, z in profile for turn in turns]
    sides = [(k * count, i, (i + 1) % count) for k in range(len(profile) - 1) for i in range(count)]
    faces = [[k + i, k + j, k + count + j, k + count + i] for k, i, j in sides]
    ends = [list(range(count))[::-1], list(range(len(points) - count, len(points)))]
    return {"/World/Turned": {"type": "Mesh", "points": points, "faces": faces + ends}}


@pytest.mark.parametrize("bevel", [0.002, 0.01])
def test_a_cylinder_with_bevelled_ends_is_a_cylinder(bevel):
    """r = 0.05 m, L = 0.2 m at 40 m: 5.09 dBsm, of which the near field takes 0.08 dB; the bevels are turned by 30 deg
    and send nothing back."""
    profile = [(0.05 - bevel / 2, -0.1 - bevel), (0.05, -0.1), (0.05, 0.1), (0.05 - bevel / 2, 0.1 + bevel)]
    turned = drawn_out(profile, 2 * np.pi * np.arange(32) / 32, 40.05)
    assert dbsm(received(turned)[0].sum()) == pytest.approx(5.01, abs=0.2)


@pytest.mark.parametrize("steps", [4, 8])
def test_the_flat_sides_of_a_rounded_bar_are_plates(steps):
    """A square of 0.1 m, rounded by 0.01 m, 0.2 m long: a plate of 0.08 m x 0.2 m, 4 pi area^2 / wavelength^2 = 23.25
    dBsm, of which the near field takes 0.06 dB at 40 m. A cylinder of 0.01 m, as its edges are, has -1.9 dBsm."""
    corners = [(0.04 * i, 0.04 * j) for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    turns = [[math.pi / 2 * (k + step / steps) for step in range(steps + 1)] for k in range(4)]
    ring = [
        (x + 0.01 * math.cos(turn), y + 0.01 * math.sin(turn))
        for (x, y), some in zip(corners, turns, strict=True)
        for turn in some
    ]
    count = len(ring)
    points = [[40.05 + x, y, z] for z in (-0.1, 0.1) for x, y in ring]
    faces = [[i, (i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
    sections, *_ = received({"/World/Bar": {"type": "Mesh", "points": points, "faces": faces}})
    assert dbsm(sections.sum()) == pytest.approx(23.19, abs=0.2)


def test_a_sphere_is_pi_r_squared_from_all_sides():
    """-15.03 dBsm for r = 0.1 m, of which the near field takes (19.9 / 20)^2, 0.04 dB; a polyhedron of 1 mm error is
    smaller than its sphere by up to 1 %, 0.05 dB, and its facets' lobes make a ripple of some tenths of a decibel."""
    sphere = {"type": "Sphere", "radius": 0.1, "translate": [20, 0, 0]}
    turns = np.random.default_rng(3).uniform(-180, 180, (25, 3)).tolist()
    found = np.array([received({"/World/S": {**sphere, "rotate": turn}})[0].sum() for turn in turns])
    assert dbsm(float(found.mean())) == pytest.approx(-15.07, abs=0.1)
    assert np.abs(10 * np.log10(found) + 15.03).max() < 0.35


@pytest.mark.parametrize(("radius", "distance"), [(0.5, 20.0), (0.5642, 100.0), (2.0, 60.0)])
def test_a_sphere_that_few_rays_meet_on_each_facet_is_one_cell_of_pi_r_squared(radius, distance):
    """The image of the radar in the sphere is r / 2 behind its front: pi r^2 (d / (d + r))^2 at a distance d of that.
    It lies across the boresight, the border of two cells of azimuth, and is not shared out between them."""
    sphere = {"type": "Sphere", "radius": radius, "translate": [distance + radius, 0, 0]}
    expected = dbsm(math.pi * (radius * distance / (distance + radius)) ** 2)
    for turn in ([0, 0, 0], [30, 50, 70], [10, 20, 30]):
        sections, *_ = received({"/World/S": {**sphere, "rotate": turn}}, FAR)
        assert dbsm(sections[0]) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(("radius", "distance"), [(0.2, 0.4), (0.2, 0.8), (0.1, 0.9), (0.5, 2.5), (0.2, 1.8)])
def test_a_near_sphere_is_one_detection_of_all_its_power(radius, distance):
    """pi r^2 (d / (d + r))^2 at a distance d of its front: the curvature of its image's wave. Its facets are lit over
    several cells of 1.3 deg, and all of it comes from where the sphere reflects as a mirror: straight ahead."""
    sphere = {"/World/S": {"type": "Sphere", "radius": radius, "translate": [distance + radius, 0, 0]}}
    attributes = {f"{SCAN}rcsTuningCoefficients": [-60.0, 1.0, 0.0], f"{SCAN}cfarMinVal": 1e-30}
    with radar_world(sphere, attributes) as (app, product):
        app.update()
        frame = product.frame
        assert frame.count == 1
        assert abs(float(frame.channel("azimuth")[0])) < 0.1
        expected = math.pi * (radius * distance / (distance + radius)) ** 2
        assert float(frame.channel("scalar")[0]) == pytest.approx(dbsm(expected), abs=0.3)


@pytest.mark.parametrize("ahead", [9.0, 10.3, 12.0])
@pytest.mark.parametrize(("rays", "radius"), [(8.0, 0.1), (20.0, 0.1), (8.0, 0.2)])
def test_a_sphere_in_a_mirror_is_pi_r_squared_however_many_rays_meet_it(ahead, rays, radius):
    """Its image is 6 m beside it: pi r^2 by the mirror twice, and 2 pi r^2 by it once, in both orders. The ways'
    difference, (mean / geometric mean)^4, adds up to 0.1 dB there, and the near field takes up to 0.2 dB."""
    prims = {
        "/World/Mirror": {"type": "Cube", "size": 1.0, "scale": [40.0, 0.01, 10.0], "translate": [6.0, 3.005, 0.0]},
        "/World/S": {"type": "Sphere", "radius": radius, "translate": [ahead, 0.0, 0.0]},
    }
    sections, ranges, bounces = received(prims, {f"{SCAN}maxAzAngDeg": 40.0, f"{SCAN}raysPerDeg": rays})
    image = math.hypot(ahead, 6.0)
    for way, orders in (((ahead + image) / 2 - radius, 2), (image - radius, 1)):
        there = (bounces > 1) & (np.abs(ranges - way) < 0.15)
        assert dbsm(sections[there].sum()) == pytest.approx(dbsm(orders * math.pi * radius**2), abs=0.4)


@pytest.mark.parametrize("corners", [16, 17, 128])
def test_a_cylinder_on_boresight_is_one_cell_however_fine_its_mesh_is(corners):
    """2 pi r L^2 / wavelength = -4.92 dBsm for r = 0.02 m, L = 0.1 m; half of it on each side of the border of two
    cells would be 3 dB less."""
    turns = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack((20 + 0.02 * np.cos(turns), 0.02 * np.sin(turns)), 1)
    points = [[*xy, z] for z in (-0.05, 0.05) for xy in ring.tolist()]
    faces = [[i, (i + 1) % corners, corners + (i + 1) % corners, corners + i] for i in range(corners)]
    sections, *_ = received({"/World/C": {"type": "Mesh", "points": points, "faces": faces}})
    assert dbsm(sections[0]) == pytest.approx(-4.92, abs=0.25)


@pytest.mark.parametrize("tilt", [0.0, 3.0, 8.0, 20.0])
def test_a_sphere_has_no_poles(tilt):
    """Where its facets meet in a point it returns what it does elsewhere."""
    sphere = {"type": "Sphere", "radius": 0.1, "translate": [20, 0, 0], "rotate": [0, 90 - tilt, 0]}
    assert dbsm(received({"/World/S": sphere})[0].sum()) == pytest.approx(-15.03, abs=0.35)


@pytest.mark.parametrize(
    ("radius", "rays", "expected", "error"),
    [(0.02, None, 1.15, 0.05), (0.05, None, 17.01, 0.05), (0.1396, None, 30.99, 0.05), (0.3, 2_000_000, 29.29, 0.1)],
)
def test_a_disc_in_the_near_field_follows_its_fresnel_zones(radius, rays, expected, error):
    """4 pi R^2 sin^2(k a^2 / 2R) at R = 10 m: the sum rises and falls as zones are added. The largest is not small
    enough for finer rays of its own; with 8 per degree its rim is right to 0.2 dB."""
    turn = np.linspace(0, 2 * math.pi, 180, endpoint=False)
    points = [[10.0, radius * math.cos(each), radius * math.sin(each)] for each in turn]
    disc = {"type": "Mesh", "points": points, "faces": [list(range(180))[::-1]]}
    sections, *_ = received({"/World/Disc": disc}, fidelity={"radar.rays": rays} if rays else {})
    assert dbsm(sections[0]) == pytest.approx(expected, abs=error)


@pytest.mark.parametrize("distance", [5.0, 10.0, 20.0])
def test_a_wall_is_a_mirror(distance):
    """pi R^2, the image of the radar; the wall ends after some Fresnel zones, which makes a ripple below 1 dB."""
    sections, ranges, _ = received(plate(8.0, distance))
    assert dbsm(sections[0]) == pytest.approx(dbsm(math.pi * distance**2), abs=1.0)
    assert ranges[0] == pytest.approx(distance, abs=0.01)


def test_concrete_returns_8_dB_less_than_metal():
    """Fresnel at normal incidence on e = 5.24 - j 0.32; its roughness of 0.05 mm takes another 0.11 dB (Ament)."""
    metal = {name: {**keys, "material": "steel"} for name, keys in plate(0.1, 20.0).items()}
    concrete = {name: {**keys, "material": "concrete"} for name, keys in plate(0.1, 20.0).items()}
    (first, *_), (second, *_) = (received(prims)[0] for prims in (metal, concrete))
    assert dbsm(second / first) == pytest.approx(-8.1 - 0.11, abs=0.1)


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e5, 1e6])
def test_far_from_the_origin_a_target_returns_the_same(offset):
    """Float64 keeps 1e-10 m at 1000 km, 3e-7 rad of phase."""
    prims = {"/World/There": {"type": "Xform", "translate": [offset, offset, 0]}}
    (corner,) = trihedral(0.1, 20.0).values()
    prims["/World/There/Corner"] = corner
    sections, ranges, _ = received(prims, translate=[offset, offset, 0])
    assert dbsm(sections[0]) == pytest.approx(14.40, abs=0.2)
    assert ranges[0] == pytest.approx(20.0, abs=2e-3)


def test_a_rough_plate_on_boresight_is_one_detection_of_all_its_power():
    """Lambert: 4 x share x area. A relative permittivity of 4 reflects 1 / 9 at normal incidence, which gravel
    scatters: 4 x 0.01 / 9 m^2, -23.5 dBsm; half of it on each side of the border of two cells would be 3 dB less."""
    gravel = {name: {**keys, "material": "gravel"} for name, keys in plate(0.1, 20.0).items()}
    attributes = {f"{SCAN}rcsTuningCoefficients": [-60.0, 1.0, 0.0], f"{SCAN}cfarMinVal": 1e-30}
    with radar_world(gravel, attributes) as (app, product):
        app.update()
        frame = product.frame
        assert frame.count == 1
        assert float(frame.channel("scalar")[0]) == pytest.approx(-23.5, abs=0.3)
