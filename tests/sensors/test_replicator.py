"""Annotators and writers used as in Replicator: by name, attached to a render product."""

import numpy as np
import pytest

import sensors.replicator as rep
from graph.base.errors import UserError
from graph.sim import settings as keys
from sensors import (
    Lidar,
    LidarSensor,
    Radar,
    parse_generic_model_output_data,
    parse_stable_id_map_data,
    register_annotator_spec,
    register_writer_spec,
    unregister_annotator_spec,
    unregister_writer_spec,
)
from sensors.annotators.outputs import LABELS
from sensors.annotators.types import AnnotatorType
from sensors.products import place_product
from sensors.writers import WriterSpec
from tests.support.lidar_worlds import NORMALS, add_box, define_lidar, rotary, weightless

STABLE_IDS = "/rtx-transient/stableIds/enabled"
SCAN_BUFFER, FLAT_SCAN = "IsaacCreateRTXLidarScanBuffer", "IsaacComputeRTXLidarFlatScan"
EXTRACT, PER_FRAME = "IsaacExtractRTXSensorPointCloud", "IsaacExtractRTXSensorPointCloudNoAccumulator"


@pytest.fixture
def app():
    """A room 10 m wide around a lidar of 360 beams at 10 Hz, which has no render product yet."""
    with weightless(settings={STABLE_IDS: True}) as app:
        add_box(app, "/World/Room", 10.0, (0, 0, 0))
        define_lidar(app)
        yield app


def codes(app):
    return app.warnings.codes()


def test_a_scan_buffer_has_what_was_asked_for_with_the_documented_types(app):
    product = rep.create.render_product("/World/Lidar", (1024, 1024))
    flags = ("Azimuth", "Elevation", "Distance", "Intensity", "Timestamp", "EmitterId", "ChannelId", "MaterialId")
    flags += ("TickId", "HitNormal", "Velocity", "ObjectId", "EchoId", "TickState", "RadialVelocityMS")
    buffer = rep.AnnotatorRegistry.get_annotator(SCAN_BUFFER)
    buffer.initialize(**{f"output{name}": True for name in flags})
    buffer.attach([product.path])
    app.play()

    empty = buffer.get_data()
    assert (empty["data"].shape, empty["objectId"].shape, empty["timestamp"].dtype) == ((0, 3), (0,), np.uint64)
    app.update(steps=6)
    found = buffer.get_data()

    kinds = {
        **dict.fromkeys(("azimuth", "elevation", "distance", "intensity"), (np.float32, (360,))),
        **dict.fromkeys(("emitterId", "channelId", "materialId", "tickId"), (np.uint32, (360,))),
        **dict.fromkeys(("echoId", "tickState"), (np.uint8, (360,))),
        **dict.fromkeys(("data", "hitNormal", "velocity"), (np.float32, (360, 3))),
        "timestamp": (np.uint64, (360,)),
        "objectId": (np.uint32, (4 * 360,)),
        "radialVelocityMS": (np.float32, (0,)),
        "transform": (np.float64, (16,)),
    }
    assert {name: (found[name].dtype, found[name].shape) for name in kinds} == kinds
    assert found["transform"].tolist() == np.eye(4).reshape(-1).tolist()
    assert found["info"]["width"] == 360
    assert found["timestamp"].tolist() == [round(1e9 / 3600 * tick) for tick in range(360)]
    assert codes(app) == ["annotator-deprecated"]


def test_without_options_a_scan_buffer_is_points_alone_and_nothing_else_is_computed(app):
    product = rep.create_render_product("/World/Lidar", (32, 32))
    buffer = rep.get_annotator(SCAN_BUFFER).attach(product)
    app.play()
    app.update(steps=6)

    found = buffer.get_data()
    assert set(found) == {"data", "transform", "info", *LABELS}
    assert {name for name in LABELS if len(found[name])} == set()
    assert set(product.frame.arrays) == {"xyz"}


