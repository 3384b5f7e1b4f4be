"""`graph explain` says what a run does without, and why; each line is what `tests/test_pruning.py` counts."""

import pytest

from tests.support.lidar_texts import LIDAR_AND_CLOCK, lidar_graph

SCENE = """\
tickgraph: 1
scene:
  prims:
    /World/Lidar: {type: OmniLidar, config: TIM781, translate: [0, 0, 1]}
    /World/Wall: {type: Cube, translate: [5, 0, 1]}
    /World/Mark: {type: Cube, translate: [-5, 0, 1], collision: false}
    /World/Tower: {type: Cube, translate: [300, 0, 1]}
    /World/Tank: {type: Cylinder, translate: [0, -70, 1]}
"""
BALL = "    /World/Ball: {type: Sphere, translate: [8, 0, 5], rigid_body: true}\n"


@pytest.fixture
def left_out(folder, graph):
    """The lines about what is left out of a file of this text: (part, line)."""

    def run(text):
        (folder / "a.yaml").write_text(text)
        result = graph("explain", "a.yaml")
        assert (result.code, result.err) == (0, "")
        lines = result.out.partition("\nleft out\n")[2].partition("\n\n")[0].splitlines()
        return [tuple(line.split(maxsplit=1)) for line in lines]

    return run


def test_what_a_sensor_does_not_reach_what_does_not_collide_and_what_nobody_reads(left_out):
    assert left_out(SCENE + BALL + lidar_graph()) == [
        ("physics", "/World/Mark: no colliders"),
        ("casts", "/World/Lidar: /World/Tank, /World/Tower: beyond its range of 25 m"),
        ("channels", "/World/Lidar: azimuth, elevation, distance and 17 more: nothing reads them"),
        ("poses", "copied only for a sensor that is due: nothing reads them after every physics step"),
        ("messages", "/points: made only for a recording or a live transport: nothing in the file subscribes"),
    ]


def test_where_nothing_moves_renders_or_publishes(left_out):
    assert left_out(SCENE) == [
        ("physics", "nothing on the stage can move: no model, no steps"),
        ("casts", "no sensor is rendered or polled: no structure for rays, no cast"),
        ("sensors", "/World/Lidar: no render product: no cast, no frame"),
        ("messages", "nothing publishes"),
    ]


def test_a_sensor_that_nothing_reads(left_out):
    text = LIDAR_AND_CLOCK.replace(
        "      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points}}\n", ""
    )
    wires = "      - product.execOut -> cloud.execIn\n      - product.renderProductPath -> cloud.renderProductPath\n"
    lines = left_out(text.replace(wires, ""))
    assert ("channels", "/World/Lidar: nothing reads it: its frames are empty") in lines
