"""Lidar and LidarSensor: one prim, its attributes, and what hangs on it."""

import json
from fractions import Fraction

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from graph.base.errors import UserError
from graph.sim import App
from sensors import Lidar, LidarSensor, register_writer_spec
from sensors.products import render_product
from sensors.writers import WRITERS, WriterSpec
from tests.support.lidar_worlds import define_lidar, weightless
from tests.support.without_wing import needs_wing

CHANNELS = "_replicator:rendervar:GenericModelOutput:channels"
CORE = "omni:sensor:Core:"


@pytest.fixture
def app():
    with App(None) as app:
        yield app


def value(app, path, name):
    return app.stage.GetPrimAtPath(path).GetAttribute(name).Get()


def test_creating_makes_the_prim_and_its_parents(app):
    lidar = Lidar("/World/Robot/Lidar")

    assert app.stage.GetPrimAtPath("/World/Robot").GetTypeName() == "Xform"
    assert lidar.prim.GetTypeName() == "OmniLidar"
    assert "OmniSensorGenericLidarCoreAPI" in lidar.prim.GetAppliedSchemas()
    assert list(value(app, lidar.path, CHANNELS)) == ["NONE"]
    assert value(app, lidar.path, "omni:sensor:Core:accumulateOutputs") is True
    assert lidar.paths == ["/World/Robot/Lidar"]


@pytest.mark.parametrize("shape", [[1.0, 2.0, 3.0], [[1.0, 2.0, 3.0]]])
def test_translations_are_local_and_positions_are_world(app, shape):
    UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(app.stage, "/World/Robot")).SetTranslate(Gf.Vec3d(10, 0, 0))

    local = Lidar("/World/Robot/A", translations=shape)
    placed = Lidar("/World/Robot/B", positions=shape, orientations=[0.5, 0.5, 0.5, 0.5])

    np.testing.assert_allclose(local.get_world_poses()[0], [[11, 2, 3]])
    np.testing.assert_allclose(placed.get_world_poses()[0], [[1, 2, 3]])
    np.testing.assert_allclose(placed.get_world_poses()[1], [[0.5] * 4])
    np.testing.assert_allclose(placed.get_local_poses()[0], [[-9, 2, 3]])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"aux_output_level": "SOME"}, "not one of NONE, BASIC, EXTRA, FULL"),
        ({"positions": [0, 0, 0], "translations": [0, 0, 0]}, "exclude each other"),
        ({"translations": [0, 0]}, r"give 3 finite numbers"),
        ({"translations": [0, 0, float("nan")]}, "finite"),
        ({"orientations": [0, 0, 0, 0]}, "cannot be zero"),
        ({"tick_rate": -1.0}, "give a rate in Hz"),
        ({"tick_rate": float("nan")}, "give a rate in Hz"),
        (
            {"attributes": {f"{CORE}farRangeM": "far"}},
            "farRangeM cannot be 'far': its type is float$",
        ),
        ({"attributes": {f"{CORE}maxReturns": 1.5}}, "maxReturns is a whole number; 1.5 does not fit"),
    ],
)
def test_wrong_arguments_are_value_errors_and_user_errors(app, options, message):
    for kind in (ValueError, UserError):
        with pytest.raises(kind, match=message):
            Lidar("/World/Lidar", **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"config": 3}, "/World/Lidar: config 3 is not a name"),
        ({"config": "OS1", "variant": 3}, "/World/Lidar: variant 3 is not a name, or a mapping"),
    ],
)
def test_what_is_not_a_name_is_reported(app, options, message):
    with pytest.raises(ValueError, match=message):
        Lidar.create("/World/Lidar", **options)


def test_a_schema_that_nobody_has_is_warned_of(app):
    Lidar("/World/Lidar", schemas=["OmniSensorGenericLidarCoreEmitterStateAPI:s002", "NoSuchAPI"])

    assert [(warning.code, warning.where) for warning in app.warnings] == [("unknown-schema", "/World/Lidar.NoSuchAPI")]


def test_wrapping_checks_the_prims_type(app):
    app.stage.DefinePrim("/World/Cube", "Cube")

    with pytest.raises(ValueError, match="/World/Cube is of type Cube"):
        Lidar("/World/Cube")


