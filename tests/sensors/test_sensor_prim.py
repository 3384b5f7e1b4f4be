"""What the authoring classes of all sensors take, and how they refuse the rest: one line that says what to give."""

import pytest
from pxr import Sdf

from graph.base.errors import UserError
from graph.sim import App
from sensors import CameraSensor, Lidar, LidarSensor, Radar, RadarSensor, RtxCamera

pytest.importorskip("wings.acoustic")
from wings.acoustic import Acoustic, AcousticSensor

SCANS = "OmniSensorGenericRadarWpmDmatScanCfgAPI"
AUTHORS = {Lidar: "lidar", Radar: "radar", Acoustic: "acoustic sensor", RtxCamera: "camera"}


@pytest.fixture
def app():
    with App(None, physics_hz=60, loop_hz=60) as app:
        yield app


@pytest.mark.parametrize("author", AUTHORS)
def test_a_path_is_text_or_of_usd_or_a_list_of_one(app, author):
    for number, path in enumerate(("/World/A0", Sdf.Path("/World/A1"), ["/World/A2"])):
        assert author(path, app=app).paths == [f"/World/A{number}"]
    assert author.create(["/World/A0"], app=app).path == "/World/A0"


@pytest.mark.parametrize(("author", "word"), AUTHORS.items())
@pytest.mark.parametrize("make", ["__call__", "create"])
def test_what_is_no_path_or_several_is_a_value_error_in_a_line(app, author, word, make):
    made = author if make == "__call__" else author.create
    for path, message in (
        (None, "None is not the path of a prim, such as /World/Sensor"),
        (3, "3 is not the path of a prim"),
        ([3], "3 is not the path of a prim"),
        (["/World/A", "/World/B"], f"2 paths are given; a {word} is exactly one prim"),
        ([], "0 paths are given"),
    ):
        with pytest.raises(ValueError, match=message) as refused:
            made(path, app=app)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("sensor", "wrong"), [(RadarSensor, Lidar), (LidarSensor, Radar), (AcousticSensor, Radar)])
def test_a_sensor_of_another_kind_is_not_a_path(app, sensor, wrong):
    with pytest.raises(ValueError, match=f"a {wrong.__name__} is not the path of a prim"):
        sensor(wrong("/World/Other", app=app), app=app)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"schemas": SCANS}, f"the schema {SCANS} comes in instances; give one, such as {SCANS}:s002"),
        ({"schemas": ["OmniSensorAPI:a"]}, "the schema OmniSensorAPI has no instances; leave :a out"),
        ({"attributes": [1]}, "attributes are a mapping of names to values, not list"),
        ({"usd_path": 3}, "usd_path 3 is not the path of a file"),
        ({"config": 3}, "config 3 is not a name"),
    ],
)
def test_wrong_arguments_are_value_errors(app, options, message):
    with pytest.raises(ValueError, match=message):
        Radar.create("/World/Radar", app=app, **options)


def test_one_schema_may_stand_alone(app):
    assert [scan.name for scan in Radar("/World/Radar", schemas=f"{SCANS}:s002", app=app).config.scans] == [
        "s001",
        "s002",
    ]


def test_an_asset_may_be_given_as_a_path_object(app, tmp_path):
    file = tmp_path / "radar.usda"
    file.write_text('#usda 1.0\n(defaultPrim = "R")\ndef OmniRadar "R" {\n    float omni:sensor:tickRate = 7\n}\n')
    assert Radar.create("/World/Radar", usd_path=file, app=app).tick_rate == 7


def test_names_of_annotators_are_text_and_each_missing_one_is_told(app):
    radar = Radar("/World/Radar", app=app)
    for names in (3, [3], [["generic-model-output"]]):
        with pytest.raises(ValueError, match="is not a name; give one such as generic-model-output"):
            RadarSensor(radar, annotators=names)
    sensor = RadarSensor(radar)
    sensor.detach_annotators("generic-model-output")
    sensor.detach_writer("draw-point-cloud")
    told = [warning.message for warning in app.warnings if warning.code == "not-attached"]
    assert told == ["annotator 'generic-model-output' is not attached", "writer 'draw-point-cloud' is not attached"]


def test_arguments_have_the_names_of_isaac_sim(app):
    sensor = RadarSensor(path="/World/Radar", annotators="generic-model-output", app=app)
    assert sensor.get_data(annotator="generic-model-output")[0] is None
    assert sensor.attach_writer(writer_name="draw-point-cloud", size=0.2) is not None
    for kind, path in ((LidarSensor, "/World/Lidar"), (AcousticSensor, "/World/Acoustic")):
        assert kind(path=path, app=app).authoring_object.path == path
    assert CameraSensor(path="/World/Camera", resolution=(4, 4), app=app).camera.paths == ["/World/Camera"]


@pytest.mark.parametrize(
    ("kind", "level", "levels"),
    [("OmniRadar", "FULL", "NONE and BASIC"), ("OmniAcoustic", "EXTRA", "NONE and BASIC"), ("Camera", "BASIC", "NONE")],
)
def test_a_level_that_such_a_sensor_does_not_have_is_refused_in_a_file_too(tmp_path, kind, level, levels):
    file = tmp_path / "g.yaml"
    file.write_text(f"tickgraph: 1\nscene:\n  prims:\n    /S: {{type: {kind}, aux_output_level: {level}}}\n")
    with pytest.raises(UserError, match=rf"g.yaml:4:\d+: /S: aux_output_level: {kind} has {levels}, not {level}"):
        App.from_file(file)
