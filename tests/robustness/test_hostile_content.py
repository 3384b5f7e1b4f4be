"""Files that fuzzing found, each ending in one line that says what, where and what to do, without a traceback."""

import json

import numpy as np
import pytest
from mcap.records import Channel, Metadata

from graph.base.errors import UserError
from graph.cli.main import main
from graph.recording.contents.scans import Scan
from graph.recording.mcap_sink import McapSink
from graph.recording.mcap_source import McapSource
from graph.recording.recovery import finish
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain
from graph.sim.usd import Sdf, Usd
from sensors.camera.image_files import ImageFiles
from sensors.camera.tables import read_table
from tests.support.without_wing import needs_wing

HEAD = '#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n)\n'
SONAR = "omni:sensor:WpmAcoustic:"
TABLE = "omni:lensdistortion:lut:rayEnterDirectionTexture"


@pytest.fixture
def said(tmp_path, capfd, monkeypatch):
    """Runs a command in a folder of its own; gives its exit code and the lines on stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*command):
        code = main(list(command))
        return code, capfd.readouterr().err.splitlines()

    return run


def graph_file(prims=None, nodes=None, connections=()):
    graphs = {"/World/G": {"nodes": nodes, "connections": list(connections)}} if nodes else {}
    return json.dumps({"tickgraph": 1, "scene": {"prims": prims or {}}, "graphs": graphs})


@needs_wing("acoustic")
@pytest.mark.parametrize(
    ("attributes", "wrong"),
    [
        ({f"{SONAR}sampleDuration": 3.4e38}, f"{SONAR}sampleDuration is 3.3999999521443642e+38; give at most 1"),
        ({f"{SONAR}pulseDuration": 2.0}, f"{SONAR}pulseDuration is 2.0; give at most 1"),
    ],
)
def test_a_sonar_whose_frame_outlasts_its_stamps_is_refused(said, tmp_path, attributes, wrong):
    prim = {"type": "OmniAcoustic", "schemas": "OmniSensorGenericAcousticWpmAPI", "attributes": attributes}
    (tmp_path / "g.json").write_text(graph_file({"/World/Sonar": prim}))
    assert said("check", "g.json") == (2, [f"g.json:1:38: /World/Sonar.{wrong}"])


def test_a_lens_of_tables_without_a_table_is_refused_when_it_is_checked(said, tmp_path):
    lens = {"omni:lensdistortion:model": "lut"}
    prim = {"type": "Camera", "schemas": "OmniLensDistortionLutAPI", "attributes": lens}
    (tmp_path / "g.json").write_text(graph_file({"/World/Camera": prim}))
    wrong = f"g.json:1:38: /World/Camera.{TABLE} names no file; give it the OpenEXR file of directions"
    assert said("check", "g.json") == (2, [wrong])


def test_what_openexr_prints_of_a_damaged_table_is_not_shown(tmp_path, capfd):
    """The pixels end in 0xff: the library prints that it cannot decode them."""
    library = pytest.importorskip("OpenEXR")
    file = tmp_path / "t.exr"
    planes = {name: np.ones((16, 16), np.float32) for name in "RGB"}
    header = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    library.File(header, planes).write(str(file))
    data = file.read_bytes()
    file.write_bytes(data[:-8] + b"\xff" * 8)
    stage = Usd.Stage.CreateInMemory()
    attribute = stage.DefinePrim("/C").CreateAttribute("table", Sdf.ValueTypeNames.Asset)
    attribute.Set(Sdf.AssetPath(str(file)))
    with pytest.raises(UserError, match=r"^/C.table: t.exr "):
        read_table(attribute.GetPrim(), "table", ImageFiles(None))
    assert capfd.readouterr() == ("", "")


def test_a_sensor_s_attribute_of_another_type_is_named(said, tmp_path):
    text = 'def OmniLidar "L" {\n token omni:sensor:Core:rangesMinM = "near"\n int omni:sensor:tickRate = 10\n}\n'
    (tmp_path / "s.usda").write_text(HEAD + text)
    wrong = "graph: s.usda: /L.omni:sensor:Core:rangesMinM is a token; it must be a float[]"
    assert said("check", "s.usda") == (2, [wrong])


def test_a_transform_of_another_type_or_without_a_name_is_left_out(said, tmp_path):
    text = (
        'def Cube "C" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {\n'
        " float2 xformOp:scale = (1, 2)\n double3 xformOp:translate = (0, 0, 9)\n"
        ' uniform token[] xformOpOrder = ["", "xformOp:translate", "xformOp:scale"]\n}\n'
    )
    (tmp_path / "s.usda").write_text(HEAD + text)
    warned = 'warning bad-transform-op: /C: its transform names "", xformOp:scale (a float2); that is left out'
    assert said("run", "s.usda", "--updates", "1") == (0, [warned])


def test_a_velocity_of_another_type_is_named_also_where_it_is_only_sampled(said, tmp_path):
    text = (
        'def Cube "C" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {\n int physics:velocity.timeSamples = {0: 3}\n}\n'
    )
    (tmp_path / "s.usda").write_text(HEAD + text)
    wrong = "graph: /C.physics:velocity is a int; it must be a vector3f"
    assert said("run", "s.usda", "--updates", "1") == (2, [wrong])


def test_a_collider_whose_size_is_no_number_is_left_out(said, tmp_path):
    schemas = '["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]'
    text = f'def Cube "C" (prepend apiSchemas = {schemas}) {{\n float3 size = (1, 1, 1)\n}}\n'
    (tmp_path / "s.usda").write_text(HEAD + text)
    code, lines = said("run", "s.usda", "--updates", "1")
    assert code == 0
    assert "warning bad-collider: /C: its sizes are not all finite numbers; nothing hits it" in lines


def test_units_beyond_the_universe_are_refused(said, tmp_path):
    (tmp_path / "s.usda").write_text(HEAD.replace("metersPerUnit = 1", "metersPerUnit = 1e300"))
    code, lines = said("check", "s.usda")
    assert code == 2
    assert [line.rpartition(": ")[2] for line in lines] == ["metersPerUnit is 1e+300; give 1e-18 to 1e18"]


def test_what_usd_says_while_a_scene_plays_is_a_warning(said, tmp_path):
    """A joint of a referenced asset whose body lies outside that asset."""
    joint = 'def Xform "A" {\n def PhysicsFixedJoint "J" {\n rel physics:body0 = </Elsewhere>\n }\n}\n'
    (tmp_path / "asset.usda").write_text(HEAD.replace("(\n", '(\n defaultPrim = "A"\n', 1) + joint)
    (tmp_path / "s.usda").write_text(HEAD + 'def "W" (references = @asset.usda@) {\n}\n')
    code, lines = said("run", "s.usda", "--updates", "1")
    assert code == 0
    assert [line.split(": ")[0] for line in lines] == ["warning usd-composition"]
    assert "In </W/J.physics:body0>" in lines[0]


def test_an_explanation_finds_makers_that_name_no_camera(said, tmp_path):
    nodes = {"tick": "OnPlaybackTick", "late": {"type": "IsaacAttachHydraTexture", "inputs": {}}}
    (tmp_path / "g.json").write_text(graph_file({"/World/Camera": {"type": "Camera"}}, nodes))
    assert said("explain", "g.json")[0] == 0


def test_a_message_stamped_before_zero_is_recorded(said, tmp_path):
    """-1 s in the header; MCAP's own times are unsigned."""
    nodes = {"tick": "OnPlaybackTick", "clock": {"type": "ROS2PublishClock", "inputs": {"timeStamp": -1.0}}}
    (tmp_path / "g.json").write_text(graph_file(None, nodes, ["tick.tick -> clock.execIn"]))
    assert said("run", "g.json", "--updates", "1", "--out", "out")[0] == 0
    (entry,) = McapSource(tmp_path / "out/run.mcap").read()
    assert entry.load().clock.sec == -1