def test_what_one_writes_on_its_data_no_other_sees(app):
    """0 in a lidar's cloud of one annotator; the other has its points, 5 m away, and so has a view of the frame."""
    product = rep.create.render_product("/World/Lidar")
    mine, yours = rep.get_annotator(EXTRACT, render_products=product), rep.get_annotator(EXTRACT, None, product)
    view = rep.get_annotator(EXTRACT, render_products=[product], do_array_copy=False)
    app.play()
    app.update(steps=6)
    mine.get_data()["data"][:] = 0
    assert not mine.get_data()["data"].any()
    assert abs(yours.get_data()["data"]).max() == pytest.approx(5.0, abs=1e-5)
    shared = view.get_data(device="cpu")["data"]
    assert np.may_share_memory(shared, product.frame.xyz)
    assert not np.may_share_memory(view.get_data(do_array_copy=True)["data"], shared)
    with pytest.raises(ValueError, match="device 'cuda': annotators are in host memory"):
        view.get_data(device="cuda")


def test_between_ticks_the_same_data_comes_again_and_detaching_ends_the_demand(app):
    product = rep.create_render_product("/World/Lidar")
    cloud = rep.get_annotator(EXTRACT).attach(product)
    app.play()
    app.update(steps=6)
    first = cloud.get_data()
    app.update(steps=5)
    assert cloud.get_data() is first
    app.update()
    assert cloud.get_data() is not first
    assert product.sensor.demand.consumers()

    cloud.detach()

    assert product.sensor.demand.consumers() == {}
    with pytest.raises(ValueError, match="is not attached to a render product"):
        cloud.get_data()


def test_an_extracted_cloud_follows_the_auxiliary_level(app):
    define_lidar(app, "/World/Plain", level="NONE")
    define_lidar(app, "/World/Basic", level="BASIC")
    clouds = {
        name: rep.get_annotator(EXTRACT).attach(rep.create_render_product(f"/World/{name}"))
        for name in ("Plain", "Basic", "Lidar")
    }
    app.play()
    app.update(steps=6)

    always = {"data", "transform", "info", "azimuth", "elevation", "distance", "intensity", "timestamp"}
    basic = {"emitterId", "channelId", "tickId", "echoId", "tickState"}
    found = {name: cloud.get_data() for name, cloud in clouds.items()}
    filled = {name: {key for key, value in data.items() if len(value)} for name, data in found.items()}
    assert all(set(data) == {"data", "transform", "info", *LABELS} for data in found.values())
    assert filled["Plain"] == always
    assert filled["Basic"] == always | basic
    assert filled["Lidar"] == always | basic | {"materialId", "objectId", "hitNormal", "velocity"}
    assert codes(app) == []


def test_the_annotator_without_accumulator_is_deprecated_and_hands_on_the_parts_as_they_come(app):
    define_lidar(app, "/World/Parts", tick_rate=20.0)  # the scan rate is 10 Hz
    with app:
        parts = rep.get_annotator(PER_FRAME).attach(rep.create_render_product("/World/Parts"))
        again = rep.get_annotator(PER_FRAME).attach(rep.create_render_product("/World/Parts"))
        app.play()
        sizes = []
        for _ in range(12):
            app.update()
            sizes.append(len(parts.get_data()["data"]))
        assert again.get_data()["data"].tolist() == parts.get_data()["data"].tolist()
    assert sizes == [60] * 12  # 360 firings a turn of 6 updates: nothing is put together again
    assert codes(app) == ["lidar-partial-scan", "annotator-deprecated"]


def test_a_flat_scan_of_the_2d_lidar_by_its_outputs(app):
    flat = rep.get_annotator(FLAT_SCAN).attach(rep.create_render_product("/World/Lidar"))
    app.play()
    before = flat.get_data()
    assert (before["numCols"], before["numRows"], before["horizontalFov"]) == (0, 1, 0.0)
    app.update(steps=6)
    found = flat.get_data()

    assert (found["numRows"], found["numCols"], found["rotationRate"]) == (1, 360, 10.0)
    assert found["horizontalFov"] == 360.0
    assert found["horizontalResolution"] == 1.0
    assert found["depthRange"].tolist() == pytest.approx([0.3, 200.0])
    assert found["azimuthRange"].tolist() == [-180.0, 179.0]
    assert found["linearDepthData"][180] == pytest.approx(5.0, abs=1e-4)
    assert found["linearDepthData"][225] == pytest.approx(5 * 2**0.5, abs=1e-4)
    assert found["intensitiesData"].dtype == np.uint8


