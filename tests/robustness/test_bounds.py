"""Every limit of `graph.base.limits`: what is as large passes, what is one larger is refused in a line that names it.

Each case asks for an amount that is known on paper; the limit is set to that amount, and to one less.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import pytest
from mcap.writer import Writer
from PIL import Image

from graph.base import limits
from graph.base.limits import LIMITS
from graph.cli.main import main
from graph.sim.messages.ros_fields import from_plain
from graph.sim.messages.ros_types import serialize
from graph.sim.usd import Sdf, Usd, UsdGeom
from sensors.radar.config import ScanConfig
from tests.support.mcap_files import message, written
from tests.support.without_wing import MISSING_WINGS

BALL = {"/W/Ball": {"type": "Sphere", "rigid_body": True, "translate": [0, 0, 5]}}
LIDAR = {"/W/Lidar": {"type": "OmniLidar", "config": "Example_Rotary"}}
HEAD = '#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n)\n'
CASES: dict[str, tuple[str, Callable[..., Asked], tuple[str, ...]]] = {}
NUMBERS = count()


@dataclass(frozen=True)
class Asked:
    """An amount of what a limit counts, and the command that asks for it."""

    amount: int
    command: tuple[str, ...]


def case(name, *more):
    """Notes the function below as what asks for an amount of `name`; `more`: what else it is called with, each once."""

    def note(build):
        CASES.update(
            {f"{name} {one}" if more else name: (name, build, (one,) if more else ()) for one in more or ("",)}
        )
        return build

    return note


def graph_file(folder, name="g.json", **document):
    (folder / name).write_text(json.dumps({"tickgraph": 1, **document}))
    return str(folder / name)


def sweep(folder, *options):
    return ("sweep", graph_file(folder), *options, "--updates", "1", "--out", str(folder / f"c{next(NUMBERS)}"))


def run(file, *options):
    return ("run", file, "--updates", "1", *options)


def scene(folder, text):
    (folder / "s.usda").write_text(HEAD + text)
    return str(folder / "s.usda")


@case("file.yaml", "g.yaml", "m.yaml", "t.test.yaml")
@case("file.json", "g.json", "m.json")
def texts(folder, name):
    """100 bytes: a graph file, messages to play, tests; the graph file that plays the messages has no more."""
    tests = '{"tickgraph_tests": 1, "cases": {"a": {"node": "omni.graph.action.Countdown"}}}'
    start = {"g": '{"tickgraph": 1}', "m": "[]", "t": tests}[name[0]]
    (folder / name).write_text(start.ljust(100))
    command = run(graph_file(folder, "h.json"), "--play", str(folder / name))
    return Asked(100, command if name[0] == "m" else ("check", str(folder / name)))


@case("file.script")
def script(folder):
    """100 bytes of a script that is checked."""
    (folder / "s.py").write_text("x = 1\n".ljust(100))
    return Asked(100, ("check", str(folder / "s.py")))


@case("campaign.runs")
def campaign(folder):
    """Three seeds."""
    return Asked(3, sweep(folder, "--vary", "seed=0..2"))


@case("campaign.table")
def points(folder):
    """100 bytes: a column of one value."""
    (folder / "p.csv").write_text("seed\n1\n".ljust(100))
    return Asked(100, sweep(folder, "--points", str(folder / "p.csv")))


@case("file.keys", "g.json", "g.yaml")
def keys(folder, name):
    """tickgraph, settings, /a and /b."""
    return Asked(4, ("check", graph_file(folder, name, settings={"/a": 1, "/b": 2})))


@case("file.prims")
def prims(folder):
    """/W, /W/A, /W/A/B and /W/C."""
    return Asked(4, ("check", graph_file(folder, scene={"prims": {"/W/A/B": {}, "/W/C": {}}})))


@case("graph.nodes", "nodes", "instances")
def nodes(folder, what):
    """Three nodes; or as many in each of two prims' graphs."""
    graph = {"nodes": dict.fromkeys("abc", "Countdown")}
    if what == "instances":
        graph["instances"] = {"/W/A": {}, "/W/B": {}}
    scene = {"prims": {"/W/A": {}, "/W/B": {}}}
    return Asked(3 if what == "nodes" else 6, ("check", graph_file(folder, graphs={"/G": graph}, scene=scene)))


@case("graph.values")
def values(folder):
    """Two durations and one type, which is not a value."""
    node = 'def OmniGraphNode "{}" {{\n token node:type = "omni.graph.action.Countdown"\n int inputs:duration = 3\n}}\n'
    return Asked(2, ("check", scene(folder, f'def OmniGraph "G" {{\n{node.format("a")}{node.format("b")}}}\n')))


@case("usd.text")
def usd_text(folder):
    file = scene(folder, "")
    return Asked(Path(file).stat().st_size, ("check", file))


