"""Only what is required is built and computed; what is written is the same, byte for byte, without pruning."""

import json
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import UsdGeom

import graph.sim.messages.ros_types as ros_types
from graph.cli.main import main
from graph.recording.mcap_sink import McapSink
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from graph.sim.physics import MUJOCO
from graph.sim.state import prim_poses
from sensors.raycast import triangles
from sensors.raycast.shared import cast_world
from sensors.sensor_types import sensor_type
from tests.support.lidar_texts import LIDAR_AND_CLOCK
from tests.support.lidar_worlds import add_box, add_lidar, define_lidar, rotary, weightless
from tests.support.unpruned import unpruned


class CountingEngine:
    """MuJoCo, and how often it was made."""

    name, made = "mujoco", 0

    def __call__(self, *arguments, **options):
        self.made += 1
        return MUJOCO(*arguments, **options)


def counted(monkeypatch, place, name):
    """A list that grows by the arguments of each call of a public function."""
    calls, plain = [], getattr(place, name)

    def counting(*arguments, **options):
        calls.append(arguments)
        return plain(*arguments, **options)

    monkeypatch.setattr(place, name, counting)
    return calls


@pytest.fixture
def scenes(monkeypatch):
    """The triangles of each acceleration structure built, largest first."""
    sizes, plain = [], triangles.TriangleScene.__init__

    def counting(self, vertices, faces, **options):
        sizes.append(len(faces))
        plain(self, vertices, faces, **options)

    monkeypatch.setattr(triangles.TriangleScene, "__init__", counting)
    return sizes


def test_there_is_no_physics_model_where_nothing_can_move():
    for moves, prune, made in ((False, True, 0), (True, True, 1), (False, False, 1)):
        engine = CountingEngine()
        with nullcontext() if prune else unpruned(), App(physics=engine) as app:
            add_box(app, "/World/Box", 1.0, (0, 0, 1), velocity=(0, 0, 0) if moves else None)
            app.play()
            app.update(steps=3)
            assert (engine.made, app.physics is None, app.simulation.get_num_physics_steps()) == (made, not made, 3)


def test_only_colliders_are_in_physics():
    with App() as app:
        add_box(app, "/World/Body", 1.0, (0, 0, 1), velocity=(0, 0, 0))
        for number in range(3):
            UsdGeom.Cube.Define(app.stage, f"/World/Seen{number}")
        app.play()
        assert {collider.path for collider in app.physics.world.colliders} == {"/World/Body"}


def test_structures_are_built_only_for_a_sensor_that_is_due_and_read():
    with weightless() as app:
        add_box(app, "/World/Wall", 1.0, (5, 0, 0))
        define_lidar(app)
        before = triangles.built()
        app.play()
        app.update(steps=12)
        assert triangles.built() == before  # no render product
        app.stop()
        product = add_lidar(app, "/World/Other", channels=())
        app.play()
        app.update(steps=12)
        assert (product.frames, product.elements, triangles.built()) == (2, 0, before)  # rendered, but nothing reads it
        product.sensor.require("test", {"distance"})
        app.update(steps=5)
        assert triangles.built() == before  # read, but not due
        app.update()
        assert (product.frames, triangles.built()) == (3, before + 1)


def test_what_no_ray_reaches_is_in_no_structure(scenes):
    with weightless() as app:
        add_box(app, "/World/Near", 1.0, (5, 0, 0))  # 12 triangles each
        add_box(app, "/World/Edge", 1.0, (0, 10.4, 0))  # its nearest side is at 9.9 m
        for number in range(50):
            add_box(app, f"/World/Far{number}", 1.0, (40 + 3 * number, 0, 0))
        short = add_lidar(app, config=rotary(far_range_m=10.0))
        app.play()
        app.update(steps=6)
        assert scenes == [24]
        assert short.frame.channel("distance").max() < 10.0
        long = add_lidar(app, "/World/Long", config=rotary(far_range_m=300.0))
        app.update(steps=6)
        assert scenes == [24, 52 * 12]
        assert long.frame.count >= short.frame.count > 0


def test_a_sensor_that_drives_meets_what_comes_into_its_reach(scenes):
    """From x = 0 to 60 m at 60 m/s among posts at x = 0, 10, ... 70 m and y = 3 m, seen to 8 m.

    The frozen scan of each tick sees the near side of the post beside it, 2.5 m away, or its corner; a beam that is up
    to a degree beside a corner 4.3 m away is up to 4.3 * tan(1 deg) = 0.08 m longer.
    """
    with weightless() as app:
        for number in range(8):
            add_box(app, f"/World/Post{number}", 1.0, (10 * number, 3, 0))
        add_box(app, "/World/Car", 0.2, (0, 0, 5), velocity=(60, 0, 0))
        product = add_lidar(app, "/World/Car/Lidar", (0, 0, -5), rotary(far_range_m=8.0), channels={"distance"})
        app.play()
        nearest = []
        for _ in range(60):
            app.update()
            if product.new_frame:
                nearest.append(float(product.frame.channel("distance").min()))
        ticks = 60 * np.arange(1, 11) / 10  # a tick every 6 m
        aside = np.abs(ticks - 10 * np.round(ticks / 10))
        assert nearest == pytest.approx(np.hypot(2.5, np.maximum(aside - 0.5, 0)), abs=0.08)
        standing = [size for size in scenes if size > 12]
        assert len(standing) > 1
        assert max(standing) < 8 * 12


