"""A run on ROS 2 topics over zenoh, received by a plain zenoh session in a process of its own."""

import json
import os
import re
import time

import pytest

from graph.recording.transports.sink import LiveSink
from graph.recording.transports.targets import Target
from graph.sim.messages.bus import MessageBus, Topic
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import deserialize, message_type
from tests.support.live_rig import CLOUDS, digests, free_port, heard, listening, recorded, run_rig, write_rig
from wings.transports.rmw_zenoh import attachment, gid, node_token, quality_key, topic_key, topic_token

HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
"""Of std_msgs/msg/String, as in rmw_zenoh's design page."""
CHATTER = Topic("/chatter", "std_msgs/msg/String")


def test_keys_and_tokens_are_those_of_the_talker_of_rmw_zenohs_design_page():
    assert topic_key(0, CHATTER) == f"0/chatter/std_msgs::msg::dds_::String_/{HASH}"
    assert topic_key(7, Topic("/a/b", "std_msgs/msg/String")) == f"7/a/b/std_msgs::msg::dds_::String_/{HASH}"
    assert node_token(2, "aac3") == "@ros2_lv/2/aac3/0/0/NN/%/%/tickgraph"
    token = topic_token(0, "8b20", 10, "MP", Topic("/ns/chatter", "std_msgs/msg/String"))
    names = f"%ns%chatter/std_msgs::msg::dds_::String_/{HASH}"
    assert token == f"@ros2_lv/0/8b20/0/10/MP/%/%/tickgraph/{names}/::,10:,:,:,,"


@pytest.mark.parametrize(
    ("quality", "key"),
    [
        (Quality(), "::,10:,:,:,,"),
        (Quality(depth=42), "::,:,:,:,,"),
        (Quality(reliability="bestEffort", depth=5), "2::,5:,:,:,,"),
        (Quality(durability="transientLocal", depth=1), ":1:,1:,:,:,,"),
        (Quality(history="keepAll", depth=0), "::2,:,:,:,,"),
        (
            Quality(deadline_ns=1_500_000_000, lifespan_ns=2, liveliness="manualByTopic", lease_ns=3_000_000_000),
            "::,10:1,500000000:0,2:3,3,0",
        ),
    ],
)
def test_a_quality_of_service_is_written_as_rmw_zenoh_writes_it(quality, key):
    assert quality_key(quality) == key


def test_an_attachment_has_33_bytes():
    assert attachment(1, 2, bytes(range(16))).hex() == (
        "0100000000000000" + "0200000000000000" + "10" + "000102030405060708090a0b0c0d0e0f"
    )


def test_a_ros_2_program_receives_every_cloud_and_drives_the_robot(tmp_path):
    pytest.importorskip("zenoh", reason="pip install 'tickgraph[zenoh]'")
    file, out, port = write_rig(tmp_path), tmp_path / "out", free_port()
    with listening("zenoh", CLOUDS, port) as listener:
        run_rig(file, out, "--live", f"zenoh:{port}", environment={**os.environ, "ROS_DOMAIN_ID": "0"})
        said = heard(listener)
    clouds = said["clouds"][:CLOUDS]
    assert [cloud["digest"] for cloud in clouds] == digests(recorded(out, "/points"))[:CLOUDS]
    assert [cloud["sequence"] for cloud in clouds] == [*range(1, CLOUDS + 1)]
    assert {tuple(cloud["attachment"]) for cloud in clouds} == {(33, 16)}
    # Forward at 0.5 m/s for most of 3.2 s: the commands of another hash, backward, did not match.
    assert said["travelled"] > 0.3
    [points] = [token for token in said["tokens"] if "/%points/" in token]
    form = r"@ros2_lv/0/[0-9a-f]+/0/\d+/MP/%/%/tickgraph/%points/sensor_msgs::msg::dds_::PointCloud2_/(RIHS01_\w{64})/"
    hash_of_type = re.fullmatch(form + re.escape("::,10:,:,:,,"), points)[1]
    assert {cloud["key"] for cloud in clouds} == {f"0/points/sensor_msgs::msg::dds_::PointCloud2_/{hash_of_type}"}
    assert {cloud["gid"] for cloud in clouds} == {gid(points).hex()}
    assert any("/MS/%/%/tickgraph/%cmd_vel/" in token for token in said["tokens"])
    assert any(token.endswith("/NN/%/%/tickgraph") for token in said["tokens"])


def said(sample):
    return deserialize(sample.payload.to_bytes(), "std_msgs/msg/String").data


def test_a_late_subscriber_gets_the_last_message_of_a_latched_topic():
    zenoh = pytest.importorskip("zenoh", reason="pip install 'tickgraph[zenoh]'")
    from zenoh import ext

    from wings.transports.zenoh import open_transport

    port, name = free_port(), "std_msgs/msg/String"
    settings = {"mode": "router", "listen/endpoints": [f"tcp/127.0.0.1:{port}"], "scouting/multicast/enabled": False}
    config = zenoh.Config()
    for setting, value in settings.items():
        config.insert_json5(setting, json.dumps(value))
    with zenoh.open(config) as router:
        bus, text = MessageBus(), message_type(name)
        sink = LiveSink("zenoh", open_transport(Target("zenoh", port=port)), bus)
        bus.subscribe(sink)
        bus.advertise("/latched", name, quality=Quality(durability="transientLocal", depth=1))
        for words in ("first", "last"):
            bus.publish("/latched", name, text(words), 0)
        while sink.counts["/latched"].sent < 2:
            time.sleep(0.01)
        found = []
        history = ext.HistoryConfig(detect_late_publishers=True, max_samples=5)
        key = topic_key(0, Topic("/latched", name))
        ext.declare_advanced_subscriber(router, key, found.append, history=history)
        end = time.monotonic() + 120
        while "last" not in [said(sample) for sample in found] and time.monotonic() < end:
            time.sleep(0.01)
        sink.close()
        assert said(found[-1]) == "last"