def test_a_regular_expression_must_match_one_prim(app):
    Lidar.create("/World/LidarA", config="XT32")

    assert Lidar("/World/Lidar.", tick_rate=10).path == "/World/LidarA"
    Lidar.create("/World/LidarB", config="XT32")
    with pytest.raises(ValueError, match="matches 2 prims"):
        Lidar("/World/Lidar.")
    with pytest.raises(ValueError, match="matches no prim"):
        Lidar("/World/Radar.")


def test_attributes_win_over_arguments_and_unknown_ones_are_skipped(app):
    lidar = Lidar(
        "/World/Lidar",
        tick_rate=5.0,
        accumulate_outputs=False,
        attributes={
            "omni:sensor:tickRate": 20.0,
            "omni:sensor:Core:accumulateOutputs": True,
            "omni:sensor:Core:farRangeM": 42.0,
            "omni:sensor:Core:nonsense": 1,
        },
    )

    assert lidar.tick_rate == 20
    assert lidar.config.accumulate_outputs is True
    assert lidar.config.far_range_m == 42.0
    assert sorted(app.warnings.codes()) == ["attribute-wins", "unknown-attribute"]
    assert [w.count for w in app.warnings if w.code == "attribute-wins"] == [2]


def test_emitter_arrays_in_attributes_bring_their_schema(app):
    prefix = "omni:sensor:Core:emitterState:s001:"
    lidar = Lidar(
        "/World/Lidar",
        attributes={
            f"{prefix}azimuthDeg": [0.0, 1.0],
            f"{prefix}elevationDeg": [2.0, 3.0],
            "omni:sensor:Core:numberOfEmitters": 2,
        },
    )

    assert "OmniSensorGenericLidarCoreEmitterStateAPI:s001" in lidar.prim.GetAppliedSchemas()
    assert lidar.config.emitter_states[0].elevation_deg.tolist() == [2.0, 3.0]


def test_wrapping_without_a_tick_rate_warns_when_it_is_not_the_scan_rate(app):
    Lidar.create("/World/Lidar", config="XT32", tick_rate=5)
    assert app.warnings.codes() == []

    Lidar("/World/Lidar")

    assert app.warnings.codes() == ["lidar-partial-scan"]


def test_configs_author_their_scan_rate_by_default(app):
    assert Lidar.create("/World/A", config="picoScan150").tick_rate == 20
    assert Lidar.create("/World/B", config="picoScan150", tick_rate=10.0).tick_rate == 10
    assert Lidar.create("/World/C", config="OS1", variant="OS1_REV6_32ch20hz512res").tick_rate == 20
    assert Lidar.create("/World/D", config="Example Rotary").path == "/World/D"


def test_a_vendor_profile_is_a_config_by_its_path(app, tmp_path):
    state = {"azimuthDeg": [0], "elevationDeg": [0], "fireTimeNs": [0]}
    profile = {"scanType": "rotary", "scanRateBaseHz": 7.5, "reportRateBaseHz": 750, "emitterStates": [state]}
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"profile": profile}))

    lidar = Lidar.create("/World/Lidar", config=str(path))

    assert lidar.tick_rate == lidar.config.scan_rate_base_hz == Fraction(15, 2)
    assert lidar.config.ticks_per_scan == 100


def test_config_and_usd_path_exclude_each_other(app):
    with pytest.raises(ValueError, match="config or usd_path, not both"):
        Lidar.create("/World/Lidar", config="XT32", usd_path="a.usda")
    with pytest.raises(ValueError, match="did you mean XT32"):
        Lidar.create("/World/Lidar", config="XT-32")
    with pytest.raises(ValueError, match="no such file"):
        Lidar.create("/World/Lidar", usd_path="missing.usda")
    assert not app.stage.GetPrimAtPath("/World/Lidar")


@pytest.mark.parametrize(("suffix", "expected"), [("usda", "/World/Sensor"), ("usd", "/World/Sensor/inner")])
def test_an_asset_is_referenced_as_the_prim_or_below_it(app, tmp_path, suffix, expected):
    path = tmp_path / f"asset.{suffix}"
    asset = Usd.Stage.CreateNew(str(path))
    with App(asset) as other:
        where = "/Sensor" if suffix == "usda" else "/Sensor/inner"
        Lidar.create(where, config="RPLIDAR_S2E", app=other)
        asset.SetDefaultPrim(asset.GetPrimAtPath("/Sensor"))
        asset.GetRootLayer().Save()

    lidar = Lidar.create("/World/Sensor", usd_path=str(path), app=app)

    assert lidar.path == expected
    assert lidar.config.ticks_per_scan == 3200


