"""Several returns of a beam: at edges, through glass, and which of them are kept."""

import numpy as np
import pytest

from sensors.lidar.config import EmitterState, LidarConfig
from sensors.lidar.echoes import Candidates, SubRays, echo_ids, form_echoes, separation
from tests.support.lidar_worlds import EVERYTHING, add_box, add_lidar, bind, frames_of, rotary, stare, weightless

NOISE = {"lidar_noise": "on"}


def frame_of(build, config, updates=6, **fidelity):
    with weightless(**fidelity) as app:
        build(app)
        return frames_of(app, add_lidar(app, config=config), updates)[-1]


def half_and_half(app):
    """A box whose left edge lies on the x axis, 9.5 m ahead, before a wall at 20 m."""
    add_box(app, "/World/Near", 1.0, (10, -0.5, 0))
    add_box(app, "/World/Far", 10.0, (25, 0, 0))


ONE_BEAM = {"skip_dropping_invalid_points": False, "divergence_hor_deg": 0.5, "divergence_ver_deg": 0.5}


def test_a_beam_on_an_edge_brings_both_surfaces_back_each_with_its_share():
    frame = frame_of(half_and_half, stare([0.0], **ONE_BEAM), lidar_subrays=200)

    assert frame.channel("echoId").tolist() == [0, 1]
    np.testing.assert_allclose(frame.channel("distance"), [9.5, 20.0], atol=1e-3)
    np.testing.assert_allclose(frame.channel("scalar"), [0.25, 0.25], atol=0.01)  # half of the beam on 0.5 each
    assert frame.channel("scalar").sum() == pytest.approx(0.5, abs=1e-4)
    assert {len(frame.channel(name)) for name in EVERYTHING} == {2}
    assert frame.channel("timeOffsetNs").tolist() == [0, 0]


def test_a_single_wall_is_one_echo_as_far_as_its_middle():
    frame = frame_of(
        lambda app: add_box(app, "/World/Wall", 10.0, (15, 0, 0)), stare([0.0], **ONE_BEAM), lidar_subrays=50
    )

    assert frame.channel("echoId").tolist() == [0]
    # Sub-rays are off by up to 0.25 deg, so up to 10 (1 / cos - 1) = 1e-4 m longer than the axis.
    assert 10.0 - 1e-5 <= frame.channel("distance")[0] <= 10.0 + 1e-4
    assert frame.channel("scalar")[0] == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize(("most", "kept"), [(1, [20.0]), (2, [9.5, 20.0])])
def test_max_returns_keeps_the_strongest_then_the_last(most, kept):
    def build(app):
        half_and_half(app)
        bind(app, app.stage.GetPrimAtPath("/World/Near"), "rubber")
        bind(app, app.stage.GetPrimAtPath("/World/Far"), "snow")

    frame = frame_of(build, stare([0.0], max_returns=most, **ONE_BEAM), lidar_subrays=100)

    np.testing.assert_allclose(frame.channel("distance"), kept, atol=1e-3)
    assert frame.channel("echoId").tolist() == list(range(most))


def glass(app, material=("clear_glass",)):
    """A pane 10 mm thick 4.5 m ahead, before a wall of 0.5 at 20 m."""
    pane = add_box(app, "/World/Pane", 1.0, (5, 0, 0))
    bind(app, pane, *material)
    add_box(app, "/World/Wall", 10.0, (25, 0, 0))


@pytest.mark.parametrize("material", [("clear_glass",), ("plastic", "none", "visually_transparent")])
def test_light_passes_glass_and_a_weak_return_comes_from_it(material):
    config = stare([0.0], max_returns=5, **ONE_BEAM)

    frame = frame_of(lambda app: glass(app, material), config)  # a block of glass: faces at 4.5 and 5.5 m

    np.testing.assert_allclose(frame.channel("distance"), [4.5, 5.5, 20.0], atol=1e-3)
    through = 0.96**2
    np.testing.assert_allclose(frame.channel("scalar"), [0.04, 0.04 * through, 0.5 * through**2], rtol=1e-5)
    assert frame.channel("echoId").tolist() == [0, 1, 2]
    np.testing.assert_allclose(frame.channel("hitNormals"), np.tile([-1.0, 0, 0], (3, 1)), atol=1e-6)


def test_with_one_return_the_stronger_of_glass_and_wall_is_kept():
    frame = frame_of(glass, stare([0.0], max_returns=1, **ONE_BEAM))

    # 0.5 * 0.96^4 / 20^2 = 1.06e-3 against 0.04 / 4.5^2 = 1.98e-3: the glass is stronger here.
    np.testing.assert_allclose(frame.channel("distance"), [4.5], atol=1e-3)


