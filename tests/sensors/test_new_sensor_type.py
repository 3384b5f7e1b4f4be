"""A new modality in one file: a thermometer of one pixel, registered here and used everywhere sensors are.

The air is 20 degC at height 0 and 0.5 degC colder with every metre. The probe hangs on a ball that falls from 10 m:
after n physics steps of dt it has fallen g dt^2 n (n + 1) / 2 (MuJoCo steps the velocity first).
"""

import json
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

import sensors
import sensors.replicator as rep
from graph.base.errors import UserError
from graph.cli.main import main
from graph.node import Attribute, Database, node_type
from graph.node.registry import DEFAULT
from graph.sim import App
from graph.sim.usd import Gf, Sdf, UsdGeom
from nodes.lidar.frames import RENDER_PRODUCT, Reader, attach, read_frame, release
from sensors import AnnotatorType, Channel, Measurement, SensorRuntime, SensorType
from sensors.channels import CHANNELS
from sensors.prim import read_tick_rate
from sensors.writers import WriterSpec
from tests.support.places import ROOT

PROBE = "/World/Ball/Probe"
GROUND = 20.0
LAPSE = 0.5


class ThermometerRuntime(SensorRuntime[float]):
    """Measures the air at the height of its prim [degC]; its configuration is the temperature at height 0."""

    type_name = "Thermometer"

    def read(self, prim):
        return GROUND if not prim.HasAttribute("ground") else prim.GetAttribute("ground").Get()

    def measure(self, tick):
        height = self.pose(tick.poses)[2, 3]
        return Measurement({"temperature": np.array([self.config - LAPSE * height], np.float32)})


class Log:
    """A writer that keeps what it is given."""

    def __init__(self):
        self.seen = []

    def __call__(self, frame):
        self.seen.append((frame.timestamp_ns, float(frame.channel("temperature")[0])))


def problems(prim):
    if read_tick_rate(prim) > 1000:
        yield f"{prim.GetPath()}: a thermometer cannot tick at more than 1000 Hz"


THERMOMETER = SensorType(
    "Thermometer",
    ThermometerRuntime,
    channels=[Channel("temperature", np.dtype("<f4"), unit="degC", doc="temperature of the air")],
    annotators=[
        AnnotatorType(
            "Temperature",
            lambda reading: None if reading.frame is None else float(reading.frame.channel("temperature")[0]),
            lambda reading: ("temperature",),
        )
    ],
    writers={"TemperatureLog": WriterSpec(Log, channels=frozenset({"temperature"}))},
    attributes={"ground": "double"},
    example='attributes: {"omni:sensor:tickRate": 20}',
    check=problems,
    facts=lambda app, prim: {"tick_rate_hz": read_tick_rate(prim)},
    rows=lambda facts: [("rates", f"tick {facts['tick_rate_hz']} Hz")],
)

SCENE = {
    "/World/Ball": {"type": "Sphere", "radius": 0.1, "translate": [0, 0, 10], "rigid_body": True, "mass": 1.0},
    PROBE: {"type": "Thermometer", "schemas": ["OmniSensorAPI"], "attributes": {"omni:sensor:tickRate": 20}},
}

FILE = {
    "tickgraph": 1,
    "scene": {"prims": SCENE},
    "clock": {"physics_hz": 240, "loop_hz": 60},
    "duration": 0.2,
    "graphs": {
        "/World/Make": {
            "nodes": {
                "tick": "OnPlaybackTick",
                "product": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": PROBE}},
            },
            "connections": ["tick.tick -> product.execIn"],
        },
        "/World/Frames": {
            "pipeline_stage": "post_render",
            "nodes": {"read": "test.sensors.ReadTemperature"},
            "connections": ["/World/Make/product.outputs:renderProductPath -> read.renderProductPath"],
        },
    },
}


def air(steps):
    """The temperature after so many steps of 1/240 s."""
    fallen = 9.81 / 240**2 * steps * (steps + 1) / 2
    return GROUND - LAPSE * (10 - fallen)


TICKS = [(50_000_000 * k, pytest.approx(air(12 * k), abs=1e-5)) for k in (1, 2, 3, 4)]
"""(stamp, temperature): a tick every 1/20 s is one every 12 steps; the frame shows the instant of its update."""


@pytest.fixture(autouse=True)
def thermometer():
    sensors.register_sensor_type(THERMOMETER)
    yield
    sensors.unregister_sensor_type("Thermometer")