def test_poses_are_copied_only_for_a_sensor_that_is_due(monkeypatch):
    with weightless() as app:
        add_box(app, "/World/Box", 1.0, (5, 0, 0), velocity=(0, 1, 0))
        product = add_lidar(app, channels={"distance"})
        app.play()
        copies = counted(monkeypatch, prim_poses, "Poses")
        app.update(steps=5)
        assert (product.frames, copies) == (0, [])
        app.update()
        assert (product.frames, len(copies)) == (1, 1)
        app.update(steps=12)
        assert (product.frames, len(copies)) == (3, 3)


@pytest.fixture
def file(tmp_path):
    """A graph file with a lidar of 10 Hz and a clock of 60 Hz that are published."""
    path = tmp_path / "a.yaml"
    path.write_text(LIDAR_AND_CLOCK)
    return path


def test_messages_become_bytes_only_for_a_recording(file, tmp_path, monkeypatch):
    made = counted(monkeypatch, ros_types, "serialize")
    for sink, clouds, messages in ((None, 0, 0), (MemorySink(), 1, 0), (McapSink(tmp_path / "a.mcap"), 1, 7)):
        with App.from_file(file) as app:
            if sink is not None:
                app.bus.subscribe(sink)
            app.play()
            made.clear()
            app.update(steps=6)
            sent = {name: topic.messages for name, topic in app.bus.topics.items()}
            assert sent == {"/clock": 6 * clouds, "/points": clouds}
        assert len(made) == messages


def test_without_a_publisher_nothing_becomes_bytes(tmp_path, monkeypatch):
    made = counted(monkeypatch, ros_types, "serialize")
    with weightless() as app:
        add_box(app, "/World/Wall", 1.0, (5, 0, 0))
        product = add_lidar(app)
        app.bus.subscribe(McapSink(tmp_path / "a.mcap"))
        app.play()
        app.update(steps=6)
        assert product.frame.count > 0
    assert made == []


def test_a_standing_scene_is_built_once_for_all_sensors_and_apps_of_a_process(file):
    before, alive = triangles.built(), triangles.alive()
    clouds = []

    def cloud(app):
        sink = MemorySink()
        app.bus.subscribe(sink)
        add_lidar(app, "/World/Second")
        app.play()
        app.update(steps=6)
        return sink["/points"][0].cdr()

    with App.from_file(file) as first, App.from_file(file) as second:
        clouds += [cloud(first), cloud(second)]
        with unpruned():
            own = App.from_file(file)
            clouds.append(cloud(own))
        # One for the first two. The third builds its own: at play, dropped, and for its sensors.
        assert (triangles.built() - before, triangles.alive() - alive) == (1 + 2, 1 + 1)
        assert cast_world(first.world) is not cast_world(second.world)
        own.close()
    assert len(set(clouds)) == 1
    del first, second, own
    assert triangles.alive() == alive


# -- the same bytes without pruning ----------------------------------------------------------------------------------

PLACE = st.tuples(*(st.integers(-60, 60).filter(lambda x: abs(x) > 3),) * 2, st.integers(0, 3)).map(list)
SOLID = st.fixed_dictionaries(
    {"type": st.sampled_from(["Cube", "Sphere", "Cylinder"]), "translate": PLACE},
    optional={
        "rigid_body": st.just(True),
        "rotate": st.tuples(*(st.integers(0, 90),) * 3).map(list),
        "semantics": st.just("thing"),
    },
)
SENSORS = {
    "OmniLidar": ({"config": "TIM781"}, "ROS2RtxLidarHelper", {"type": "point_cloud"}),
    "OmniRadar": (
        {
            "attributes": {
                "omni:sensor:tickRate": 10,
                "omni:sensor:WpmDmat:scan:s001:maxAzAngDeg": 5,
                "omni:sensor:WpmDmat:scan:s001:maxElAngDeg": 2,
            }
        },
        *("ROS2RtxRadarHelper", {"outputRadialVelocityMS": True}),
    ),
    "Camera": (
        {"rotate": [90, 0, -90], "schemas": ["OmniSensorAPI"], "attributes": {"omni:sensor:tickRate": 10}},
        *("ROS2CameraHelper", {"type": "depth"}),
    ),
}
PLACED = st.fixed_dictionaries(
    {
        "type": st.sampled_from(list(SENSORS)),
        "aux": st.sampled_from(["NONE", "BASIC", "FULL"]),
        "carried": st.booleans(),
        "made": st.sampled_from([True, True, False]),
        "published": st.sampled_from([True, True, False]),
    }
)
FILES = st.fixed_dictionaries(
    {
        "solids": st.lists(SOLID, max_size=5),
        "sensors": st.lists(PLACED, max_size=2),
        "ground": st.booleans(),
        "clock": st.booleans(),
        "options": st.sampled_from([(), ("--preview", "10")]),
        "motion": st.sampled_from(["frozen", "update", "continuous"]),
        "knobs": st.fixed_dictionaries(
            {}, optional={"lidar.noise": st.just("on"), "mesh.solids": st.just("mesh"), "fabric": st.just("off")}
        ),
        "rates": st.sampled_from([{"physics_hz": 60, "loop_hz": 60}, {"physics_hz": 120, "loop_hz": 30}]),
    }
)


