"""`graph inspect`: what it prints of one frame, and what it says without a frame."""

import json

import pytest

# A planar lidar of 3200 beams at 10 Hz in the middle of a room 10 m wide: every beam hits one of its walls.
ROOM = """\
tickgraph: 1
scene:
  prims:
    /World/North: {type: Cube, size: 1.0, scale: [12, 1, 3], translate: [0, 5.5, 0]}
    /World/South: {type: Cube, size: 1.0, scale: [12, 1, 3], translate: [0, -5.5, 0]}
    /World/East: {type: Cube, size: 1.0, scale: [1, 10, 3], translate: [5.5, 0, 0], material: aluminum}
    /World/West: {type: Cube, size: 1.0, scale: [1, 10, 3], translate: [-5.5, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: RPLIDAR_S2E}
clock: {physics_hz: 240, loop_hz: 60}
"""


@pytest.fixture
def room(folder):
    (folder / "room.yaml").write_text(ROOM)
    return "room.yaml"


def told(graph, *arguments):
    result = graph("inspect", *arguments, "--json")
    assert result.code == 0, result.err
    return json.loads(result.out)


def test_it_tells_header_channels_and_hits_of_the_first_frame(room, graph):
    found = told(graph, room, "--sensor", "/World/Lidar", "--aux", "FULL")

    assert (found["sensor"], found["update"]) == ("/World/Lidar", 5)  # 0.1 s are over in the sixth update
    header = found["header"]
    assert header["numElements"] == 3200
    assert (header["modality"], header["auxType"], header["timestampNs"]) == ("LIDAR", "FULL", 0)
    assert header["frameEnd"]["timestampNs"] == 100_000_000
    assert header["scanComplete"] is True
    channels = found["channels"]
    assert channels["x"] == {**channels["x"], "dtype": "float32", "unit": "deg", "shape": [3200]}
    assert channels["z"]["min"] == pytest.approx(5.0, abs=0.01)  # a wall ahead
    assert channels["z"]["max"] == pytest.approx(50**0.5, abs=0.01)  # a corner
    assert channels["objId"]["distinct"] == 4
    assert channels["matId"]["max"] == 1  # aluminum
    assert channels["hitNormals"]["shape"] == [3200, 3]
    assert not any("empty_because" in channel for channel in channels.values())
    # Each wall covers a quarter of the circle.
    assert {path: round(count / 100) for path, count in found["hits"].items()} == dict.fromkeys(
        ["/World/North", "/World/South", "/World/East", "/World/West"], 8
    )


def test_channels_above_the_level_say_what_they_need_and_hits_are_reported_all_the_same(room, graph):
    found = told(graph, room)

    assert found["header"]["auxType"] == "NONE"
    assert found["channels"]["emitterId"]["empty_because"] == "needs --aux BASIC"
    assert found["channels"]["objId"]["empty_because"] == "needs --aux EXTRA"
    assert sum(found["hits"].values()) == 3200


def test_a_setting_that_withholds_a_channel_is_named(room, graph):
    found = told(graph, room, "--aux", "FULL", "--/app/sensors/nv/lidar/publishNormals=false")

    assert found["channels"]["hitNormals"]["empty_because"] == "needs --/app/sensors/nv/lidar/publishNormals=true"
    assert [warning["code"] for warning in found["warnings"]] == ["normals-off"]


def test_after_so_many_updates_it_is_the_newest_frame(room, graph):
    found = told(graph, room, "--updates", "20")

    assert (found["update"], found["header"]["frameId"], found["header"]["timestampNs"]) == (17, 2, 200_000_000)


def test_a_frame_without_hits_is_a_frame(folder, graph):
    (folder / "void.yaml").write_text(
        "tickgraph: 1\nscene: {prims: {/World/Lidar: {type: OmniLidar, config: RPLIDAR_S2E}}}\n"
    )
    result = graph("inspect", "void.yaml")

    assert result.code == 0
    assert "  numElements              0\n" in result.out
    assert "hits: none" in result.out