def test_a_frosted_pane_and_an_opaque_one_end_the_beam():
    frame = frame_of(lambda app: glass(app, ("frosted_glass",)), stare([0.0], max_returns=5, **ONE_BEAM))

    np.testing.assert_allclose(frame.channel("distance"), [4.5], atol=1e-3)


def test_elements_without_any_echo_are_kept_where_the_prim_says_so():
    config = stare([0.0, 0.001, 0.002], [0.0, 90.0, 0.0], max_returns=5)

    frame = frame_of(glass, config)

    assert frame.channel("emitterId").tolist() == [0, 0, 0, 1, 2, 2, 2]
    assert frame.channel("echoId").tolist() == [0, 1, 2, 0, 0, 1, 2]
    assert frame.channel("flags").tolist() == [64, 64, 64, 0, 64, 64, 64]
    assert frame.channel("distance")[3] == 0.0


def test_where_beams_meet_one_thing_sub_rays_change_no_count_and_every_motion_gives_the_same():
    def scan(**fidelity):
        def build(app):
            add_box(app, "/World/Room", 20.0, (0, 0, 0))

        return frame_of(build, rotary(90, elevations=(0.0, 3.0)), **fidelity)

    single, several = scan(), scan(lidar_subrays=7)

    np.testing.assert_array_equal(single.channel("azimuth"), several.channel("azimuth"))
    np.testing.assert_allclose(single.channel("distance"), several.channel("distance"), atol=0.03)
    for motion in ("update", "continuous"):
        other = scan(lidar_subrays=7, lidar_motion=motion)
        for name in EVERYTHING:
            assert other.channel(name).tobytes() == several.channel(name).tobytes(), name


KNOBS = {
    "plain": ({}, {}),
    "noise": (dict.fromkeys(("azimuth_error_std", "elevation_error_std", "range_accuracy_m"), 0.2), NOISE),
    "origins and steps": ({"origin_error_std": (0.1, 0.1, 0.1), "range_resolution_m": 0.03}, NOISE),
    "gates of reported ranges": ({"range_accuracy_m": 0.2, "near_range_m": 9.6, "far_range_m": 13.0}, NOISE),
    "threshold": ({"min_reflectance": 0.45, "min_reflection_range_m": 10.0}, {}),
    "world": ({"output_frame_of_reference": "WORLD"}, {}),
    "update": ({}, {"lidar_motion": "update"}),
    "continuous": ({}, {"lidar_motion": "continuous", **NOISE}),
    "bins": ({}, {"lidar_motion": "continuous", "lidar_bins": 4}),
}


@pytest.mark.parametrize("keep", [True, False])
@pytest.mark.parametrize("knob", KNOBS)
def test_every_knob_acts_where_beams_may_pass_glass_as_where_they_cannot(knob, keep):
    """A pane behind the sensor's beams is never met; but with it, what beams meet is grouped into echoes."""
    fields, fidelity = KNOBS[knob]

    def scan(pane):
        def build(app):
            add_box(app, "/World/Room", 20.0, (2, 1, 0))
            add_box(app, "/World/Car", 1.0, (-4, 3, 0), velocity=(5, 0, 0))
            bind(app, add_box(app, "/World/Pane", 0.1, (0, 0, 8)), "clear_glass" if pane else "stone")

        config = rotary(90, elevations=(-5.0, 0.0, 3.0), skip_dropping_invalid_points=keep, **fields)
        return frame_of(build, config, **fidelity)

    without, with_pane = scan(False), scan(True)

    some_dark = knob in ("threshold", "gates of reported ranges")
    assert 0 < without.channel("flags").astype(bool).sum() < (270 if some_dark else 271)
    for name in EVERYTHING:
        assert with_pane.channel(name).tobytes() == without.channel(name).tobytes(), name


def candidates(beam, distance, light):
    count = len(beam)
    return Candidates(
        np.array(beam),
        np.array(distance, np.float32),
        np.array(light, np.float32),
        np.zeros((count, 3), np.float32),
        np.arange(count, dtype=np.int32),
    )


def test_hits_nearer_to_each_other_than_the_separation_are_one_echo():
    hits = candidates([0, 0, 0, 1], [10.0, 10.4, 12.0, 10.2], [0.1, 0.1, 0.2, 0.3])

    echoes = form_echoes(hits, separation=0.5, least=0.0, most=9)

    weights = np.array([0.1 / 10.0**2, 0.1 / 10.4**2])
    assert echoes.beam.tolist() == [0, 0, 1]
    assert echo_ids(echoes.beam).tolist() == [0, 1, 0]
    np.testing.assert_allclose(echoes.distance, [weights @ [10.0, 10.4] / weights.sum(), 12.0, 10.2], rtol=1e-6)
    np.testing.assert_allclose(echoes.light, [0.2, 0.2, 0.3], rtol=1e-6)
    assert echoes.surface.tolist() == [0, 2, 3]