def test_a_flat_scan_of_a_3d_lidar_names_the_emitter_and_its_elevation(app):
    define_lidar(app, "/World/Tall", config=rotary(elevations=(0.0, 7.5)))
    product = rep.create_render_product("/World/Tall")

    with pytest.raises(UserError, match=r"FlatScan: /World/Tall: .* emitter 1 points 7.5 deg up"):
        rep.get_annotator(FLAT_SCAN).attach(product)

    app.settings.set(keys.FLAT_SCAN_NEEDS_2D, False)  # as the product does
    tall = rep.get_annotator(FLAT_SCAN).attach(product)
    app.play()
    app.update(steps=12)
    found = tall.get_data()
    assert (found["numRows"], found["numCols"], found["horizontalFov"]) == (1, 0, 0.0)
    assert len(found["linearDepthData"]) == len(found["intensitiesData"]) == 0
    [told] = [one for one in app.warnings if one.code == "flat-scan-3d"]
    assert told.count == 1
    assert "emitter 1 points 7.5 deg up" in told.message
    app.stop()

    Lidar.create("/World/Flat", config="Example_Rotary_2D", app=app)
    assert rep.get_annotator(FLAT_SCAN).attach(rep.create_render_product("/World/Flat")).product is not None


def test_what_reads_lidars_alone_names_a_radar_and_itself(app):
    app.stage.DefinePrim("/World/Radar", "OmniRadar")
    product = rep.create_render_product("/World/Radar")
    with pytest.raises(ValueError, match=rf"{FLAT_SCAN}: /World/Radar is OmniRadar; it reads OmniLidar only"):
        rep.get_annotator(FLAT_SCAN).attach(product)


def test_a_scan_buffer_of_a_radar_has_radial_velocities_and_nothing_of_a_lidar(app):
    radar = Radar("/World/Radar", aux_output_level="BASIC", app=app)
    flags = {f"output{name}": True for name in ("RadialVelocityMS", "Distance", "EmitterId", "HitNormal")}
    buffer = rep.get_annotator(SCAN_BUFFER, flags).attach(rep.create_render_product(radar))
    app.play()
    app.update(steps=2)
    found = buffer.get_data()
    assert found["radialVelocityMS"].tolist() == [0.0] * len(found["data"]) != []
    assert len(found["distance"]) == len(found["data"])
    assert found["emitterId"].shape == (0,)
    assert found["hitNormal"].shape == (0, 3)


@pytest.mark.parametrize(
    ("option", "level", "settings", "code", "names"),
    [
        ("outputHitNormal", "EXTRA", {}, "aux-level-too-low", "_replicator:rendervar:GenericModelOutput:channels"),
        ("outputTickId", "NONE", {}, "aux-level-too-low", "aux_output_level BASIC"),
        ("outputHitNormal", "FULL", {NORMALS: False}, "normals-off", NORMALS),
        ("outputObjectId", "FULL", {STABLE_IDS: False}, "stable-ids-off", STABLE_IDS),
    ],
)
def test_an_output_that_cannot_be_filled_stays_empty_and_one_warning_says_why(option, level, settings, code, names):
    with weightless(settings={STABLE_IDS: True, **settings}) as app:
        add_box(app, "/World/Room", 10.0, (0, 0, 0))
        define_lidar(app, level=level)
        buffer = rep.get_annotator(SCAN_BUFFER, {option: True}).attach(rep.create_render_product("/World/Lidar"))
        app.play()
        app.update(steps=30)
        found = buffer.get_data()
        told = [warning for warning in app.warnings if warning.code != "annotator-deprecated"]
    name = option.removeprefix("output")
    assert found[name[0].lower() + name[1:]].size == 0
    assert len(found["data"]) == 360
    assert [warning.code for warning in told] == [code]
    assert names in told[0].message


def test_a_scan_buffer_keeps_its_data_when_a_frame_is_empty(app):
    add_box(app, "/World/Wall", 1.0, (30, 0, 0))
    define_lidar(app, "/World/Far", config=rotary(near_range_m=20.0))
    buffer = rep.get_annotator(SCAN_BUFFER).attach(rep.create_render_product("/World/Far"))
    cloud = rep.get_annotator(EXTRACT).attach(rep.create_render_product("/World/Far"))
    app.stage.RemovePrim("/World/Room")
    app.play()
    app.update(steps=6)
    seen = len(buffer.get_data()["data"])
    assert seen > 0
    product = buffer.product
    empty = type(product.frame)(
        timestamp_ns=1, frame_id=9, start=product.frame.start, end=product.frame.end, count=0, arrays={}
    )
    product.deliver(empty)

    assert len(buffer.get_data()["data"]) == seen
    assert cloud.get_data()["data"].shape == (0, 3)