@case("usd.specs", "s.usda", "s.usdc")
def specs(folder, name):
    """The root, two prims and three attributes."""
    file = scene(folder, 'def "A" {\n int a\n int b\n}\ndef "B" {\n int a\n}\n')
    Sdf.Layer.FindOrOpen(file).Export(str(folder / name))
    return Asked(6, ("check", str(folder / name)))


@case("usd.prims", "written", "composed")
def usd_prims(folder, what):
    """Three prims; or, with the root, two below others: /A, /A/B, /C, /C/B."""
    text = 'def "A" {\n def "B" {\n }\n}\ndef "C"'
    if what == "composed":
        return Asked(5, ("check", scene(folder, f"{text} (references = </A>) {{\n}}\n")))
    return Asked(3, ("check", scene(folder, f"{text} {{\n}}\n")))


@case("physics.parts", "check", "run")
def physics_parts(folder, command):
    text = 'def Cube "{}" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {{\n}}\n'
    joint = 'def PhysicsRevoluteJoint "J" {\n rel physics:body0 = </A>\n rel physics:body1 = </B>\n}\n'
    file = scene(folder, text.format("A") + text.format("B") + joint)
    return Asked(3, ("check", file) if command == "check" else run(file))


@case("run.updates", "--updates", "--duration", "file")
def updates(folder, option):
    file = graph_file(folder, clock={"loop_hz": 3}, duration=1)
    length = {"--updates": "3", "--duration": "1"}.get(option)
    return Asked(3, ("run", file, option, length) if length else ("run", file))


@case("clock.steps")
def steps(folder):
    return Asked(200, run(graph_file(folder, clock={"physics_hz": 200, "loop_hz": 1}, scene={"prims": BALL})))


@case("physics.iterations", "knob", "scene", "model")
def iterations(folder, where):
    if where == "knob":
        return Asked(7, run(graph_file(folder, fidelity={"physics.iterations": 7}, scene={"prims": BALL})))
    if where == "scene":
        scene(folder, 'def PhysicsScene "P" {\n int mjc:option:iterations = 101\n}\n')
        return Asked(101, run(graph_file(folder, scene={"usd": "s.usda", "prims": BALL})))
    body = '<worldbody><body><freejoint/><geom size="1"/></body></worldbody>'
    (folder / "m.xml").write_text(f'<mujoco><option iterations="101"/>{body}</mujoco>')
    return Asked(101, run(graph_file(folder, scene={"mjcf": "m.xml"})))