@pytest.mark.parametrize("topics", [[], 1.5, "x", None, {"/a": None}])
def test_a_report_of_another_shape_does_not_hide_the_recording(said, tmp_path, topics):
    record(tmp_path / "run.mcap")
    (tmp_path / "report.json").write_text(json.dumps({"topics": topics}))
    assert said("info", ".") == (0, [])


@pytest.mark.parametrize("kind", [Metadata, Channel])
def test_a_damaged_record_outside_the_chunks_is_left_out_of_the_index(said, tmp_path, kind):
    """A channel or metadata of bytes that are not UTF-8, put behind the header: nothing else of the file is lost."""
    path = tmp_path / "run.mcap"
    record(path, {"seed": "0"})
    data = path.read_bytes()
    header_ends = 8 + 9 + int.from_bytes(data[9:17], "little")
    opcode = {Metadata: 0x0C, Channel: 0x04}[kind]
    bad = bytes([opcode]) + (12).to_bytes(8, "little") + b"\xff" * 12
    footer = data.rindex(bytes([0x0F]) + (4).to_bytes(8, "little"))
    path.write_bytes(data[:header_ends] + bad + data[header_ends:footer])
    left = finish(path)
    assert (left.messages, left.damaged) == (3, 1)
    assert len(list(McapSource(path).read())) == 3


@needs_wing("mjcf")
def test_what_qhull_prints_of_a_mesh_without_a_hull_is_not_shown(said, tmp_path):
    """A tetrahedron 3.4e38 m high: its volume is more than a float32 holds."""
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 3.4e38\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    asset = '<asset><mesh name="m" file="m.obj"/></asset>'
    body = '<worldbody><body><joint/><geom type="mesh" mesh="m"/></body></worldbody>'
    (tmp_path / "m.xml").write_text(f"<mujoco>{asset}{body}</mujoco>")
    (tmp_path / "g.json").write_text(json.dumps({"tickgraph": 1, "scene": {"mjcf": "m.xml"}}))
    code, lines = said("check", "g.json")
    assert code == 2
    assert [line.split(":")[0] for line in lines] == ["m.xml"]


def test_links_that_lead_to_themselves_or_to_nothing_are_named(said, tmp_path):
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    (tmp_path / "gone.yaml").symlink_to("nowhere.yaml")
    for name in ("loop.yaml", "gone.yaml"):
        assert said("check", name) == (2, [f"graph: {name} is a link to a file that is not there; correct the link"])
    code, lines = said("convert", "loop.yaml", "out.json")
    assert (code, len(lines)) == (2, 1)


def record(path, provenance=None):
    """Three messages."""
    bus, sink = MessageBus(), McapSink(path, provenance)
    bus.subscribe(sink)
    for number in range(3):
        bus.publish("/a", "geometry_msgs/msg/Twist", from_plain("geometry_msgs/msg/Twist", {}), number)
    bus.close()


@needs_wing("exports")
def test_points_of_any_distance_fit_into_las(tmp_path):
    """2^31 - 1 steps hold 3e38 m from 2e29 m on; the next power of ten is 1e30 m."""
    laspy = pytest.importorskip("laspy")
    from wings.exports.point_files import write_las

    points = np.zeros(2, [(axis, "f4") for axis in "xyz"])
    points["x"][1] = 3e38
    write_las(tmp_path / "a.las", Scan("/a", 0, 0, "lidar", points, None, None, None), points)
    np.testing.assert_allclose(laspy.read(tmp_path / "a.las").x, [0, 3e38], atol=1e30)