def test_the_gmo_annotator_gives_the_buffer_and_the_map_its_entries(app):
    product = rep.create_render_product("/World/Lidar")
    gmo = rep.annotators.get("GenericModelOutput", device="cpu").attach(product)
    ids = rep.annotators.get("StableIdMap").attach(product)
    assert gmo.get_data() is None
    assert ids.get_data() is None
    app.play()
    app.update(steps=6)

    assert parse_generic_model_output_data(gmo.get_data()).numElements == 360
    assert ids.get_data().dtype == np.uint8


def test_where_nothing_is_hit_the_output_has_a_time_and_no_elements(app):
    app.stage.RemovePrim("/World/Room")
    sensor = LidarSensor(Lidar("/World/Lidar", aux_output_level="FULL", app=app), annotators="generic-model-output")
    app.play()
    app.update(steps=5)
    assert sensor.get_data("generic-model-output") == (None, {})  # the first turn is not over
    app.update(steps=7)
    gmo = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])

    assert (gmo.numElements, gmo.frameId, gmo.timestampNs, gmo.scanComplete) == (0, 1, 100_000_000, True)
    assert gmo.frameEnd.timestampNs == 200_000_000
    assert len(gmo.x) == len(gmo.objId) == len(gmo.hitNormals) == 0
    assert gmo.objId.shape == (0, 16)


def test_the_functions_are_in_the_package_too(app):
    import sensors

    product = sensors.create_render_product("/World/Lidar", (64, 64))
    assert sensors.get_annotator(EXTRACT).attach([product]).product is product
    assert sensors.writers.get("draw-point-cloud").name == "draw-point-cloud"


def test_mistakes_are_one_line_each(app):
    product = rep.create_render_product("/World/Lidar")
    blank = place_product(app.world, "/Render/Blank", "", (4, 4))
    for act, message in (
        (lambda: rep.get_annotator("IsaacCreateRTXLidarScanBufer"), f'did you mean "{SCAN_BUFFER}"'),
        (lambda: rep.get_annotator(SCAN_BUFFER).initialize(outputTimestmp=True), 'did you mean "outputTimestamp"'),
        (lambda: rep.get_annotator("StableIdMap").initialize(size=1), "it has none"),
        (lambda: rep.get_annotator(EXTRACT, device="cuda"), "annotators are in host memory"),
        (lambda: rep.get_annotator(EXTRACT).attach([]), "attach it to one render product, not 0"),
        (lambda: rep.get_annotator(EXTRACT).attach("/Render/None"), "there is no render product /Render/None"),
        (lambda: rep.get_annotator(EXTRACT).attach(product).attach(product), "already; detach it first"),
        (lambda: rep.get_annotator(EXTRACT).attach(product).initialize(), "initialize it before attach"),
        (lambda: rep.create_render_product("/World/Room"), "a Cube is not a sensor"),
        (lambda: rep.get_annotator(EXTRACT).attach(blank), "/Render/Blank is not a sensor; it reads OmniLidar"),
        (lambda: rep.writers.get("draw-point-cloud").attach(blank), "renders no sensor yet"),
        (lambda: rep.create_render_product("/World/Lidar", (1, 2, 3)), "is not (width, height)"),
        (lambda: rep.writers.get("RtxSensorDebugDrawPointClod"), 'did you mean "RtxSensorDebugDrawPointCloud"'),
        (lambda: rep.writers.get("draw-point-cloud").initialize(colour=1).attach(product), "writer draw-point-cloud:"),
    ):
        with pytest.raises(UserError) as caught:
            act()
        assert message in str(caught.value)
        assert isinstance(caught.value, ValueError)
        assert "\n" not in str(caught.value)


def test_a_stop_ends_the_annotators_of_a_product_made_while_playing(app):
    app.play()
    cloud = rep.get_annotator(EXTRACT).attach(rep.create_render_product("/World/Lidar"))
    app.update(steps=12)
    assert len(cloud.get_data()["data"])

    app.stop()

    with pytest.raises(RuntimeError, match="a stop ended it"):
        cloud.get_data()