def lidar_file(folder, prims=LIDAR, **document):
    nodes = {
        "tick": "OnPlaybackTick",
        "cloud": {"type": "ROS2RtxLidarHelper", "inputs": {"topicName": "c", "type": "point_cloud"}},
    }
    nodes["product"] = {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": "/W/Lidar"}}
    wires = ["tick.tick -> product.execIn", "product.execOut -> cloud.execIn"]
    wires.append("product.renderProductPath -> cloud.renderProductPath")
    graphs = {"/G": {"nodes": nodes, "connections": wires}}
    return graph_file(folder, graphs=graphs, **{"scene": {"prims": prims}, **document})


@case("lidar.rays", "emitters", "sub-rays")
def rays(folder, what):
    """4 emitters, 10 turns and 3600 firings a second: 1,440 rays a turn; twice as many with two sub-rays."""
    from tests.robustness.corpus import PROFILE

    (folder / "profile.json").write_text(json.dumps(PROFILE))
    lidar = {"/W/Lidar": {"type": "OmniLidar", "config": "profile.json"}}
    subrays = 2 if what == "sub-rays" else 1
    return Asked(1440 * subrays, run(lidar_file(folder, lidar, fidelity={"lidar.subrays": subrays})))


@case("camera.rays")
def samples(folder):
    """Of the one pixel that an image has at least."""
    return Asked(7, ("check", graph_file(folder, fidelity={"camera.samples": 7})))


@case("camera.texels")
def texels(folder):
    """A texture of 3 x 2."""
    Image.new("RGB", (3, 2)).save(folder / "t.png")
    file = scene(
        folder,
        """def Mesh "Face" (prepend apiSchemas = ["MaterialBindingAPI"]) {
 point3f[] points = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)]
 int[] faceVertexCounts = [3]
 int[] faceVertexIndices = [0, 1, 2]
 rel material:binding = </Look>
}
def DomeLight "Sky" {}
def Camera "Camera" { double3 xformOp:translate = (0, 0, 2)
 uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Material "Look" {
 token outputs:surface.connect = </Look/Surface.outputs:surface>
 def Shader "Surface" { uniform token info:id = "UsdPreviewSurface"
  color3f inputs:diffuseColor.connect = </Look/Texture.outputs:rgb>
  token outputs:surface
 }
 def Shader "Texture" { uniform token info:id = "UsdUVTexture"
  asset inputs:file = @t.png@
  float3 outputs:rgb
 }
}
""",
    )
    nodes = {
        "tick": "OnPlaybackTick",
        "product": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": "/Camera", "width": 4, "height": 4}},
        "image": {"type": "ROS2CameraHelper", "inputs": {"type": "rgb"}},
    }
    wires = ["tick.tick -> product.execIn", "product.execOut -> image.execIn"]
    wires.append("product.renderProductPath -> image.renderProductPath")
    graphs = {"/G": {"nodes": nodes, "connections": wires}}
    graph = graph_file(folder, graphs=graphs, scene={"usd": Path(file).name})
    return Asked(6, run(graph, "--updates", "3", "--out", str(folder / "out")))


def radar(folder):
    scan = "omni:sensor:WpmDmat:scan:s001:"
    prim = {"type": "OmniRadar", "attributes": {f"{scan}raysPerDeg": 0.5, f"{scan}maxRangeM": 50.0}}
    return ("check", graph_file(folder, scene={"prims": {"/W/Radar": prim}}))


@case("radar.rays")
def radar_rays(folder):
    """Half a ray for each degree of 150 x 40."""
    return Asked(75 * 20, radar(folder))


@case("radar.cells")
def radar_cells(folder):
    return Asked(ScanConfig().cells(), radar(folder))


@case("acoustic.rays")
def acoustic_rays(folder):
    """Half a ray for each degree of 90 x 60."""
    fan = {"omni:sensor:WpmAcoustic:raysPerDeg": 0.5, "omni:sensor:WpmAcoustic:elSpanDeg": 60.0}
    prim = {"type": "OmniAcoustic", "attributes": fan}
    return Asked(45 * 30, ("check", graph_file(folder, scene={"prims": {"/W/Sonar": prim}})))


@case("lidar.bins")
def bins(folder):
    return Asked(9, run(lidar_file(folder, fidelity={"lidar.motion": "continuous", "lidar.bins": 9})))


@case("graph.steps")
def graph_steps(folder):
    """Outer 11 computes (10 passes and the end), inner 10 x 11, count 100, tick 1: 222 in one evaluation."""
    loop = {"type": "omni.graph.action.ForLoop", "inputs": {"stop": 10}}
    nodes = {"tick": "OnPlaybackTick", "outer": loop, "inner": loop, "count": "omni.graph.action.Counter"}
    wires = ["tick.tick -> outer.execIn", "outer.loopBody -> inner.execIn", "inner.loopBody -> count.execIn"]
    return Asked(222, run(graph_file(folder, graphs={"/G": {"nodes": nodes, "connections": wires}})))


@case("graph.bytes", "1", "3")
def graph_bytes(folder, many):
    """Arrays of 1,000 doubles each."""
    array = {"type": "omni.graph.nodes.ConstructArray", "inputs": {"arraySize": 1000, "arrayType": "double[]"}}
    nodes = {f"n{number}": array for number in range(int(many))}
    return Asked(8000 * int(many), run(graph_file(folder, graphs={"/G": {"nodes": nodes, "evaluator": "push"}})))


INSTANCERS = "".join(
    f'def PointInstancer "{name}" {{\n rel prototypes = </{of}>\n int[] protoIndices = {[0] * copies}\n '
    f"point3f[] positions = {[(float(i), 0.0, 0.0) for i in range(copies)]}\n}}\n"
    for name, of, copies in (("Inner", "Class/Cube", 4), ("Outer", "Inner", 3), ("Most", "Outer", 2))
)
INSTANCERS += 'class "Class" {\n def Cube "Cube" {\n }\n}\n'


def instancers(folder):
    scene(folder, INSTANCERS)
    return ("run", lidar_file(folder, scene={"usd": "s.usda", "prims": LIDAR}), "--updates", "7")


@case("scene.copies")
def copies(folder):
    """Two of three of four cubes; the limit is for each instancer of the scene."""
    return Asked(24, instancers(folder))


@case("scene.triangles")
def triangles(folder):
    """A cube has 12; 24, 12 and 4 copies of it stand in the scene."""
    return Asked(12 * (24 + 12 + 4), instancers(folder))


@case("mesh.corners", "inline", "scene")
def corners(folder, where):
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    if where == "inline":
        square = {"type": "Mesh", "points": points, "faces": [[0, 1, 2, 3]]}
        return Asked(4, run(lidar_file(folder, {**LIDAR, "/W/Square": square})))
    text = f"int[] faceVertexCounts = [4]\n int[] faceVertexIndices = [0, 1, 2, 3]\n point3f[] points = {points}\n"
    scene(folder, f'def Mesh "M" {{\n {text}}}\n')
    return Asked(4, ("run", lidar_file(folder, scene={"usd": "s.usda", "prims": LIDAR}), "--updates", "7"))


@case("usd.entries")
def entries(folder):
    """An array of 3,000 numbers is the largest table."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.DefinePrim("/A").CreateAttribute("a", Sdf.ValueTypeNames.IntArray).Set(range(3000))
    stage.Export(str(folder / "s.usdc"))
    return Asked(3000, ("check", str(folder / "s.usdc")))


def playing(folder, file):
    return run(graph_file(folder), "--play", str(file))


@case("recording.record", "plain", "packed")
def record(folder, how):
    """The record of a plain chunk: two times and two sizes of 8 bytes, a sum and a length of 4, and its 1,000."""
    import zstandard

    if how == "plain":
        return Asked(1040, playing(folder, written(folder / "x.mcap", message(1000 - 31), compression="")))
    data = zstandard.compress(message(1000 - 31))
    return Asked(1000, playing(folder, written(folder / "x.mcap", data, compression="zstd", size=1000)))


@case("recording.waiting")
def waiting(folder):
    """Ten chunks of 600 + 31 bytes at the same time, and 400 for each message that waits."""
    return Asked(10_000, playing(folder, written(folder / "x.mcap", message(600), compression="", starts=(0,) * 10)))


def packed(folder, plain):
    """A recording of these bytes in one chunk, packed to less than a thousandth."""
    import zstandard

    return written(folder / "x.mcap", zstandard.compress(plain), compression="zstd", size=len(plain))


@case("recording.unpacked")
def unpacked(folder):
    """A message of a million zeros; 255 bytes for each byte of the file come on top of the limit."""
    file = packed(folder, message(1_000_000 - 31))
    return Asked(1_000_000 - 255 * file.stat().st_size, playing(folder, file))


@case("recording.messages")
def messages(folder):
    """50,000 equal messages; one for each byte of the file comes on top of the limit."""
    file = packed(folder, message(0) * 50_000)
    return Asked(50_000 - file.stat().st_size, playing(folder, file))


def recorded(file, *types):
    """A recording with a message of each of these (type, definition, bytes)."""
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        for number, (name, text, data) in enumerate(types):
            schema = writer.register_schema(name, "ros2msg", text)
            writer.add_message(writer.register_channel(f"/t{number}", "cdr", schema), 0, data, 0)
        writer.finish()
    return file


@case("recording.definitions")
def definitions(folder):
    """Two types of 80 bytes each; a type that is known is not defined again."""
    text = b"int32 a\n".ljust(80, b"#")
    types = [(f"b_msgs/msg/D{next(NUMBERS)}", text, b"") for _ in range(2)]
    return Asked(160, playing(folder, recorded(folder / "x.mcap", *types)))


@case("recording.type")
def type_values(folder):
    """A list of 70 numbers."""
    types = (f"b_msgs/msg/D{next(NUMBERS)}", b"int32[70] a\n", b"")
    return Asked(70, playing(folder, recorded(folder / "x.mcap", types)))


@case("recording.parts")
def parts(folder):
    """Each text takes 5 bytes at least; the message has 32 bytes or more of them."""
    data = serialize(from_plain("sensor_msgs/msg/JointState", {"name": ["a"] * 20}), "sensor_msgs/msg/JointState")
    nodes = {"tick": "OnPlaybackTick", "hear": {"type": "ROS2SubscribeJointState", "inputs": {"topicName": "t0"}}}
    graph = {"nodes": nodes, "connections": ["tick.tick -> hear.execIn"]}
    file = recorded(folder / "x.mcap", ("sensor_msgs/msg/JointState", b"", data))
    return Asked(len(data) // 5, run(graph_file(folder, graphs={"/G": graph}), "--play", str(file), "--updates", "3"))


def test_every_limit_has_a_case():
    elsewhere = {"campaign.upload"}  # it needs a cluster
    assert {name for name, *_ in CASES.values()} == LIMITS.keys() - elsewhere


@pytest.mark.parametrize("key", CASES)
def test_as_much_as_the_limit_passes_and_one_more_is_refused_in_a_line(key, tmp_path, capsys):
    name, build, more = CASES[key]
    wing = "mjcf" if key == "physics.iterations model" else name.partition(".")[0]
    if wing in MISSING_WINGS:
        pytest.skip(f"needs wings.{wing}")
    for less in (0, 1):
        asked = build(tmp_path, *more)
        most = asked.amount - less
        code = main([*asked.command, "--limit", f"{name}={most}"])
        said = capsys.readouterr()
        with limits.raised({name: most}):
            refused = [line for line in said.err.splitlines() if limits.allowed(name) in line]
        assert len(refused) == less, (code, said)
        assert less or code == 0, said.err
