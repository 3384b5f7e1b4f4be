"""Configurations by name, by path, and on prims."""

import dataclasses
import json
from fractions import Fraction

import numpy as np
import pytest
from pxr import Usd

from graph.base.errors import UserError
from graph.sim import register_schemas
from sensors.configs import author_config
from sensors.configs.catalog import assets, find, load
from sensors.lidar.pattern import firing_pattern
from sensors.lidar.prim import read_config, write_config
from sensors.lidar.vendor import parse_profile
from sensors.prim import read_aux_level, read_tick_rate, write, write_aux_level


@pytest.fixture
def stage():
    register_schemas()
    return Usd.Stage.CreateInMemory()


@pytest.mark.parametrize(
    ("name", "emitters", "ticks", "scan_hz", "near", "far", "returns"),
    [
        ("Example_Rotary", 128, 3600, 10, 0.3, 200.0, 2),
        ("Example_Rotary_2D", 1, 3600, 10, 0.3, 200.0, 2),
        ("Simple_Example_Solid_State", 12, 1, 30, 1.0, 200.0, 2),
        ("OS1", 32, 1024, 10, 0.3, 120.0, 2),
        ("XT32", 32, 2000, 10, 0.05, 120.0, 2),
        ("picoScan150", 2761, 1, 20, 0.05, 45.0, 1),
        ("RPLIDAR_S2E", 1, 3200, 10, 0.05, 30.0, 1),
    ],
)
def test_shipped_configs_have_the_published_numbers(name, emitters, ticks, scan_hz, near, far, returns):
    config = find(name)

    assert (config.number_of_emitters, config.ticks_per_scan, config.scan_rate_base_hz) == (emitters, ticks, scan_hz)
    assert (config.near_range_m, config.far_range_m, config.max_returns) == (near, far, returns)
    assert len(firing_pattern(config)) == emitters * ticks


def test_emitter_tables_have_the_published_ends():
    rotary, xt32, os1, pico = (find(n).emitter_states[0] for n in ("Example_Rotary", "XT32", "OS1", "picoScan150"))

    assert sorted(set(rotary.azimuth_deg.tolist())) == [-3.0, -1.0, 1.0, 3.0]
    assert (rotary.elevation_deg.min(), rotary.elevation_deg.max()) == (-15.0, 10.0)
    assert sorted(set(rotary.fire_time_ns.tolist())) == list(range(0, 24501, 3500))
    assert len(set(zip(rotary.azimuth_deg.tolist(), rotary.elevation_deg.tolist(), strict=True))) == 128
    assert (xt32.fire_time_ns[0], xt32.fire_time_ns[-1]) == (368, 47240)
    assert (os1.fire_time_ns[0], os1.fire_time_ns[-1]) == (1525, 96106)
    assert (pico.azimuth_deg[0], pico.azimuth_deg[1380], pico.azimuth_deg[1381]) == (138.0, 0.0, np.float32(359.9))


@pytest.mark.parametrize(
    "spelling",
    [
        "/Isaac/Sensors/HESAI/XT32_SD10/HESAI_XT32_SD10.usd",
        "HESAI_XT32_SD10",
        "HESAI XT32 SD10",
        "XT32_SD10",
        "XT32 SD10",
        "XT32",
    ],
)
def test_five_spellings_and_the_short_name_find_one_config(spelling):
    assert find(spelling) == find("HESAI_XT32_SD10")


def test_variants_change_rates_and_fire_times():
    slow, fast = find("OS1", "OS1_REV6_32ch10hz512res"), find("OS1_REV6_32ch20hz1024res")

    assert (slow.ticks_per_scan, slow.emitter_states[0].fire_time_ns[-1]) == (512, 192_244)
    assert (fast.scan_rate_base_hz, fast.ticks_per_scan) == (20, 1024)


def test_an_unknown_config_offers_close_matches_and_names_the_command():
    with pytest.raises(UserError, match=r"did you mean Example[_ ]Rotary.*`graph sensors` lists all"):
        find("Example_Rotery")
    with pytest.raises(UserError, match=r"did you mean Example_Rotary_2D or Example_Rotary or Example_Solid_State\?"):
        find("Example_Rotary2D")


def test_an_unknown_variant_lists_the_variants():
    with pytest.raises(UserError, match=r"no variant 'OS1_REV9'.*OS1_REV6_32ch10hz1024res"):
        find("OS1", "OS1_REV9")


