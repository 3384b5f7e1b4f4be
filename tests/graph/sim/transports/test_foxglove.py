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
