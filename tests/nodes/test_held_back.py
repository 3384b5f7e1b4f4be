"""The issue's shape of graph: a tick, a Countdown that holds a sensor back, its product, its helper."""

import pytest

from graph import compile_graphs
from graph.session.runner import GraphRunner
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec


@pytest.fixture
def session(lidar, world):
    """A 240 Hz world of 60 Hz updates with a 20 Hz lidar; its product is made when Countdown (5, 1) finishes."""
    lidar("picoScan150")
    app = world(physics_hz=240, loop_hz=60)
    spec = GraphSpec(
        "/World/ActionGraph",
        (
            NodeSpec("tick", "OnPlaybackTick"),
            NodeSpec("time", "IsaacReadSimulationTime"),
            NodeSpec("clock", "ROS2PublishClock"),
            NodeSpec("wait", "Countdown", {"duration": 5, "period": 1}),
            NodeSpec("product", "IsaacCreateRenderProduct", {"cameraPrim": "/World/Lidar"}),
            NodeSpec("config", "ROS2RtxLidarPointCloudConfig", {"outputRing": True, "outputTime": True}),
            NodeSpec("cloud", "ROS2RtxLidarHelper", {"type": "point_cloud", "topicName": "points"}),
        ),
        tuple(
            ConnectionSpec(*pair.split(" "))
            for pair in (
                "tick.tick clock.execIn",
                "time.simulationTime clock.timeStamp",
                "tick.tick wait.execIn",
                "wait.finished product.execIn",
                "product.execOut cloud.execIn",
                "product.renderProductPath cloud.renderProductPath",
                "config.selectedMetadata cloud.selectedMetadata",
            )
        ),
    )
    runner = GraphRunner(app, compile_graphs([spec]))
    yield app, runner.graphs["/World/ActionGraph"]
    runner.close()


def test_a_20_hz_lidar_held_back_by_countdown_5_gives_98_frames_in_5_s_the_first_stamped_a_tenth(session):
    app, graph = session
    app.play()
    app.update(300)
    stamps = [one.stamp_ns for one in app.sink["/points"]]
    assert len(stamps) == 98
    # Headers carry the time of the pose: the end of each scan, 50 ms after `first_frame_ns` of the report.
    assert stamps == [50_000_000 * k for k in range(3, 101)]
    names = [field.name for field in app.sink["/points"][0].message.fields]
    assert names == ["x", "y", "z", "ring", "time"]
    assert graph.nodes["product"].computes == 50
    assert [one.stamp_ns for one in app.sink["/clock"]] == [round(10**9 * (u + 1) / 60) for u in range(300)]
    assert not list(app.warnings)


def test_a_second_play_publishes_what_the_first_did(session):
    app, _ = session
    runs = []
    for _ in range(2):
        before = len(app.sink["/points"])
        app.play()
        app.update(30)
        app.stop()
        runs.append([(one.stamp_ns, one.message.data.tobytes()) for one in app.sink["/points"][before:]])
    assert runs[0] == runs[1]
    assert [stamp for stamp, _ in runs[0]] == [50_000_000 * k for k in range(3, 11)]
