"""A run served to Foxglove, received by a WebSocket client in a process of its own."""

import pytest

from tests.support.live_rig import CLOUDS, digests, free_port, heard, listening, recorded, run_rig, write_rig

pytest.importorskip("foxglove", reason="pip install 'tickgraph[foxglove]'")
pytest.importorskip("websockets", reason="the client of this test")


def test_a_client_receives_the_bytes_of_the_recording_and_drives_the_robot(tmp_path):
    file, out, port = write_rig(tmp_path), tmp_path / "out", free_port()
    with listening("foxglove", CLOUDS, port) as client:
        run_rig(file, out, "--live", f"foxglove:control:{port}")
        said = heard(client)
    assert [kind for kind, _ in said["clouds"]] == ["sensor_msgs/msg/PointCloud2"] * CLOUDS
    clouds = digests(recorded(out, "/points"))
    assert [digest for _, digest in said["clouds"]] == clouds[:CLOUDS]
    assert said["travelled"] > 0.3  # more than half of the 3.2 s at 0.5 m/s
    assert {"clientPublish", "time"} <= set(said["server"]["capabilities"])
    assert set(said["schemas"].values()) == {"ros2msg"}


def test_a_client_that_only_watches_cannot_publish_and_channels_are_bounded():
    """The server of a target without control does not offer it; 40,000 channels of clients leave 1,000 names."""
    from types import SimpleNamespace

    from graph.recording.transports.targets import read_targets
    from wings.transports.foxglove import MOST_CHANNELS, open_transport

    watching, control = read_targets([f"foxglove:{free_port()}"]) + read_targets([f"foxglove:control:{free_port()}"])
    assert (watching.control, control.control, control.host) == (False, True, "127.0.0.1")
    transport = open_transport(control)
    try:
        for number in range(40_000):
            channel = SimpleNamespace(id=number, topic="/" + "x" * 5000, encoding="cdr", schema_name="")
            transport.client_advertises(number % 7, channel)
        assert len(transport.client_channels) == MOST_CHANNELS
        transport.client_unadvertises(39_999 % 7, 39_999)
        assert len(transport.client_channels) == MOST_CHANNELS - 1
    finally:
        transport.close()


def test_the_server_offers_publishing_only_when_asked():
    import json

    from websockets.sync.client import connect

    from graph.recording.transports.targets import read_targets
    from wings.transports.foxglove import open_transport

    for text, offered in (("foxglove", False), ("foxglove:control", True)):
        port = free_port()
        transport = open_transport(read_targets([f"{text}:{port}"])[0])
        try:
            with connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"]) as socket:
                capabilities = json.loads(socket.recv())["capabilities"]
        finally:
            transport.close()
        assert ("clientPublish" in capabilities) is offered
