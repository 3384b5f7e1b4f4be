"""A run on ROS 2 topics over DDS, received in a process of its own with Cyclone DDS's own types."""

import os
import sys
import threading
import time

import numpy as np
import pytest

from tests.support.live_rig import CLOUDS, POINTS, digests, heard, listening, recorded, ros_domain, run_rig, write_rig

pytest.importorskip("cyclonedds", reason="pip install 'tickgraph[dds]'")

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from graph.recording.transports.sink import LiveSink
from graph.recording.transports.targets import read_targets
from graph.recording.transports.transport import NotSentError, Outgoing
from graph.sim.messages.bus import MessageBus, Topic
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_fields import from_plain
from graph.sim.messages.ros_types import message_type, serialize
from wings.transports.dds import open_transport, qos

STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
CLOUD_HASH = "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"
"""Of std_msgs/msg/String and sensor_msgs/msg/PointCloud2, as `ros2 topic info -v` prints them."""

PATIENCE_NS = 120 * 10**9
"""Until a test that waits for a sample fails."""


def test_a_ros_2_program_receives_every_cloud_and_drives_the_robot(tmp_path):
    file, out = write_rig(tmp_path), tmp_path / "out"
    domain = 100 + os.getpid() % 100
    with listening("dds", CLOUDS, environment=ros_domain(domain)) as listener:
        report = run_rig(file, out, "--live", "dds", environment=ros_domain(domain))
        said = heard(listener)
    clouds = said["clouds"][:CLOUDS]
    assert [points for points, _ in clouds] == [POINTS] * CLOUDS
    assert [digest for _, digest in clouds] == digests(recorded(out, "/points"))[:CLOUDS]
    assert said["travelled"] > 0.3  # more than half of the 3.2 s at 0.5 m/s
    # The clock of updates of 1/60 s, in order and without gaps.
    steps = {later - earlier for earlier, later in zip(said["clock"], said["clock"][1:], strict=False)}
    assert steps == {16_666_666, 16_666_667}
    points = said["endpoints"]["rt/points"]
    assert points["type"] == "sensor_msgs::msg::dds_::PointCloud2_"
    assert points["user_data"] == f"typehash={CLOUD_HASH};"
    assert (points["reliable"], points["durability"]) == (True, "Policy.Durability.Volatile")
    assert report["live"]["dds"]["topics"]["/points"] == {"sent": 32, "dropped": 0, "not_sent": 0, "received": 0}
    assert report["live"]["dds"]["topics"]["/cmd_vel"]["received"] == len(recorded(out, "/cmd_vel")) > 0


@pytest.mark.parametrize(
    ("quality", "wanted"),
    [
        (Quality(), ("Reliable", "KeepLast(depth=10)", "Volatile")),
        (Quality(reliability="bestEffort", depth=5), ("BestEffort", "KeepLast(depth=5)", "Volatile")),
        (Quality(durability="transientLocal", depth=1), ("Reliable", "KeepLast(depth=1)", "TransientLocal")),
        (Quality(history="keepAll"), ("Reliable", "KeepAll", "Volatile")),
        # What the system decides: as rmw_cyclonedds decides it.
        (Quality("systemDefault", 0, "systemDefault", "systemDefault"), ("Reliable", "KeepLast(depth=1)", "Volatile")),
    ],
)
def test_the_offered_quality_of_service_is_that_of_the_profile(quality, wanted):
    policies = qos(quality, "std_msgs/msg/String")
    found = [str(policies[getattr(Policy, name)]) for name in ("Reliability", "History", "Durability")]
    assert all(part in text for part, text in zip(wanted, found, strict=True)), found
    assert policies[Policy.Userdata].data == f"typehash={STRING_HASH};".encode()
    assert policies[Policy.DataRepresentation].use_cdrv0_representation


def test_deadlines_lifespans_and_leases_of_0_are_none():
    policies = qos(Quality(deadline_ns=5, lifespan_ns=6, liveliness="manualByTopic", lease_ns=7), "std_msgs/msg/String")
    assert policies[Policy.Deadline].deadline == 5
    assert policies[Policy.Lifespan].lifespan == 6
    assert policies[Policy.Liveliness] == Policy.Liveliness.ManualByTopic(lease_duration=7)
    usual = qos(Quality(), "std_msgs/msg/String")
    assert Policy.Deadline not in usual
    assert Policy.Lifespan not in usual


def test_a_late_reader_gets_the_last_message_of_a_latched_topic(monkeypatch):
    domain = 100 + os.getpid() % 100
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    bus, text = MessageBus(), message_type("std_msgs/msg/String")
    sink = LiveSink("dds", open_transport(read_targets(["dds"])[0]), bus)
    bus.subscribe(sink)
    bus.advertise("/latched", "std_msgs/msg/String", quality=Quality(durability="transientLocal", depth=1))
    for said in ("first", "last"):
        bus.publish("/latched", "std_msgs/msg/String", text(said), 0)
    while sink.counts["/latched"].sent < 2:
        time.sleep(0.01)
    string = make_idl_struct("String_", "std_msgs.msg.dds_.String_", {"data": str})
    participant = DomainParticipant(domain)
    wanted = Qos(Policy.Reliability.Reliable(10**8), Policy.Durability.TransientLocal, Policy.History.KeepAll)
    reader = DataReader(participant, DdsTopic(participant, "rt/latched", string), wanted)
    first = next(reader.take_iter(timeout=PATIENCE_NS))  # waits for the event; were "first" there, it would come first
    sink.close()
    assert first.data == "last"


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGSTOP")
def test_while_a_write_waits_for_a_stopped_reader_other_threads_run(monkeypatch):
    """The package's own write holds the interpreter's lock for that tenth of a second."""
    domain, name = 100 + os.getpid() % 100, "sensor_msgs/msg/PointCloud2"
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    cloud = serialize(from_plain(name, {"data": np.zeros(700_000, np.uint8)}), name)
    turns = [0]

    def take_turns():
        while not done.wait(0.001):
            turns[0] += 1

    done, other = threading.Event(), threading.Thread(target=take_turns)
    with listening("dds", 1000, "stall", environment=ros_domain(domain)):
        transport = open_transport(read_targets(["dds"])[0])
        transport.advertise(Topic("/points", name, Quality(history="keepAll")))
        while not transport.matched("/points"):
            time.sleep(0.01)
        other.start()
        try:
            refused = 0
            while refused < 3:  # the writer keeps all, so it waits as soon as half a megabyte is not confirmed
                before = turns[0]
                try:
                    transport.send(Outgoing("/points", name, cloud, 0, latched=False))
                except NotSentError:
                    refused += 1
                    assert turns[0] > before + 1  # with the lock held there is one at most
        finally:
            done.set()
            transport.close()