@pytest.fixture
def readings():
    """What the post-render node reads, by registering it."""
    found = []

    def wanted(db):
        return ("temperature",)

    @node_type(
        "test.sensors.ReadTemperature",
        inputs={
            "exec": Attribute("execution", "reads"),
            "dataPtr": Attribute("uint64", "a frame", default=0),
            "cudaDeviceIndex": Attribute("int", "always -1", default=-1),
            "renderProductPath": RENDER_PRODUCT,
        },
        outputs={"temperature": Attribute("float", "temperature", unit="degC")},
        memory=Reader,
        release=release,
        prepare=lambda db: attach(db, wanted),
    )
    def read(db: Database) -> None:
        """Reads the newest frame."""
        frame = read_frame(db, wanted)
        db.outputs.temperature = float(frame.channel("temperature")[0])
        found.append((frame.timestamp_ns, db.outputs.temperature))

    yield found
    DEFAULT.remove("test.sensors.ReadTemperature")


@pytest.fixture
def file(tmp_path, readings):
    path = tmp_path / "probe.json"
    path.write_text(json.dumps(FILE))
    return path


@pytest.fixture
def app():
    with App(None, physics_hz=240, loop_hz=60) as app:
        ball = {name: keys for name, keys in SCENE.items() if name != PROBE}
        app.add_prims(ball)
        probe = app.stage.DefinePrim(PROBE, "Thermometer")
        probe.AddAppliedSchema("OmniSensorAPI")
        probe.GetAttribute("omni:sensor:tickRate").Set(20.0)
        yield app


def test_it_runs_in_a_graph_file_and_stands_in_the_report(file, tmp_path, readings, capsys):
    assert main(["run", str(file), "--out", str(tmp_path / "out"), "--strict"]) == 0, capsys.readouterr().err
    assert readings == TICKS
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    told = report["sensors"][PROBE]
    assert (told["tick_rate"], told["frames"], told["missed"], told["elements"]) == (20.0, 4, 0, 4)
    assert (told["first_frame_ns"], told["last_frame_ns"]) == (50_000_000, 200_000_000)
    assert report["silent"] == []


PLACED = {
    "/Probe": {
        "type": "Thermometer",
        "schemas": ["OmniSensorAPI"],
        "translate": [1, 0, 4],
        "attributes": {"omni:sensor:tickRate": 20},
    }
}
AT_4_M = GROUND - LAPSE * 4


def test_a_prim_without_a_parent_has_the_place_that_the_file_gives_it(tmp_path, readings):
    text = json.dumps(FILE | {"scene": {"prims": PLACED}}).replace(PROBE, "/Probe")
    (tmp_path / "probe.json").write_text(text)
    assert main(["run", str(tmp_path / "probe.json"), "--strict"]) == 0
    assert [value for _, value in readings] == [AT_4_M] * 4