def graph_file(drawn):
    """The graph file, as data, of what was drawn: sensors about the origin, some on a body that is thrown."""
    prims = {f"/World/Solid{number}": solid for number, solid in enumerate(drawn["solids"])}
    if drawn["ground"]:
        prims["/World/Ground"] = {"type": "Plane"}
    nodes = {"tick": "OnPlaybackTick", "time": "IsaacReadSimulationTime"}
    wires = []
    if drawn["clock"]:
        nodes["clock"] = "ROS2PublishClock"
        wires += ["tick.tick -> clock.execIn", "time.simulationTime -> clock.timeStamp"]
    if any(sensor["carried"] for sensor in drawn["sensors"]):
        prims["/World/Car"] = {
            "type": "Sphere",
            "radius": 0.1,
            "translate": [0, 0, 5],
            "rigid_body": True,
            "velocity": [20, 3, 4],
        }
    for number, sensor in enumerate(drawn["sensors"]):
        keys, helper, inputs = SENSORS[sensor["type"]]
        path = f"/World/{'Car/' if sensor['carried'] else ''}Sensor{number}"
        prims[path] = {"type": sensor["type"], "translate": [0, 0, 1], **keys}
        if sensor["type"] != "Camera":
            levels = sensor_type(sensor["type"]).aux_levels
            prims[path]["aux_output_level"] = sensor["aux"] if sensor["aux"] in levels else levels[-1]
        if sensor["made"]:
            size = {"width": 32, "height": 24} if sensor["type"] == "Camera" else {}
            nodes[f"product{number}"] = {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": path, **size}}
            wires.append(f"tick.tick -> product{number}.execIn")
        if sensor["made"] and sensor["published"]:
            nodes[f"helper{number}"] = {"type": helper, "inputs": {"topicName": f"t{number}", **inputs}}
            wires += [
                f"product{number}.execOut -> helper{number}.execIn",
                f"product{number}.renderProductPath -> helper{number}.renderProductPath",
            ]
    return {
        "tickgraph": 1,
        "scene": {"prims": prims},
        "clock": drawn["rates"],
        "fidelity": {"lidar.motion": drawn["motion"], **drawn["knobs"]},
        "graphs": {"/World/G": {"nodes": nodes, "connections": wires}},
    }


TIMES = ("wall_time_s", "real_time_factor", "timing_s")
"""What a report says of the machine."""


def written(file, *options):
    """Exit code and files of a run of 0.3 s, the report without the times of the machine."""
    with tempfile.TemporaryDirectory() as out:
        code = main(["run", str(file), "--duration", "0.3", "--out", out, *options])
        files = {str(path.relative_to(out)): path.read_bytes() for path in Path(out).rglob("*") if path.is_file()}
    report = json.loads(files.pop("report.json"))
    return code, {name: told for name, told in report.items() if name not in TIMES}, files


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(FILES)
def test_without_pruning_a_run_writes_the_same_bytes(tmp_path, capsys, drawn):
    file = tmp_path / "a.json"
    file.write_text(json.dumps(graph_file(drawn)))
    pruned = written(file, *drawn["options"])
    with unpruned():
        whole = written(file, *drawn["options"])
    said = capsys.readouterr()
    assert pruned[0] == 0, said.err
    assert not drawn["clock"] or "run.mcap" in pruned[2]
    assert pruned == whole


TOLD = {
    "/World/Huge": {"type": "Cube", "scale": [1e12, 1e12, 1e12], "collision": False},
    "/World/Light": {"type": "Cube", "attributes": {"physics:mass": -1.0}, "schemas": ["PhysicsMassAPI"]},
}
"""`odd-scale` where rays are cast, `bad-mass` where physics is built."""
CAMERA = {"type": "Camera", "made": True, "published": True, "carried": False, "aux": "NONE"}


@pytest.mark.parametrize("sensors", [[], [CAMERA]])
def test_of_what_only_a_run_without_pruning_computes_nothing_is_told(tmp_path, sensors):
    """Physics of what stands still, rays without a sensor, pictures without a light that nobody looks at."""
    drawn = {"solids": [], "sensors": sensors, "ground": True, "clock": True, "motion": "frozen", "knobs": {}}
    data = graph_file(drawn | {"rates": {"physics_hz": 60, "loop_hz": 60}})
    data["scene"]["prims"].update(TOLD)
    file = tmp_path / "a.json"
    file.write_text(json.dumps(data))
    pruned = written(file)
    with unpruned():
        whole = written(file)
    assert (pruned[0], len(pruned[2]["run.mcap"]) > 0) == (0, True)
    assert pruned == whole