@pytest.mark.parametrize(
    ("most", "kept"), [(1, [20.0]), (2, [20.0, 50.0]), (3, [10.0, 20.0, 50.0]), (4, [10.0, 20.0, 40.0, 50.0])]
)
def test_strongest_then_last_then_first_then_the_stronger_ones_are_kept_near_to_far(most, kept):
    hits = candidates([3] * 5, [30.0, 10.0, 50.0, 20.0, 40.0], [0.09, 0.1, 0.1, 0.9, 0.5])

    assert form_echoes(hits, separation=1.0, least=0.0, most=most).distance.tolist() == kept


def test_echoes_too_weak_to_detect_do_not_count():
    hits = candidates([0, 0], [10.0, 20.0], [0.1, 0.1])

    assert form_echoes(hits, separation=1.0, least=0.1 / 15**2, most=2).distance.tolist() == [10.0]


def test_echoes_are_a_pulse_apart_unless_the_profile_says_how_far():
    state = EmitterState(np.zeros(1), np.zeros(1))

    assert separation(LidarConfig(emitter_states=(state,))) == pytest.approx(0.9, abs=0.001)  # 6 ns there and back
    assert separation(LidarConfig(emitter_states=(state,), min_dist_between_echos_m=0.2)) == 0.2


def test_sub_rays_fill_the_cone_of_the_divergence_evenly():
    state = EmitterState(np.zeros(1), np.zeros(1))
    config = LidarConfig(emitter_states=(state,), divergence_hor_deg=1.0, divergence_ver_deg=0.5)
    sub = SubRays(config, 400)
    beam = np.array([[1.0], [0.0], [0.0]], np.float32)

    rays = np.concatenate([sub.directions(number, beam) for number in range(400)], axis=1)

    across, up = np.rad2deg(np.arctan2(rays[1], rays[0])), np.rad2deg(np.arcsin(rays[2]))
    shape = (across / 0.5) ** 2 + (up / 0.25) ** 2
    assert shape.max() < 1.0
    assert np.mean(shape < 0.25) == pytest.approx(0.25, abs=0.01)  # a quarter of them in a quarter of the area
    np.testing.assert_allclose([across.mean(), up.mean()], 0.0, atol=0.01)


@pytest.mark.parametrize("most", [1, 2, 3, 5])
@pytest.mark.parametrize("seed", range(5))
def test_echoes_are_those_of_a_plain_loop_over_beams(most, seed):
    rng = np.random.default_rng(seed)
    beam = np.concatenate([np.flatnonzero(rng.random(40) < 0.8) for _ in range(6)])  # six sub-rays, one after another
    distance = np.round(rng.uniform(1, 4, len(beam)), 1).astype(np.float32)  # with ties
    light = rng.choice([0.1, 0.2, 0.5], len(beam)).astype(np.float32)
    normals, surface = rng.random((len(beam), 3), np.float32), np.arange(len(beam), dtype=np.int32)
    least, separation = 0.02, 0.25

    found = form_echoes(
        Candidates(beam, distance, light, normals, surface), separation=separation, least=least, most=most
    )

    expected = []
    for number in range(40):
        rows = sorted(np.flatnonzero(beam == number), key=lambda row: distance[row])
        groups = []
        for row in rows:
            if groups and distance[row] - distance[groups[-1][-1]] <= separation:
                groups[-1].append(row)
            else:
                groups.append([row])
        energy = light.astype(float) / distance.astype(float) ** 2
        totals = [(sum(energy[group]), group) for group in groups if sum(energy[group]) >= least]
        strongest = max(range(len(totals)), key=lambda one: totals[one][0], default=0)
        order = sorted(
            range(len(totals)),
            key=lambda one: (one != strongest, one != len(totals) - 1, one != 0, -totals[one][0]),
        )
        for one in sorted(order[:most]):
            total, group = totals[one]
            brightest = max(reversed(group), key=lambda row: energy[row])
            expected.append((number, sum(energy[group] * distance[group]) / total, sum(light[group]), brightest))

    assert found.beam.tolist() == [one[0] for one in expected]
    assert found.surface.tolist() == [one[3] for one in expected]
    np.testing.assert_array_equal(found.normals, normals[[one[3] for one in expected]])
    np.testing.assert_allclose(found.distance, [one[1] for one in expected], rtol=1e-6)
    np.testing.assert_allclose(found.light, [one[2] for one in expected], rtol=1e-6)