def test_a_prim_of_a_usd_scene_has_the_place_that_the_scene_gives_it(tmp_path, readings):
    (tmp_path / "probe.usda").write_text(
        '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n'
        'def Thermometer "Probe" (prepend apiSchemas = ["OmniSensorAPI"])\n{\n'
        "    float omni:sensor:tickRate = 20\n    double3 xformOp:translate = (1, 0, 4)\n"
        '    uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    )
    text = json.dumps(FILE | {"scene": {"usd": "probe.usda"}}).replace(PROBE, "/Probe")
    (tmp_path / "probe.json").write_text(text)
    assert main(["run", str(tmp_path / "probe.json"), "--strict"]) == 0
    assert [value for _, value in readings] == [AT_4_M] * 4


@pytest.mark.parametrize("first", ["the type", "the App"])
def test_a_prim_is_placed_from_python_whether_the_type_or_the_app_was_there_first(first):
    if first == "the App":
        sensors.unregister_sensor_type("Thermometer")
    with App() as app:
        if first == "the App":
            sensors.register_sensor_type(THERMOMETER)
        probe = app.stage.DefinePrim("/Probe", "Thermometer")
        assert UsdGeom.XformCommonAPI(probe).SetTranslate(Gf.Vec3d(1, 0, 4))
        product = rep.create.render_product("/Probe", (1, 1))
        annotator = rep.get_annotator("Temperature")
        annotator.attach([product])
        app.play()
        app.update(3)
        assert annotator.get_data() == AT_4_M


def test_explain_shows_its_facts_schedule_and_consumer(file, capsys):
    assert main(["explain", str(file)]) == 0
    out = capsys.readouterr().out
    shown = out[out.index(PROBE) :].split("\n\n")[0]
    assert f"{PROBE} (Thermometer)" in shown
    assert "tick 20 Hz" in shown
    assert "one frame a tick" in shown
    assert "0.05 s (update 2), 0.1 s (update 5), 0.15 s (update 8), ..." in shown
    assert "4 in 0.2 s" in shown
    assert "/World/Frames/read: temperature" in shown


def test_inspect_shows_a_frame(file, capsys):
    assert main(["inspect", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["sensor"], told["update"], told["header"]["timestampNs"]) == (PROBE, 2, 50_000_000)
    channel = told["channels"]["temperature"]
    assert (channel["dtype"], channel["unit"], channel["shape"]) == ("float32", "degC", [1])
    assert channel["min"] == pytest.approx(air(12), abs=1e-5)


def test_check_says_what_is_wrong_with_its_prim(file, capsys):
    fast = json.loads(json.dumps(FILE))
    fast["scene"]["prims"][PROBE]["attributes"]["omni:sensor:tickRate"] = 2000
    file.write_text(json.dumps(fast))
    assert main(["check", str(file)]) == 2
    assert "a thermometer cannot tick at more than 1000 Hz" in capsys.readouterr().err


def test_a_graph_file_takes_the_attributes_that_its_type_declares(file, readings):
    warmer = json.loads(json.dumps(FILE))
    warmer["scene"]["prims"][PROBE]["attributes"]["ground"] = GROUND + 5
    file.write_text(json.dumps(warmer))
    assert main(["run", str(file)]) == 0
    assert readings == [(stamp, pytest.approx(air(12 * k) + 5, abs=1e-5)) for k, (stamp, _) in enumerate(TICKS, 1)]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"attributes": {"grund": 1}}, "Thermometer has no attribute 'grund'; did you mean \"ground\"?"),
        ({"attributes": {"ground": "warm"}}, f"{PROBE}: attributes: ground: 'warm' is not a number"),
        ({"ground": 1}, f'{PROBE}: there is no key "ground"; did you mean attributes: {{"ground": 1}}?'),
        ({"attributes": {"zzz": 1}}, "Thermometer has no attribute 'zzz'; its own are "),
    ],
)
def test_what_its_type_does_not_declare_is_refused_with_a_name_that_is_near(file, capsys, keys, message):
    wrong = json.loads(json.dumps(FILE))
    wrong["scene"]["prims"][PROBE] |= keys
    file.write_text(json.dumps(wrong))
    assert main(["check", str(file)]) == 2
    assert message in capsys.readouterr().err


def test_an_attribute_that_is_declared_with_no_type_of_usd_is_told(tmp_path, capsys):
    sensors.unregister_sensor_type("Thermometer")
    sensors.register_sensor_type(SensorType("Thermometer", ThermometerRuntime, attributes={"ground": "dubble"}))
    path = tmp_path / "probe.json"
    scene = {"prims": {"/World/Probe": {"type": "Thermometer", "attributes": {"ground": 1}}}}
    path.write_text(json.dumps({"tickgraph": 1, "scene": scene, "graphs": {}}))
    assert main(["check", str(path)]) == 2
    told = "/World/Probe: attributes: ground: its sensor type declares it as 'dubble'; declare a USD type"
    assert told in capsys.readouterr().err


def test_keys_of_sensors_take_it_and_refuse_what_is_not_a_sensor_naming_it(file, capsys):
    excluding = json.loads(json.dumps(FILE))
    excluding["scene"]["prims"][PROBE] |= {"exclude": "/World/Ball", "aux_output_level": "BASIC"}
    file.write_text(json.dumps(excluding))
    assert main(["check", str(file)]) == 0, capsys.readouterr().err
    excluding["scene"]["prims"]["/World/Ball"]["exclude"] = PROBE
    file.write_text(json.dumps(excluding))
    assert main(["check", str(file)]) == 2
    error = capsys.readouterr().err
    assert "only sensors exclude what they never hit (OmniLidar, " in error
    assert "Thermometer" in error


def test_attributes_written_while_playing_count_in_the_next_update(app):
    product = rep.create_render_product(PROBE)
    annotator = rep.get_annotator("Temperature").attach(product)
    ground = app.stage.GetPrimAtPath(PROBE).CreateAttribute("ground", Sdf.ValueTypeNames.Double)
    ground.Set(GROUND)
    app.play()
    app.update(steps=3)
    assert annotator.get_data() == pytest.approx(air(12), abs=1e-5)
    ground.Set(GROUND + 5)
    app.update(steps=3)
    assert annotator.get_data() == pytest.approx(air(24) + 5, abs=1e-5)