@pytest.mark.parametrize(
    ("variant", "message"),
    [
        ("slow", "has no sensor variant 'slow'; there are: fast, wide"),
        ({"speed": "fast"}, "has no variant set speed; there are: sensor"),
    ],
)
def test_a_variant_that_an_asset_does_not_have_is_refused_with_those_it_has(app, tmp_path, variant, message):
    path = tmp_path / "asset.usda"
    asset = Usd.Stage.CreateNew(str(path))
    asset.SetDefaultPrim(asset.DefinePrim("/Sensor", "OmniLidar"))
    variants = asset.GetDefaultPrim().GetVariantSets().AddVariantSet("sensor")
    for name in ("fast", "wide"):
        variants.AddVariant(name)
    asset.GetRootLayer().Save()

    with pytest.raises(ValueError, match=message):
        Lidar.create("/World/Sensor", usd_path=str(path), variant=variant, app=app)


def test_an_asset_without_a_lidar_is_refused(app, tmp_path):
    path = tmp_path / "empty.usd"
    asset = Usd.Stage.CreateNew(str(path))
    asset.SetDefaultPrim(asset.DefinePrim("/Thing", "Xform"))
    asset.GetRootLayer().Save()

    with pytest.raises(ValueError, match="holds no OmniLidar"):
        Lidar.create("/World/Lidar", usd_path=str(path))


def test_wrapping_leaves_what_is_authored(app):
    Lidar.create("/World/Lidar", config="XT32", aux_output_level="FULL", accumulate_outputs=False, tick_rate=5)
    before = app.stage.GetRootLayer().ExportToString()

    sensor = LidarSensor("/World/Lidar")
    again = Lidar("/World/Lidar")

    assert app.stage.GetRootLayer().ExportToString() == before
    assert (again.aux_output_level, again.config.accumulate_outputs, again.tick_rate) == ("FULL", False, 5)
    assert sensor.authoring_object is sensor.lidar
    assert Lidar("/World/Lidar", aux_output_level="NONE", accumulate_outputs=True).aux_output_level == "NONE"
    assert again.config.accumulate_outputs is True


def test_a_prim_of_the_bare_type_can_be_wrapped(app):
    app.stage.DefinePrim("/World/Lidar", "OmniLidar")

    assert Lidar("/World/Lidar", tick_rate=10).config.number_of_emitters == 128


@pytest.mark.parametrize(("parity", "rate"), [("documented", 0), ("isaacsim-6.0.1", 10)])
def test_a_new_lidar_has_the_tick_rate_of_the_profile(parity, rate):
    with App(parity=parity) as app:
        assert value(app, Lidar("/World/Lidar", app=app).path, "omni:sensor:tickRate") == rate
        given = Lidar("/World/Other", attributes={"omni:sensor:tickRate": 7.0}, app=app)
        assert value(app, given.path, "omni:sensor:tickRate") == 7
        assert not app.warnings.codes()


def test_the_render_product_is_small_and_named_after_the_prim(app):
    sensor = LidarSensor(Lidar.create("/World/Lidar", config="XT32"))

    assert sensor.render_product.resolution == (300, 300)
    assert sensor.render_product.path.startswith("/Render/OmniverseKit/HydraTextures/rtx_sensor_")
    prim = app.stage.GetPrimAtPath(sensor.render_product.path)
    assert prim.GetTypeName() == "RenderProduct"
    assert not app.stage.GetRootLayer().GetPrimAtPath("/Render")


def test_a_product_of_equal_prim_and_size_is_used_again(app):
    Lidar.create("/World/Lidar", config="XT32")

    first = render_product(app, "/World/Lidar", (100, 50))

    assert render_product(app, "/World/Lidar", (100, 50)) is first
    assert render_product(app, "/World/Lidar", (50, 100)) is not first


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        pytest.param("Lidar", "a Lidar is not rendered; IsaacReadLidarPointCloud", marks=needs_wing("physx")),
        ("Cube", "a Cube is not a sensor"),
    ],
)
def test_only_sensors_can_be_rendered(app, kind, message):
    app.stage.DefinePrim("/World/Thing", kind)

    with pytest.raises(UserError, match=message):
        render_product(app, "/World/Thing")


@pytest.mark.parametrize("path", ["", "/World/Nothing", "relative"])
def test_a_product_of_nothing_is_refused(app, path):
    with pytest.raises(UserError, match="there is no prim"):
        render_product(app, path)