@pytest.mark.parametrize("config", [0, True, 1.5, None, ["OS1"], {"OS1": 1}])
def test_a_config_that_is_not_a_text_is_reported(config):
    with pytest.raises(UserError, match="a lidar config is text"):
        load(config)


@pytest.mark.parametrize("variant", [0, True, ["OS1_REV6_32ch10hz512res"]])
def test_a_variant_that_is_neither_text_nor_choices_is_reported(variant):
    with pytest.raises(UserError, match="a variant is text"):
        load("OS1", variant)


PROFILE = {
    "class": "sensor",
    "_comment1": "anything",
    "profile": {
        "scanType": "rotary",
        "comment7": {"even": "this"},
        "scanRateBaseHz": 7.5,
        "reportRateBaseHz": 15,
        "numberOfEmitters": 2,
        "emitterStates": [{"_comment": 1, "azimuthDeg": [0, 1], "elevationDeg": [2, 3], "fireTimeNs": [0, 10.0]}],
    },
}


def test_a_profile_needs_little_and_its_comments_are_ignored(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(PROFILE))

    config = load(str(path))

    assert config.scan_rate_base_hz == Fraction(15, 2)
    assert config.ticks_per_scan == 2
    assert config.emitter_states[0].elevation_deg.tolist() == [2.0, 3.0]
    assert firing_pattern(config).channel_id.tolist() == [0, 1, 0, 1]


def test_null_in_a_profile_is_as_if_it_were_left_out():
    nulls = dict.fromkeys(
        ("numberOfEmitters", "emitterStateCount", "numRaysPerLine", "ranges", "maxReturns", "scanType")
    )

    config = parse_profile({"profile": {**PROFILE["profile"], **nulls, "reportRateBaseHz": None}}, "mine")

    assert (config.scan_type, config.max_returns, config.pattern_firing_rate_hz) == ("ROTARY", 2, 36000)


def test_a_profile_may_name_its_rate_of_ticks_as_isaac_sim_6_does():
    profile = {**PROFILE["profile"], "patternFiringRateHz": 75}

    assert parse_profile({"profile": profile}, "mine").ticks_per_scan == 10  # 75 / 7.5


def test_the_emitters_of_an_older_profile_are_one_object():
    [state] = PROFILE["profile"]["emitterStates"]
    older = {key: value for key, value in PROFILE["profile"].items() if key != "emitterStates"}

    config = parse_profile({"profile": {**older, "emitters": state}}, "mine")

    assert config == parse_profile(PROFILE, "mine")
    with pytest.raises(UserError, match=r"emitters.elevationDeg\[1\] is 91 deg"):
        parse_profile({"profile": {**older, "emitters": {**state, "elevationDeg": [2, 91]}}}, "mine")
    with pytest.raises(UserError, match="emitters holds no emitters"):
        parse_profile({"profile": {**older, "emitters": {}}}, "mine")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"numberOfEmitters": 3}, "numberOfEmitters is 3, but 2 are listed"),
        ({"scanRateBaseHz": 0}, "scanRateBaseHz is 0: it must be above 0"),
        ({"farRangeM": "far"}, "farRangeM is 'far', not a finite number"),
        ({"scanType": "spiral"}, "scanType is 'spiral'"),
        ({"emitterStates": []}, "no emitters"),
        ({"emitterStates": [{"azimuthDeg": [0, 1], "elevationDeg": [1]}]}, "azimuthDeg has 2 entries for 1 emitters"),
        (
            {"emitterStates": [{"azimuthDeg": [0, 1], "elevationDeg": ["x", 1]}]},
            r"elevationDeg\[0\] is 'x', not a finite number",
        ),
        (
            {"emitterStates": [{"azimuthDeg": [0], "elevationDeg": [1], "fireTimeNs": [-1]}]},
            r"fireTimeNs\[0\] is -1, .* from 0",
        ),
        (
            {"emitterStates": [{"azimuthDeg": [0, "1"], "elevationDeg": [1, 2]}]},
            r"azimuthDeg\[1\] is '1', not a finite number",
        ),
        (
            {"emitterStates": [{"azimuthDeg": [10**400], "elevationDeg": [1]}]},
            r"azimuthDeg\[0\] is 10+[.]{3}0+, not a finite number",
        ),
        (
            {"emitterStates": [{"azimuthDeg": [0, 1], "elevationDeg": [1, -90.5]}]},
            r"elevationDeg\[1\] is -90.5 deg; elevations are from -90 to 90",
        ),
        ({"ranges": [{"min": 1, "max": 5}, {"min": 5, "max": 5}]}, r"ranges\[1\] is 5 to 5 m; min .* below max"),
        ({"maxReturns": 256}, "maxReturns is 256; it is from 1 to 255"),
        ({"reportRateBaseHz": 7}, "reportRateBaseHz is 7, below scanRateBaseHz = 7.5: no tick in a turn"),
    ],
)
def test_a_bad_profile_says_which_field(change, message):
    with pytest.raises(UserError, match=message):
        parse_profile({"profile": {**PROFILE["profile"], **change}}, "mine")