def test_an_annotator_and_a_writer_of_its_own_get_its_frames(app):
    product = rep.create_render_product(PROBE)
    annotator = rep.get_annotator("Temperature").attach(product)
    log = rep.writers.get("TemperatureLog").attach(product)
    assert annotator.get_data() is None
    app.play()
    app.update(steps=12)
    assert annotator.get_data() == pytest.approx(air(48), abs=1e-5)
    assert log.seen == TICKS
    assert "Temperature" in rep.AnnotatorRegistry.get_registered_annotators()
    assert "TemperatureLog" in rep.WriterRegistry.get_writers()


def test_what_it_does_not_measure_is_refused_by_name(app):
    product = rep.create_render_product(PROBE)
    for name in ("IsaacExtractRTXSensorPointCloud", "GenericModelOutput"):
        with pytest.raises(UserError, match=f"{PROBE}: Thermometer does not measure .*; it measures temperature"):
            rep.get_annotator(name).attach(product)
    with pytest.raises(UserError, match="Thermometer does not measure xyz"):
        rep.writers.get("draw-point-cloud").attach(product)
    with pytest.raises(UserError, match="/World/Ball/Probe is Thermometer; it reads OmniLidar only"):
        rep.get_annotator("IsaacComputeRTXLidarFlatScan").attach(product)
    assert product.sensor.consumers() == {}


def test_its_attributes_count_again_at_each_play(app):
    product = rep.create_render_product(PROBE)
    annotator = rep.get_annotator("Temperature").attach(product)
    app.stage.GetPrimAtPath(PROBE).GetAttribute("omni:sensor:tickRate").Set(60.0)
    app.play()
    app.update(steps=1)
    assert (product.frames, annotator.get_data()) == (1, pytest.approx(air(4), abs=1e-5))


def test_a_delayed_frame_comes_in_the_first_update_after_its_delay_as_it_was_measured(app):
    """30 ms after 50 ms is 80 ms: the fifth update of 1/60 s (83.3 ms), index 4; then one every third update."""
    product = rep.create_render_product(PROBE)
    product.sensor = sensors.Delayed(product.sensor, seconds="0.03")
    log = rep.writers.get("TemperatureLog").attach(product)
    app.play()
    came = []
    for update in range(12):
        app.update()
        if product.new_frame:
            came.append(update)
    assert came == [4, 7, 10]
    assert log.seen == TICKS[:3]


def test_a_delay_in_ticks_is_that_many_periods(app):
    product = rep.create_render_product(PROBE)
    product.sensor = sensors.Delayed(product.sensor, ticks=2)
    assert product.sensor.latency == Fraction(1, 10)
    log = rep.writers.get("TemperatureLog").attach(product)
    app.play()
    app.update(steps=12)
    assert log.seen == TICKS[:2]
    for wrong in ({}, {"seconds": -1}, {"seconds": 1, "ticks": 1}, {"ticks": -1}, {"seconds": "soon"}):
        with pytest.raises(UserError, match=PROBE):
            sensors.Delayed(product.sensor, **wrong)


def test_noise_is_the_same_in_each_play_and_another_with_another_seed(app):
    def spoilt(seed):
        product = rep.create_render_product(PROBE)
        inner = product.sensor
        product.sensor = sensors.Corrupted(
            inner, {"temperature": lambda value, rng: value + rng.normal(0.0, 0.5, value.shape)}, seed=seed
        )
        log = rep.writers.get("TemperatureLog").attach(product)
        app.play()
        app.update(steps=12)
        app.stop()
        log.detach()
        product.sensor = inner
        return [value for _, value in log.seen]

    first, again, other = spoilt(1), spoilt(1), spoilt(2)
    assert first == again
    assert first != other
    errors = np.array(first) - [air(12 * k) for k in (1, 2, 3, 4)]
    assert 0 < np.abs(errors).max() < 2.5  # five standard deviations


def test_a_callback_gets_the_next_frame_only_or_all_until_it_is_ended(app):
    product = rep.create_render_product(PROBE)
    one, some = [], []
    sensors.on_frame(product, one.append, channels=("temperature",), once=True)
    end = sensors.on_frame(product.path, some.append, channels=("temperature",))
    app.play()
    app.update(steps=6)
    end()
    app.update(steps=6)
    assert [frame.timestamp_ns for frame in one] == [50_000_000]
    assert [frame.timestamp_ns for frame in some] == [50_000_000, 100_000_000]
    assert product.sensor.consumers() == {}