def test_a_registered_annotator_is_there_for_sensors_made_afterwards(app):
    lidar = Lidar("/World/Lidar", aux_output_level="FULL", app=app)
    before = LidarSensor(lidar)
    nearest = AnnotatorType(
        "test.Nearest",
        lambda reading: None if reading.frame is None else float(reading.frame.channel("distance").min()),
        lambda reading: {"distance"},
    )
    register_annotator_spec("nearest", nearest)
    register_annotator_spec("cloud", {"name": EXTRACT})
    try:
        sensor = LidarSensor(lidar, annotators=["nearest", "cloud"])
        with pytest.raises(ValueError, match="there is no annotator 'nearest'"):
            before.attach_annotators("nearest")
        with pytest.raises(ValueError, match="there is an annotator 'nearest' already"):
            register_annotator_spec("nearest", {"name": EXTRACT})
        with pytest.raises(ValueError, match='did you mean "IsaacExtractRTXSensorPointCloud"'):
            register_annotator_spec("other", {"name": "IsaacExtractRTXSensorPointClou"})
        app.play()
        app.update(steps=6)
        assert sensor.get_data("nearest") == (pytest.approx(5.0, abs=1e-4), {})
        points, info = sensor.get_data("cloud")
        assert points.shape == (360, 3)
        assert info["azimuth"].shape == (360,)
    finally:
        unregister_annotator_spec("nearest")
        unregister_annotator_spec("cloud")
        rep.AnnotatorRegistry.unregister_annotator("test.Nearest")
    with pytest.raises(ValueError, match="there is no annotator 'cloud'"):
        LidarSensor(lidar, annotators="cloud")
    unregister_annotator_spec("cloud")  # unknown ones are fine


def test_a_writer_may_be_a_class_with_annotators_of_its_own(app):
    class Collect(rep.Writer):
        def __init__(self, least=0):
            self.annotators = [rep.annotators.get("GenericModelOutput"), "StableIdMap"]
            self.data_structure = "renderProduct"
            self.least, self.seen = least, []

        def write(self, data):
            [(name, found)] = data["renderProducts"].items()
            gmo = parse_generic_model_output_data(found["GenericModelOutput"])
            if gmo.numElements >= self.least:
                self.seen.append((name, gmo.timestampNs, set(parse_stable_id_map_data(found["StableIdMap"]).values())))

    rep.WriterRegistry.register(Collect)
    try:
        with pytest.raises(ValueError, match="there is a writer 'Collect' already"):
            rep.WriterRegistry.register(Collect)
        product = rep.create_render_product("/World/Lidar")
        writer = rep.writers.get("Collect")
        with pytest.raises(AttributeError, match="attach it first"):
            _ = writer.seen
        writer.initialize(least=10).attach(product)
        sensor = LidarSensor(Lidar("/World/Lidar", aux_output_level="FULL", app=app))
        other = sensor.attach_writer("Collect")
        app.play()
        app.update(steps=12)
        writer.detach()
        sensor.detach_writer("Collect")
        assert product.sensor.demand.consumers() == {}
    finally:
        rep.WriterRegistry.unregister_writer("Collect")
    name = product.path.rpartition("/")[2]
    assert writer.seen == [(name, 0, {"/World/Room"}), (name, 100_000_000, {"/World/Room"})]
    assert [stamp for _, stamp, _ in other.seen] == [0, 100_000_000]


def test_a_writer_without_write_and_one_that_is_not_a_class_are_reported(app):
    class Silent(rep.Writer):
        annotators = ("GenericModelOutput",)

    with pytest.raises(ValueError, match="give a subclass of Writer"):
        rep.WriterRegistry.register(dict)
    rep.WriterRegistry.register(Silent)
    try:
        rep.writers.get("Silent").attach(rep.create_render_product("/World/Lidar"))
        app.play()
        with pytest.raises(NotImplementedError, match=r"Silent has no method write\(data\)"):
            app.update(steps=6)
    finally:
        rep.WriterRegistry.unregister_writer("Silent")


def test_a_writer_gets_every_frame_between_attach_and_detach(app):
    seen = []
    register_writer_spec("collect", WriterSpec(lambda: seen.append, channels=frozenset({"xyz", "distance"})))
    try:
        writer = rep.writers.get("collect")
        product = rep.create_render_product("/World/Lidar")
        writer.attach([product])
        app.play()
        app.update(steps=12)
        writer.detach()
        writer.detach()
        app.update(steps=12)
    finally:
        unregister_writer_spec("collect")
    assert [frame.timestamp_ns for frame in seen] == [0, 100_000_000]
    assert set(seen[0].arrays) == {"xyz", "distance"}
    assert product.sensor.demand.consumers() == {}