def test_every_problem_of_a_profile_is_reported_at_its_line_and_column(tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(
        """{
  "name": "tricky \\" { [ , :", "profile": {
    "scanType": "spiral", "farRangeM": true,
    "maxReturns": 0,
    "numRaysPerLine": [3],
    "rotationDirection": "LEFT",
    "ranges": [{"min": 0}, {"max": "x"}],
    "emitterStates": [
      {"azimuthDeg": [0, 1], "elevationDeg": [1,
         2], "fireTimeNs": [0, -5], "rangeId": [0, 7]},
      {"azimuthDeg": [0], "elevationDeg": [1], "bank": [1, 2]}
    ]
  }
}
"""
    )

    with pytest.raises(UserError) as caught:
        load(str(path))

    assert {(p.mark.line, p.mark.column, p.message.removeprefix("lidar profile: ")) for p in caught.value.problems} == {
        (3, 17, "scanType is 'spiral'; it is rotary or solidState"),
        (3, 40, "farRangeM is True, not a finite number"),
        (4, 19, "maxReturns is 0; it is from 1 to 255"),
        (5, 23, "numRaysPerLine sums to 3 for 2 emitters"),
        (6, 26, "rotationDirection is 'LEFT', not one of CW, CCW"),
        (7, 36, "ranges[1].max is 'x', not a finite number"),
        (10, 32, "emitterStates[0].fireTimeNs[1] is -5, not a finite number, from 0 to 2**32 - 1"),
        (10, 52, "emitterStates[0].rangeId[1] is 7: no such range"),
        (11, 7, "emitterStates[1] has 1 emitters, the first state 2"),
        (11, 56, "emitterStates[1].bank has 2 entries for 1 emitters"),
    }
    assert all(p.mark.file == str(path) for p in caught.value.problems)


def test_a_profile_of_too_many_rays_is_reported_at_the_profile(tmp_path):
    path = tmp_path / "bad.json"
    state = '{"azimuthDeg": [0], "elevationDeg": [0]}'
    rates = '"scanRateBaseHz": 1, "reportRateBaseHz": 99999999'
    path.write_text('{"name": "big",\n "profile": {' + rates + ', "emitterStates": [' + state + "]}}")

    with pytest.raises(UserError, match=r"bad\.json:2:13: .*99,999,999 rays a scan are more than 10,000,000"):
        load(str(path))


def test_a_profile_of_several_states_ranges_and_offsets_is_honoured(tmp_path):
    """Two states in turn, each for two ticks; what the file says of banks, channels and windows is in the pattern."""
    states = [
        {"azimuthDeg": [0, 10], "elevationDeg": [1, 2], "fireTimeNs": [0, 1000], "channelId": [7, 8], "bank": [0, 1],
         "rangeId": [1, 0], "vertOffsetM": [0.1, 0.2]},
        {"azimuthDeg": [5, 15], "elevationDeg": [-1, -2], "fireTimeNs": [500, 1500], "channelId": [9, 10]},
    ]  # fmt: skip
    profile = {
        "scanType": "rotary", "scanRateBaseHz": 10, "reportRateBaseHz": 80, "rotationDirection": "CCW",
        "startAzimuthDeg": 0, "endAzimuthDeg": 200, "nearRangeM": 0.5, "farRangeM": 80, "minDistBetweenEchos": 0.7,
        "stateResolutionStep": 2, "emitterStateCount": 2, "numberOfEmitters": 2, "emitterStates": states,
        "rangeCount": 2, "ranges": [{"min": 1, "max": 20}, [{"min": 0.1, "max": 300}]],
        "intensityMappingType": "LINEAR", "intensityProcessing": "normalization",
    }  # fmt: skip
    path = tmp_path / "two.json"
    path.write_text(json.dumps({"class": "sensor", "type": "lidar", "profile": profile}))

    config = load(str(path))
    pattern = firing_pattern(config)

    assert config.min_dist_between_echos_m == 0.7
    assert pattern.tick_state.tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 0, 0]
    assert pattern.azimuth_deg.tolist() == [0, 10, 45, 55, 95, 105, 140, 150, -180, -170]  # 45 deg a tick, up to 200
    assert pattern.channel_id.tolist() == [7, 8, 7, 8, 9, 10, 9, 10, 7, 8]
    assert pattern.offset_ns.tolist()[:6] == [0, 1000, 12_500_000, 12_501_000, 25_000_500, 25_001_500]
    assert pattern.near_m.tolist() == [0.5, 1] * 2 + [1] * 4 + [0.5, 1]
    assert pattern.far_m.tolist() == [80, 20] * 2 + [20] * 4 + [80, 20]
    np.testing.assert_allclose(pattern.origins[:2, 2], [0.1, 0.2])
    assert not pattern.origins[4:8].any()