def test_names_that_are_taken_are_refused_and_leave_nothing_behind():
    for taken, message in (
        (THERMOMETER, "there is a sensor type 'Thermometer' already"),
        (
            SensorType("Other", ThermometerRuntime, annotators=[AnnotatorType("StableIdMap", lambda reading: None)]),
            "Other: there is an annotator 'StableIdMap' already",
        ),
        (
            SensorType("Other", ThermometerRuntime, channels=[Channel("xyz", np.dtype("<f8"))]),
            "Other: there is a channel 'xyz' already",
        ),
        (
            SensorType("Other", ThermometerRuntime, writers={"RtxSensorDebugDrawPointCloud": WriterSpec(Log)}),
            "Other: there is a writer 'RtxSensorDebugDrawPointCloud' already",
        ),
    ):
        with pytest.raises(UserError, match=message):
            sensors.register_sensor_type(taken)
    sensors.unregister_sensor_type("Thermometer")
    assert "temperature" not in CHANNELS
    with pytest.raises(UserError, match="there is no annotator 'Temperature'"):
        rep.get_annotator("Temperature")
    sensors.register_sensor_type(THERMOMETER)


def test_an_installed_package_brings_its_sensor_type_by_an_entry_point(tmp_path):
    info = tmp_path / "thermal-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: thermal\nVersion: 1.0\n")
    here = "tests.sensors.test_new_sensor_type:THERMOMETER"
    (info / "entry_points.txt").write_text(f"[tickgraph.sensors]\nbroken = no_such_library:SENSOR\nthermal = {here}\n")
    code = "from sensors.sensor_types import sensor_types; print(*sensor_types())"
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=True
    )
    assert {"OmniLidar", "Camera", "Thermometer"} <= set(done.stdout.split())
    assert "warning sensor-package: broken (no_such_library:SENSOR): ModuleNotFoundError" in done.stderr


def test_exclude_hides_prims_from_a_sensor_and_refuses_what_is_not_there(app):
    app.stage.DefinePrim("/World/Lidar", "OmniLidar")
    lidar = sensors.Lidar("/World/Lidar", app=app)
    sensors.exclude(lidar, ["/World/Ball"], app=app)
    relationship = lidar.prim.GetRelationship("tickgraph:exclude")
    assert [str(path) for path in relationship.GetTargets()] == ["/World/Ball"]
    sensors.exclude("/World/Lidar", (), app=app)
    assert relationship.GetTargets() == []
    with pytest.raises(UserError, match='exclude: there is no prim /World/Bal; did you mean "/World/Ball"'):
        sensors.exclude("/World/Lidar", "/World/Bal", app=app)
    with pytest.raises(UserError, match="/World/Ball is not a sensor prim"):
        sensors.exclude("/World/Ball", "/World/Lidar", app=app)


def test_the_enums_of_generic_model_output_are_public():
    assert (sensors.Modality.LIDAR, sensors.CoordsType.SPHERICAL, sensors.ElementFlags.VALID) == (1, 1, 64)
    assert sensors.AuxType.FULL > sensors.AuxType.EXTRA


def test_the_example_of_the_readme_measures(app):
    """At tickRate 20 the first tick is after 12 steps; 15 degC less 0.0065 degC for each metre of height."""
    sensors.unregister_sensor_type("Thermometer")
    text = (ROOT / "sensors" / "README.md").read_text(encoding="utf8")
    exec(text.partition("```python\n")[2].partition("```")[0], {"__name__": "readme"})
    annotator = rep.get_annotator("Temperature").attach(rep.create_render_product(PROBE))
    app.play()
    app.update(steps=3)
    height = 10 - 9.81 / 240**2 * 12 * 13 / 2
    assert annotator.get_data() == pytest.approx(15.0 - 0.0065 * height, abs=1e-5)


def test_add_prims_takes_sensors_as_a_graph_file_does():
    """A type without a USD schema has a transform; a lidar takes its configuration."""
    with App() as app:
        app.add_prims(
            {"/T": {"type": "Thermometer", "translate": [1, 2, 3]}, "/L": {"type": "OmniLidar", "config": "OS1"}}
        )
        assert app.fabric.world_matrix("/T")[:3, 3].tolist() == [1, 2, 3]
        assert app.stage.GetPrimAtPath("/L").GetAttribute("omni:sensor:Core:scanType").Get() == "ROTARY"