def test_the_text_has_a_line_for_each_channel(room, graph):
    result = graph("inspect", room, "--aux", "BASIC")

    assert result.code == 0
    lines = result.out.splitlines()
    assert lines[0] == "room.yaml: /World/Lidar, frame 0 in update 5"
    rows = [line.split() for line in lines[lines.index("channels") + 1 : lines.index("hits") - 1]]
    assert rows[0] == ["name", "dtype", "shape", "unit", "range", "first"]
    assert len(rows) == 1 + 6 + 9
    assert next(row for row in rows if row[0] == "hitNormals")[-4:] == ["empty:", "needs", "--aux", "FULL"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--sensor", "/World/Lidr"], 2, 'there is no such sensor; did you mean "/World/Lidar"?'),
        (["--sensor", "/World/Lidar/"], 2, 'there is no such sensor; did you mean "/World/Lidar"?'),
        (["--sensor", "radar"], 2, "there is no such sensor; there are /World/Lidar"),
        (["--sensor", "/World/East"], 2, "/World/East: a Cube is not a sensor"),
        (["--aux", "MOST"], 2, "invalid choice: 'MOST'"),
        (["--updates", "0"], 2, "--updates 0: give a number of updates above 0"),
        (["--updates", "3"], 1, "no frame in 3 updates: at 10 Hz its first scan ends at 0.1 s; give --updates 6"),
    ],
)
def test_what_cannot_be_shown_is_reported_in_one_line(room, graph, arguments, code, message):
    result = graph("inspect", room, *arguments)

    assert (result.code, result.out) == (code, "")
    assert message in result.err
    assert result.err.count("\n") == 1


def test_a_scene_with_several_sensors_or_none_asks_which(folder, graph):
    (folder / "two.yaml").write_text(ROOM.replace("clock:", "    /World/Other: {type: OmniLidar}\nclock:"))
    (folder / "none.yaml").write_text("tickgraph: 1\n")

    assert "it has /World/Lidar, /World/Other; choose with --sensor" in graph("inspect", "two.yaml").err
    assert "it has none that can be rendered" in graph("inspect", "none.yaml").err


def test_of_several_sensors_it_takes_the_only_one_that_a_node_names(folder, graph):
    nodes = "{tick: OnPlaybackTick, p: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}}"
    (folder / "two.yaml").write_text(
        ROOM.replace("clock:", "    /World/Other: {type: OmniLidar}\nclock:")
        + f"graphs:\n  /World/G: {{nodes: {nodes}, connections: [tick.tick -> p.execIn]}}\n"
    )

    assert graph("inspect", "two.yaml").out.startswith("two.yaml: /World/Lidar, frame 0")


ROBOT = """\
#usda 1.0
(
    defaultPrim = "Robot"
)
def Xform "Robot"
{
    def OmniLidar "Lidar"
    {
        float omni:sensor:tickRate = 10
    }
}
"""
SCENE = """\
#usda 1.0
def Xform "World"
{
    def Xform "A" (
        instanceable = true
        references = @robot.usda@
    )
    {
    }
}
"""


def test_a_lidar_in_an_instance_is_found_and_only_its_level_cannot_be_set(folder, graph):
    (folder / "robot.usda").write_text(ROBOT)
    (folder / "scene.usda").write_text(SCENE)

    assert told(graph, "scene.usda")["sensor"] == "/World/A/Lidar"
    assert told(graph, "scene.usda", "--aux", "NONE")["header"]["auxType"] == "NONE"
    refused = graph("inspect", "scene.usda", "--aux", "FULL")
    assert refused.code == 2
    assert refused.err.startswith("graph: /World/A/Lidar: ")
    assert refused.err.endswith("set it in the instance's asset, or make the instance instanceable = false\n")
    assert "/World/A/Lidar (OmniLidar)" in graph("explain", "scene.usda").out


def test_a_clock_that_does_not_move_is_given_as_the_reason(folder, graph):
    (folder / "still.yaml").write_text(ROOM + "settings: {/app/player/playSimulations: false}\n")
    result = graph("inspect", "still.yaml", "--updates", "30")

    assert result.code == 1
    assert "no frame in 30 updates: the renderer's clock did not move" in result.err