def test_unknown_annotators_and_writers_are_refused_before_anything_is_made(app):
    with pytest.raises(ValueError, match="no annotator 'gmo'; there are: generic-model-output, stable-id-map"):
        LidarSensor("/World/Lidar", annotators=["gmo"])
    with pytest.raises(ValueError, match="no writer 'disk'"):
        LidarSensor("/World/Lidar", writers="disk")
    assert not app.stage.GetPrimAtPath("/World/Lidar")


def test_annotators_attach_and_detach_by_name(app):
    sensor = LidarSensor(Lidar.create("/World/Lidar", config="XT32"), annotators="generic-model-output")

    with pytest.raises(ValueError, match="not attached"):
        sensor.get_data("stable-id-map")
    assert list(sensor.attach_annotators("stable-id-map")) == ["stable-id-map"]
    assert sensor.annotators == ["generic-model-output", "stable-id-map"]
    assert sensor.get_data("stable-id-map") == (None, {})
    assert app.warnings.codes() == ["stable-ids-off"]

    sensor.detach_annotators(["generic-model-output", "stable-id-map"])

    assert sensor.annotators == []
    assert sensor.runtime.demand.consumers() == {}
    sensor.detach_annotators("stable-id-map")
    assert app.warnings.codes() == ["stable-ids-off", "not-attached"]


@pytest.fixture
def counting_writer():
    seen = []
    register_writer_spec("count", WriterSpec(lambda add: lambda frame: seen.append(frame.count + add), {"add": 1000}))
    yield seen
    WRITERS.pop("count")


def test_writers_get_every_frame_until_they_are_detached(app, counting_writer):
    lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E")
    UsdGeom.Cube.Define(app.stage, "/World/Room").CreateSizeAttr(20.0)
    sensor = LidarSensor(lidar, writers=["count"])

    app.play()
    app.update(steps=12)
    sensor.detach_writer("count")
    app.update(steps=6)

    assert counting_writer == [4200, 4200]


def test_a_writers_name_is_taken_once(counting_writer):
    with pytest.raises(ValueError, match="there is a writer 'count' already"):
        register_writer_spec("count", WriterSpec(lambda: print))


def test_a_sensor_made_while_playing_ends_with_the_stop(app):
    lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E")
    app.play()
    sensor = LidarSensor(lidar, annotators="generic-model-output")
    app.update(steps=12)
    assert sensor.get_data("generic-model-output")[0] is not None

    app.stop()

    with pytest.raises(RuntimeError, match="a stop ended it"):
        _ = sensor.render_product


def test_bad_attributes_stop_the_product_with_a_clear_line(app):
    lidar = Lidar.create("/World/Lidar", config="XT32")
    lidar.prim.GetAttribute("omni:sensor:Core:farRangeM").Set(float("nan"))

    with pytest.raises(UserError, match="/World/Lidar: farRangeM is not finite"):
        render_product(app, "/World/Lidar")
    lidar.prim.GetAttribute("omni:sensor:Core:farRangeM").Set(100.0)
    lidar.prim.GetAttribute("omni:sensor:tickRate").Set(-1.0)
    with pytest.raises(UserError, match="tickRate is -1"):
        render_product(app, "/World/Lidar")


@pytest.mark.parametrize(
    ("name", "word"), [("rayType", "IDEALISED"), ("intensityProcessing", "NORMALISATION"), ("rayType", "idealized")]
)
def test_words_that_are_no_tokens_are_refused(name, word):
    with weightless() as app:
        lidar = define_lidar(app)
        lidar.GetAttribute(f"omni:sensor:Core:{name}").Set(word)
        with pytest.raises(UserError, match=f"{name} = '{word}' is not one of "):
            render_product(app, "/World/Lidar")


@pytest.mark.parametrize(("name", "word"), [("rayType", "GAUSSIAN_BEAM"), ("intensityProcessing", "RAW")])
def test_tokens_that_are_not_modelled_are_reported(name, word):
    with weightless() as app:
        lidar = define_lidar(app)
        lidar.GetAttribute(f"omni:sensor:Core:{name}").Set(word)
        render_product(app, "/World/Lidar")
        [told] = [one for one in app.warnings if one.code == "lidar-attribute-ignored"]
        assert f"{name} {word} is not modelled" in told.message
