"""Radar and RadarSensor: created, wrapped, refused; the profile's two differences."""

import dataclasses

import numpy as np
import pytest
from pxr import Sdf

import sensors.replicator as rep
from graph.sim import App
from graph.sim import settings as keys
from sensors import SUPPORTED_RADAR_CONFIGS, Radar, RadarSensor, parse_generic_model_output_data
from sensors.configs.shipped import find_asset
from sensors.radar.config import RadarConfig, ScanConfig
from sensors.radar.names import attribute_name

WPM = "omni:sensor:WpmDmat:"
WALL = {"/World/Wall": {"type": "Cube", "size": 2.0, "translate": [11, 0, 0]}}


@pytest.fixture
def app():
    with App(None, physics_hz=60, loop_hz=60) as app:
        app.add_prims(WALL)
        yield app


def test_a_radar_is_created_placed_and_measures(app):
    radar = Radar("/World/Car/Radar", aux_output_level="BASIC", tick_rate=20.0, translations=[1, 0, 0], app=app)
    sensor = RadarSensor(radar, annotators=["generic-model-output"])
    assert (sensor.radar, sensor.authoring_object, radar.paths, radar.tick_rate) == (radar, radar, [radar.path], 20)
    assert sensor.get_data("generic-model-output")[0] is None
    app.play()
    app.update(steps=6)
    data, _ = sensor.get_data("generic-model-output")
    gmo = parse_generic_model_output_data(data)
    assert (gmo.frameId, gmo.timestampNs) == (1, 100_000_000)
    nearest = int(np.argmax(gmo.scalar))
    assert gmo.z[nearest] == pytest.approx(9.0, abs=0.02)


def test_names_of_attributes_bring_their_scan_configuration(app):
    radar = Radar("/World/Radar", attributes={f"{WPM}scan:s002:maxRangeM": 300.0, f"{WPM}cfarMode": "4D"}, app=app)
    assert [(scan.name, scan.max_range_m) for scan in radar.config.scans] == [("s001", 50.0), ("s002", 300.0)]
    assert radar.config.cfar_mode == "4D"


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("scan:s001:rcsTuningCoefficients", (-60.0, 1.0, 0.0), ("rcs_tuning_coefficients", (-60.0, 1.0, 0.0))),
        ("scan:s001:rcsTuningCoefficients", np.array([-60, 1, 0]), ("rcs_tuning_coefficients", (-60.0, 1.0, 0.0))),
        ("scan:s001:maxRangeM", np.float32(80), ("max_range_m", 80.0)),
        ("scan:s001:rBins", np.int64(80), ("r_bins", 80)),
    ],
)
def test_attributes_take_tuples_arrays_and_numbers_of_numpy(app, name, value, read):
    radar = Radar("/World/Radar", attributes={f"{WPM}{name}": value}, app=app)
    assert getattr(radar.config.scans[0], read[0]) == read[1]


def test_the_schema_has_the_defaults_of_the_model(app):
    """A new prim reads as RadarConfig() and ScanConfig() do, attribute by attribute, and none is without a value."""
    radar = Radar("/World/Radar", app=app)
    assert radar.config == RadarConfig(name="/World/Radar")
    without = {"datacubeMode", "apertureWindowAzimuth", "apertureWindowElevation", "carrierFrequency"}
    for one in dataclasses.fields(ScanConfig)[1:]:
        value = radar.prim.GetAttribute(f"{WPM}scan:s001:{attribute_name(one.name)}").Get()
        if isinstance(one.default, tuple):
            assert value is None or tuple(value) == one.default
        elif one.default and attribute_name(one.name) not in without:
            assert value == pytest.approx(one.default), one.name


@pytest.mark.parametrize("name", ["IWRL6432AOP", *SUPPORTED_RADAR_CONFIGS])
def test_a_shipped_configuration_by_name_and_path(app, name):
    radar = Radar.create("/World/Radar", config=name, app=app)
    assert radar.config.wave_length_mm == 4.955
    (scan,) = radar.config.scans
    across, up = scan.grid(None)
    assert across * up == pytest.approx(find_asset(name)[0].figures()["rays_per_scan"], rel=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"aux_output_level": "EXTRA"}, "aux_output_level 'EXTRA' is not one of NONE, BASIC"),
        ({"tick_rate": -1}, "tick_rate -1: give a rate in Hz"),
        ({"config": "IWR"}, "there is no radar configuration 'IWR' in SUPPORTED_RADAR_CONFIGS"),
        ({"config": "IWRL6432AOP", "usd_path": "a.usd"}, "give config or usd_path, not both"),
        ({"config": "IWRL6432AOP", "variant": "x"}, "has no variants"),
    ],
)
def test_what_cannot_be_is_a_value_error_in_a_line(app, options, message):
    with pytest.raises(ValueError, match=message):
        Radar.create("/World/Radar", app=app, **options)


def test_wrapping_asks_for_type_and_schema(app):
    app.stage.DefinePrim("/World/Lidar", "OmniLidar")
    with pytest.raises(ValueError, match="/World/Lidar is of type OmniLidar, not OmniRadar"):
        Radar("/World/Lidar", app=app)
    with pytest.raises(ValueError, match="there is no annotator 'gmo'"):
        RadarSensor("/World/Radar", annotators=["gmo"], app=app)