@pytest.mark.parametrize("text", ["", "[1]", "{", '{"profile": 3}', "\x00", "[" * 100_000])
def test_a_file_that_is_not_a_profile_is_one_clear_error(tmp_path, text):
    path = tmp_path / "bad.json"
    path.write_text(text)

    with pytest.raises(UserError, match=r"bad\.json.*not (valid JSON|a lidar profile)"):
        load(str(path))


def test_a_profile_outside_the_roots_is_refused(tmp_path):
    outside = tmp_path / "bad.json"
    outside.write_text(json.dumps(PROFILE))
    inside = tmp_path / "project"
    inside.mkdir()

    with pytest.raises(UserError, match="--allow"):
        load("../bad.json", base=inside, roots=[inside])
    assert load("../bad.json", base=inside, roots=[tmp_path]).number_of_emitters == 2


@pytest.mark.parametrize("asset", assets(), ids=lambda asset: asset.spellings[1])
def test_a_config_survives_being_written_to_usd_and_read_again(stage, asset):
    config = asset.config()
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")

    write_config(prim, config)
    text = stage.GetRootLayer().ExportToString()
    again = Usd.Stage.CreateInMemory()
    again.GetRootLayer().ImportFromString(text)
    found = read_config(again.GetPrimAtPath("/World/Lidar"))

    expected = dataclasses.replace(
        config, name="/World/Lidar", number_of_channels=config.number_of_channels or config.number_of_emitters
    )
    assert found == expected
    assert read_tick_rate(again.GetPrimAtPath("/World/Lidar")) == config.scan_rate_base_hz


def test_every_config_authors_its_scan_rate_as_tick_rate(stage):
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")

    author_config(prim, "picoScan150")

    assert read_tick_rate(prim) == 20
    assert "OmniSensorGenericLidarCoreAPI" in prim.GetAppliedSchemas()


def test_a_fractional_scan_rate_survives_the_schemas_whole_hertz(stage):
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")
    config = dataclasses.replace(find("XT32"), scan_rate_base_hz=Fraction(15, 2))

    write_config(prim, config)

    assert read_config(prim).scan_rate_base_hz == Fraction(15, 2)
    write(prim, "omni:sensor:Core:scanRateBaseHz", "uint", 20)
    assert read_config(prim).scan_rate_base_hz == 20  # who writes the schema's attribute means it


def test_an_attribute_set_after_the_config_wins(stage):
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")
    author_config(prim, "Example_Rotary")

    prim.GetAttribute("omni:sensor:Core:farRangeM").Set(55.5)

    assert read_config(prim).far_range_m == 55.5


def test_a_bare_prim_is_the_default_rotary_lidar(stage):
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")

    config = read_config(prim)

    assert (config.number_of_emitters, config.ticks_per_scan, config.far_range_m) == (128, 3600, 200.0)
    assert read_tick_rate(prim) == 0


def test_aux_levels_default_to_none(stage):
    prim = stage.DefinePrim("/World/Lidar", "OmniLidar")
    assert read_aux_level(prim).name == "NONE"

    write_aux_level(prim, "FULL")

    assert read_aux_level(prim).name == "FULL"
    assert list(prim.GetAttribute("_replicator:rendervar:GenericModelOutput:channels").Get()) == ["FULL"]


def test_only_sensors_with_configurations_take_a_config(stage):
    with pytest.raises(UserError, match="only OmniLidar or Camera or OmniRadar does"):
        author_config(stage.DefinePrim("/World/Cube", "Cube"), "XT32")
