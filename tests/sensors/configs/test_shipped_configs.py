"""Every configuration that ships: found by its names, right where numbers are public, and cast."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim import App
from sensors import SUPPORTED_LIDAR_CONFIGS
from sensors.configs.catalog import assets, find
from sensors.lidar.pattern import firing_pattern
from sensors.lidar.prim import write_config
from sensors.lidar.returns import Shot, Targets
from sensors.lidar.scan import Scanner
from sensors.prim import read_tick_rate
from sensors.products import render_product
from sensors.raycast.shared import cast_world, surface_optics
from tests.support.lidar_worlds import add_box, add_lidar, weightless

COMBINATIONS = [(path, variant) for path, variants in SUPPORTED_LIDAR_CONFIGS.items() for variant in variants or [None]]
COUNTS = {
    "HESAI/XT32_SD10/HESAI_XT32_SD10.usd": 0,
    "NVIDIA/Example_Rotary_2D.usda": 0,
    "NVIDIA/Example_Rotary.usda": 0,
    "NVIDIA/Example_Solid_State.usda": 0,
    "NVIDIA/Simple_Example_Solid_State.usda": 0,
    "Ouster/OS0/OS0.usd": 10,
    "Ouster/OS1/OS1.usd": 15,
    "Ouster/OS2/OS2.usd": 10,
    "Ouster/VLS_128/Ouster_VLS_128.usd": 0,
    "SICK/LMS4000/SICK_LMS4000.usd": 3,
    "SICK/LMS5xx/SICK_LMS5xx.usd": 61,
    "SICK/LRS4000/SICK_LRS4000.usd": 18,
    "SICK/microScan3/SICK_microScan3.usd": 6,
    "SICK/MRS1000/SICK_MRS1000.usd": 3,
    "SICK/multiScan100/SICK_multiScan100.usd": 4,
    "SICK/nanoScan3/SICK_nanoScan3.usd": 0,
    "SICK/picoScan100/SICK_picoScan100.usd": 26,
    "SICK/TIM781/SICK_TIM781.usd": 0,
    "Slamtec/RPLIDAR_S2E/Slamtec_RPLIDAR_S2E.usd": 0,
    "ZVISION/ZVISION_ML30S.usda": 0,
    "ZVISION/ZVISION_MLXS.usda": 0,
}


def test_the_table_holds_all_assets_and_their_variants():
    assert {path: len(found) for path, found in SUPPORTED_LIDAR_CONFIGS.items()} == {
        f"/Isaac/Sensors/{path}": count for path, count in COUNTS.items()
    }
    assert len(COMBINATIONS) == 167
    assert SUPPORTED_LIDAR_CONFIGS["/Isaac/Sensors/Ouster/OS1/OS1.usd"][5] == "OS1_REV6_32ch10hz1024res"
    assert SUPPORTED_LIDAR_CONFIGS["/Isaac/Sensors/SICK/LMS5xx/SICK_LMS5xx.usd"][-1] == {
        "Product": "LMS5xxProSR",
        "Profile": "Profile16_25Hz_0p042deg",
    }


def test_every_asset_says_where_its_numbers_come_from_and_answers_to_its_five_names():
    for asset in assets():
        assert all(len(entry.document["source"]) > 30 for entry in asset.entries)
        assert len({find(name).name for name in asset.spellings}) == 1
        if "_" in asset.path.rpartition("/")[2]:
            assert any(" " in name for name in asset.spellings)


def test_every_combination_casts_a_scan_in_a_room():
    """The first firings of each pattern, from the middle of a box 2.5 m wide: every range is the way to its walls."""
    with weightless() as app:
        add_box(app, "/World/Room", 2.5, (0, 0, 0))
        add_lidar(app)
        app.play()
        for path, variant in COMBINATIONS:
            config = find(path, variant)
            pattern = firing_pattern(config)
            assert len(pattern) == config.rays_per_scan, path
            assert np.all(np.diff(pattern.offset_ns) >= 0)
            assert pattern.offset_ns[-1] < 10**9 / config.scan_rate_base_hz
            dropping = replace(config, skip_dropping_invalid_points=False)
            scanner, world = Scanner(pattern, dropping), cast_world(app.world)
            targets = Targets(frozenset({"distance", "emitterId", "xyz"}), world, surface_optics(world))
            rows = slice(0, min(len(pattern), 600))

            got = scanner.scan(Shot(rows, np.eye(4)), targets)

            start = np.zeros((600, 3)) if pattern.origins is None else pattern.origins[rows].astype(np.float64)
            beams = pattern.directions[rows].astype(np.float64)
            start = start[: len(beams)]
            with np.errstate(divide="ignore"):
                exact = ((1.25 - np.sign(beams) * start) / np.abs(beams)).min(axis=1)
            kept = exact > config.near_range_m
            assert int(got["count"]) == kept.sum(), (path, variant)
            points = start + beams * exact[:, None]
            np.testing.assert_allclose(got["xyz"], points[kept], atol=2e-6, err_msg=str((path, variant)))


@pytest.mark.parametrize(
    ("name", "variant", "rays", "scan_hz", "span", "near", "far"),
    [
        ("OS0", "OS0_REV7_128ch20hz1024res", 128 * 1024, 20, (-44.5, 44.5), 0.5, 75),
        ("OS1", "OS1_REV7_128ch10hz2048res", 128 * 2048, 10, (-21.48, 20.93), 0.5, 170),
        ("OS1", "OS1_REV6_32ch10hz512res", 32 * 512, 10, (-22.1, 22.1), 0.3, 120),
        ("OS2", "OS2_REV6_128ch10hz1024res", 128 * 1024, 10, (-11.09, 10.76), 1, 240),
        ("VLS 128", None, 128 * 1876, 10, (-25, 15), 1, 200),
        ("LMS4000", {"Product": "LMS4124R", "Profile": "Profile01_5p5m_0p0833deg"}, 841, 600, (0, 0), 0.7, 5.5),
        ("LMS5xx", {"Product": "LMS5xxProHR", "Profile": "Profile00_25Hz_0p1667deg"}, 1141, 25, (0, 0), 0.2, 80),
        ("LMS5xx", {"Product": "LMS5xxLiteSR", "Profile": "Profile07_75Hz_1p0deg"}, 191, 75, (0, 0), 0.2, 80),
        ("LRS4000", {"Profile": "Profile11_12p5Hz_0p02deg"}, 18000, 12.5, (0, 0), 0.2, 130),
        ("microScan3", {"Profile": "Profile06_9p0m_20p0Hz"}, 2750, 20, (0, 0), 0.05, 64),
        ("microScan3", {"Profile": "Profile01_4p0m_33p3Hz"}, 539, 33.3, (0, 0), 0.05, 40),
        ("MRS1000", {"Profile": "Profile02_6p25Hz_0p125deg"}, 4 * 2201, 6.25, (-5, 2.5), 0.2, 64),
        ("multiScan165", None, 11520, 20, (-7.2, 34.3), 0.05, 60),
        ("multiScan100", {"Product": "multiScan136"}, 10800, 20, (-22.2, 42.2), 0.05, 60),
        ("nanoScan3", None, 1651, 33.3, (0, 0), 0.05, 40),
        ("picoScan100", {"Product": "picoScan150Core", "Profile": "Profile11_15Hz_1p0deg"}, 277, 15, (0, 0), 0.05, 45),
        ("TIM781", None, 811, 15, (0, 0), 0.05, 25),
        ("ML30S", None, 51200, 10, (-49.96, 23.36), 0.2, 45),
        ("MLXS", None, 108000, 10, (-13.98, 17.67), 0.5, 250),
    ],
)
def test_public_numbers_of_variants(name, variant, rays, scan_hz, span, near, far):
    config = find(name, variant)

    elevation = firing_pattern(config).elevation_deg
    assert config.rays_per_scan == rays
    assert float(config.scan_rate_base_hz) == scan_hz
    off = 0.3 if name == "ML30S" else 1.1 if name == "MLXS" else 1e-5  # a mirror fitted to the public table
    np.testing.assert_allclose((elevation.min(), elevation.max()), span, atol=off)
    assert (config.near_range_m, config.far_range_m) == (near, far)


def test_ouster_emitters_fire_evenly_over_a_column():
    """10 Hz of 1024 columns are 97656 ns each: 762 ns for each of 128 emitters, fired in the middle of it."""
    fire = find("OS2", "OS2_REV7_128ch10hz1024res").emitter_states[0].fire_time_ns

    assert (fire[0], fire[1], fire[-1]) == (381, 381 + 762, 381 + 127 * 762)


def test_layers_of_a_turning_head_keep_their_own_azimuth_and_rhythm():
    """A multiScan136 has two layers each 1/8 deg, the others each degree, all turning clockwise at 20 Hz."""
    state = find("multiScan136").emitter_states[0]

    per_layer = {float(e): int((state.elevation_deg == e).sum()) for e in np.unique(state.elevation_deg)}
    assert sorted(per_layer.values()) == [360] * 14 + [2880] * 2
    assert per_layer[0.0] == 2880
    fine = state.elevation_deg == 0.0
    assert state.azimuth_deg[fine][:3].tolist() == [347.125, 347.0, 346.875]
    assert state.fire_time_ns[fine][:3].tolist() == [0, 17361, 34722]  # 50 ms / 2880


def test_planes_of_modules_a_quarter_turn_apart_follow_each_other():
    """MRS1000 at 12.5 Hz: 80 ms a turn, the plane of the next module 20 ms later, 1/4 deg each 55.6 us."""
    state = find("MRS1000").emitter_states[0]

    assert state.elevation_deg[[0, 1101, 2202, 3303]].tolist() == [0.0, -2.5, 2.5, -5.0]
    assert state.fire_time_ns[[0, 1, 1101, 2202, 3303]].tolist() == [0, 55_555, 20_000_000, 40_000_000, 60_000_000]


def test_a_fan_runs_clockwise_about_straight_ahead():
    lms, pico = (find(name).emitter_states[0] for name in ("LMS5xx", "picoScan100"))

    assert (lms.azimuth_deg[0], lms.azimuth_deg[570], lms.azimuth_deg[-1]) == (95.0, 0.0, -95.0)
    assert lms.fire_time_ns[:3].tolist() == [0, 18_518, 37_037]  # 40 ms / 360 deg / 6
    assert (pico.azimuth_deg[0], pico.azimuth_deg[-1]) == (138.0, 222.0)  # as its public profile counts


def test_a_product_alone_is_a_name_and_a_set_left_out_takes_what_fits():
    assert find("LMS4124R").far_range_m == 5.5
    assert find("multiScan165S") == find("multiScan100", {"Product": "multiScan165S"})
    assert find("LMS5xx", {"Profile": "Profile09_100Hz_1p0deg"}).scan_rate_base_hz == 100
    assert find("picoScan120", {"Profile": "Profile03_20Hz_0p1deg"}).number_of_emitters == 2761


@pytest.mark.parametrize(
    ("name", "variant", "message"),
    [
        ("OS1", "OS1_REV6_32ch10hz1024", "did you mean OS1_REV6_32ch10hz1024res"),
        ("XT32", "fast", "HESAI_XT32_SD10.usd has no variant 'fast'; it has no variants"),
        ("LMS5xx", {"Product": "LMS5xxProH"}, "did you mean LMS5xxProHR"),
        ("LMS5xx", {"Model": "x"}, "its variant sets are Product, Profile"),
        (
            "multiScan100",
            {"Product": "multiScan165", "Profile": "Profile01_20Hz_0p125deg"},
            "multiScan165 goes with Profile01_20Hz_0p5deg",
        ),
        ("multiscan165", None, "did you mean multiScan165"),
        ("os1", None, r"did you mean OS1"),
    ],
)
def test_a_wrong_variant_gets_similar_names_suggested(name, variant, message):
    with pytest.raises(UserError, match=message):
        find(name, variant)


@pytest.mark.parametrize(
    ("name", "variant", "rate"),
    [
        ("LRS4000", "Profile01_12p5Hz_0p04deg", Fraction(25, 2)),
        ("microScan3", "Profile01_4p0m_33p3Hz", Fraction(333, 10)),
        ("MRS1000", "Profile03_3p125Hz_0p0625deg", Fraction(25, 8)),
        ("nanoScan3", None, Fraction(333, 10)),
    ],
)
def test_a_lidar_of_a_broken_rate_ticks_once_a_scan(name, variant, rate):
    """The schema's scanRateBaseHz is a whole number: 12 for the maker's 12.5 Hz. The exact rate stands beside it, so
    that the tick rate is that of the scans, and they are whole."""
    with App(None, physics_hz=60, loop_hz=60) as app:
        prim = app.stage.DefinePrim("/World/Lidar", "OmniLidar")
        write_config(prim, find(name, variant))
        product = render_product(app, "/World/Lidar")
        assert read_tick_rate(prim) == product.sensor.config.scan_rate_base_hz == rate
        assert prim.GetAttribute("omni:sensor:Core:scanRateBaseHz").Get() == int(rate)
        assert product.sensor.rule == "whole"
        assert app.warnings.codes() == []