def test_detections_are_drawn(app, tmp_path):
    RadarSensor(Radar("/World/Radar", app=app))
    product = next(iter(app.rendering.products.values()))
    rep.writers.get("RtxRadarDebugDrawPointCloud", {"output_dir": tmp_path}, app=app).attach(product)
    app.play()
    app.update(steps=1)
    assert [path.name for path in tmp_path.iterdir()] == ["World_Radar_000000.png"]


def test_the_annotators_of_point_sensors_and_its_own_read_it(app):
    sensor = RadarSensor(Radar("/World/Radar", aux_output_level="BASIC", app=app))
    cloud = rep.get_annotator("IsaacExtractRTXSensorPointCloud", app=app).attach(sensor.render_product)
    own = rep.get_annotator("IsaacCreateRTXRadarPointCloud", app=app).attach(sensor.render_product)
    before = own.get_data()
    assert [len(before[name]) for name in ("data", "rcs", "radialVelocityMS")] == [0, 0, 0]
    app.play()
    app.update(steps=1)
    data = cloud.get_data()
    assert data["radialVelocityMS"].tolist() == [0.0] * len(data["data"])
    assert np.linalg.norm(data["data"], axis=1) == pytest.approx(data["distance"], rel=1e-5)
    told = own.get_data()
    assert told.keys() == before.keys()
    assert np.array_equal(told["data"], data["data"])
    assert np.array_equal(told["rcs"], data["intensity"])
    assert (told["info"]["scanIdx"], told["info"]["maxRangeM"], told["info"]["timestampNs"]) == (0, 50.0, 16_666_667)


@pytest.mark.parametrize("option", ["outputIntensity", "outputTimestamp", "outputRadialVelocityMS"])
def test_its_own_annotator_takes_the_options_of_the_helper(app, option):
    """The intensity of a detection is its cross section."""
    sensor = RadarSensor(Radar("/World/Radar", aux_output_level="BASIC", app=app))
    own = rep.get_annotator("IsaacCreateRTXRadarPointCloud", {option: True}, app=app).attach(sensor.render_product)
    app.play()
    app.update(steps=1)
    told = own.get_data()
    assert len(told["rcs"]) > 0
    assert ("intensity" in told) == (option == "outputIntensity")
    if "intensity" in told:
        assert np.array_equal(told["intensity"], told["rcs"])
    assert len(told["timestamp"]) == len(told["radialVelocityMS"]) == len(told["rcs"])


def test_the_product_needs_motion_bvh_to_create_a_radar_not_to_wrap_one():
    with App(None, physics_hz=60, loop_hz=60, parity="isaacsim-6.0.1") as app:
        with pytest.raises(
            RuntimeError, match="/World/Radar: a radar needs Motion BVH; set /renderer/raytracingMotion"
        ):
            Radar("/World/Radar", app=app)
        prim = app.stage.DefinePrim("/World/Radar", "OmniRadar")
        assert prim.GetTypeName() == Radar("/World/Radar", app=app).prim_type
        app.settings.set(keys.MOTION_BVH, True)
        assert Radar("/World/Other", app=app).paths == ["/World/Other"]


@pytest.mark.parametrize(
    ("parity", "bvh", "told"), [("isaacsim-6.0.1", False, 1), ("isaacsim-6.0.1", True, 0), ("documented", False, 0)]
)
def test_the_products_profile_tells_that_a_wrapped_radar_is_silent_there(parity, bvh, told):
    with App(None, physics_hz=60, loop_hz=60, parity=parity, settings={keys.MOTION_BVH: bvh}) as app:
        app.stage.DefinePrim("/World/Radar", "OmniRadar")
        RadarSensor("/World/Radar", app=app)
        app.play()
        app.update(steps=2)
        found = [one for one in app.warnings if one.code == "radar-motion-bvh-off"]
        assert [one.where for one in found] == ["/World/Radar"] * told


def test_the_product_renders_a_radar_in_every_update_with_a_warning():
    frames = {}
    for parity in ("documented", "isaacsim-6.0.1"):
        with App(None, physics_hz=60, loop_hz=60, parity=parity) as app:
            app.settings.set(keys.MOTION_BVH, True)
            sensor = RadarSensor(Radar("/World/Radar", tick_rate=20.0, app=app))
            app.play()
            app.update(steps=12)
            frames[parity] = sensor.render_product.frames
            codes = [warning.code for warning in app.warnings]
        assert ("radar-tick-rate-ignored" in codes) is (parity != "documented")
    assert frames == {"documented": 4, "isaacsim-6.0.1": 11}  # the product delivers a frame one update later


def test_attributes_that_no_schema_has_are_named_in_a_warning(app):
    """A name in other letters, and a scan configuration whose schema nobody applied."""
    radar = Radar("/World/Radar", app=app)
    for name in ("wavelengthmm", "scan:s001:RaysPerDeg", "scan:s002:maxRangeM"):
        radar.prim.CreateAttribute(f"{WPM}{name}", Sdf.ValueTypeNames.Float, custom=False).Set(2.0)
    RadarSensor(radar)
    found = {one.where.rpartition("WpmDmat:")[2]: one.message for one in app.warnings}
    assert found["wavelengthmm"] == f'no effect: no schema of the prim has it; did you mean "{WPM}waveLengthMm"?'
    assert "scan:s001:raysPerDeg" in found["scan:s001:RaysPerDeg"]
    assert found["scan:s002:maxRangeM"] == (
        "no effect: it counts only with the schema OmniSensorGenericRadarWpmDmatScanCfgAPI:s002"
    )
    assert {one.code for one in app.warnings} == {"sensor-attribute-unknown"}
