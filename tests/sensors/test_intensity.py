"""Intensity and detection against the range equation, worked out by hand."""

import numpy as np
import pytest

from graph.sim.scene.nonvisual import BASES, COATINGS
from sensors.surfaces.material_codes import encode
from sensors.surfaces.optics import REFLECTANCE, RETRO_GAIN, optics_of, reflectance_of
from tests.support.lidar_worlds import add_box, add_lidar, bind, frames_of, rotary, stare, weightless

AHEAD = [0.0]


def scan_of_wall(distance, material=("none",), azimuths=AHEAD, updates=6, **fields):
    """The frames of a lidar whose beams go to the azimuths [deg], before a wall `distance` metres ahead."""
    fields = {"far_range_m": 1000.0, **fields}
    with weightless() as app:
        wall = add_box(app, "/World/Wall", 400.0, (distance + 200, 0, 0))
        bind(app, wall, *material)
        product = add_lidar(app, config=stare(np.zeros(len(azimuths)), np.array(azimuths), **fields))
        return frames_of(app, product, updates)


def scalar(*args, **kwargs):
    return scan_of_wall(*args, **kwargs)[0].channel("scalar").astype(np.float64)


@pytest.mark.parametrize("distance", [2.0, 20.0, 90.0])
@pytest.mark.parametrize(
    ("base", "reflectance"), [("asphalt", 0.17), ("concrete", 0.24), ("snow", 0.85), ("none", 0.5)]
)
def test_normalised_intensity_is_the_reflectance_at_any_range(distance, base, reflectance):
    assert scalar(distance, (base,)) == pytest.approx(reflectance, abs=1e-6)


def test_intensity_falls_with_the_cosine_of_incidence():
    angles = [0.0, 30.0, 60.0, 75.0]

    np.testing.assert_allclose(scalar(10.0, ("snow",), angles), 0.85 * np.cos(np.deg2rad(angles)), atol=1e-6)


def test_without_normalisation_intensity_falls_with_the_square_of_the_range():
    found = [scalar(distance, ("snow",), intensity_processing="RAW", near_range_m=0.5)[0] for distance in (2.0, 4.0)]

    np.testing.assert_allclose(found, [0.85 * (0.5 / 2) ** 2, 0.85 * (0.5 / 4) ** 2], rtol=1e-6)


@pytest.mark.parametrize(
    ("base", "farthest"), [("none", 10 * np.sqrt(5.0)), ("asphalt", 10 * np.sqrt(1.7)), ("paper", 30.0)]
)
def test_a_wall_is_seen_up_to_where_its_return_is_as_weak_as_the_least_one(base, farthest):
    """minReflectance 0.1 is just seen at 10 m: reflectance p at 10 sqrt(p / 0.1) m."""
    least = {"min_reflectance": 0.1, "min_reflection_range_m": 10.0}

    seen, unseen = (scan_of_wall(farthest + step, (base,), **least)[0] for step in (-0.01, 0.01))

    assert seen.channel("flags").tolist() == [64]
    assert unseen.channel("flags").tolist() == [0]
    assert unseen.channel("distance").tolist() == [0.0]
    assert unseen.channel("scalar").tolist() == [0.0]


def test_incidence_weakens_a_return_and_dropped_ones_leave_no_element():
    # p cos(a) / R^2 with R = 10 / cos(a): seen while cos(a)^3 >= 0.1 * (10 / 15)^2 / 0.5, so up to 63.6 deg.
    limit = np.rad2deg(np.arccos(np.cbrt(0.1 * (10 / 15) ** 2 / 0.5)))
    angles = [0.0, limit - 0.1, limit + 0.1, 80.0]

    [frame] = scan_of_wall(
        10.0,
        azimuths=angles,
        min_reflectance=0.1,
        min_reflection_range_m=15.0,
        skip_dropping_invalid_points=False,
    )

    assert frame.channel("emitterId").tolist() == [0, 1]
    assert frame.count == len(frame.xyz) == len(frame.channel("hitNormals")) == 2


def test_a_retro_reflector_saturates_and_is_seen_from_far_at_any_angle():
    retro = ("aluminum", "none", "retroreflective")
    least = {"min_reflectance": 0.1, "min_reflection_range_m": 10.0}
    farthest = 10 * np.sqrt(RETRO_GAIN / 0.1)  # 886 m

    assert scalar(farthest - 1, retro, **least) == pytest.approx(1.0)
    assert scalar(farthest + 1, retro, **least) == pytest.approx(0.0)
    assert scalar(20.0, retro, [0.0, 60.0], **least).tolist() == [1.0, 1.0]


def test_the_intensity_of_a_wall_at_rest_never_changes_by_a_bit():
    frames = scan_of_wall(10.0, ("brick",), np.linspace(-60, 60, 200), updates=60)

    assert len(frames) == 10
    assert len({frame.channel("scalar").tobytes() for frame in frames}) == 1


def test_tables_map_intensity_linearly_between_their_entries_and_the_scale_comes_last():
    tables = {"intensity_mapping_encoding": (0.0, 0.8, 1.0), "intensity_mapping_decoding": (0.0, 0.5, 0.6)}

    def mapped(kind, **more):
        return scalar(10.0, ("concrete",), intensity_mapping_type=kind, **tables, **more)[0]

    encoded = 0.24 / 0.5 * 0.8  # 0.384
    assert mapped("LINEAR") == pytest.approx(0.24)
    assert mapped("NONLINEAR_ENCODING_ONLY") == pytest.approx(encoded, abs=1e-6)
    assert mapped("NONLINEAR_DECODING_ONLY") == pytest.approx(0.24 / 0.5 * 0.5, abs=1e-6)
    assert mapped("NONLINEAR") == pytest.approx(encoded / 0.5 * 0.5, abs=1e-6)
    assert mapped("NONLINEAR_ENCODING_ONLY", intensity_scale_percent=51.0) == pytest.approx(encoded / 5, abs=1e-6)


def test_each_surface_has_the_reflectance_of_its_material_where_they_differ():
    with weightless() as app:
        for base, x, y in (("asphalt", 10, 0), ("snow", 0, -10), ("brick", -10, 0)):
            bind(app, add_box(app, f"/World/{base}", 2.0, (x, y, 0)), base)
        add_box(app, "/World/plain", 2.0, (0, 10, 0), velocity=(0, 0, 0))
        [frame] = frames_of(app, add_lidar(app, config=rotary(4)), 6)

    np.testing.assert_allclose(frame.channel("scalar"), [0.17, 0.85, 0.4, 0.5], rtol=1e-6)


def test_every_material_has_a_reflectance_and_coats_change_it():
    assert set(REFLECTANCE) == set(BASES)
    assert all(0 < reflectance_of(base, coating) <= 1 for base in BASES for coating in COATINGS)
    assert reflectance_of("asphalt", "paint") == 0.5
    assert reflectance_of("asphalt", "clearcoat") == pytest.approx(0.17 * 0.96**2)
    assert reflectance_of("asphalt", "paint_clearcoat") == pytest.approx(0.5 * 0.96**2)
    optics = optics_of(np.array([encode("asphalt"), encode("steel", "paint", "retroreflective")]))
    assert optics.reflectance.tolist() == pytest.approx([0.17, 0.5])
    assert optics.retro.tolist() == [False, True]
