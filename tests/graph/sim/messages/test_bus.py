"""The message bus: topics, sinks, counts."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import RunError
from graph.sim.messages.bus import CountingSink, MemorySink, MessageBus


def test_a_sink_gets_every_message_with_stamp_and_sequence():
    bus, sink = MessageBus(), MemorySink()
    bus.subscribe(sink)
    bus.publish("clock", "a/msg/B", "first", 10)
    bus.publish("/clock", "a/msg/B", "second", 20)
    bus.publish("/other", "a/msg/B", "third", 20)
    assert [(m.topic, m.message, m.stamp_ns, m.sequence) for m in sink["clock"]] == [
        ("/clock", "first", 10, 1),
        ("/clock", "second", 20, 2),
    ]
    assert sink["/other"][0].sequence == 1
    assert sink["/nothing"] == []


def test_nobody_listens_until_a_sink_subscribes():
    bus, sink = MessageBus(), MemorySink()
    assert not bus.has_subscribers("/clock")
    bus.subscribe(sink)
    assert bus.has_subscribers("/clock")
    bus.unsubscribe(sink)
    assert not bus.has_subscribers("/clock")


def test_messages_are_counted_also_when_nobody_listens():
    bus = MessageBus()
    bus.publish("/clock", "a/msg/B", None, 1)
    assert bus.topics["/clock"].messages == 1


def test_sequence_numbers_begin_again_and_counts_go_on():
    bus, sink = MessageBus(), MemorySink()
    bus.subscribe(sink)
    bus.publish("/clock", "a/msg/B", None, 1)
    bus.restart()
    bus.publish("/clock", "a/msg/B", None, 1)
    assert [message.sequence for message in sink["/clock"]] == [1, 1]
    assert bus.topics["/clock"].messages == 2


def test_a_counting_sink_shows_topics_that_stayed_silent():
    bus, sink = MessageBus(), CountingSink()
    bus.advertise("points", "a/msg/Cloud", "/World/G/cloud")
    bus.subscribe(sink)
    bus.advertise("scan", "a/msg/Scan")
    bus.publish("/scan", "a/msg/Scan", None, 5)
    bus.publish("/scan", "a/msg/Scan", None, 7)
    counts = {topic: (count.type_name, count.messages, count.first_ns, count.last_ns) for topic, count in sink.topics()}
    assert counts == {"/points": ("a/msg/Cloud", 0, None, None), "/scan": ("a/msg/Scan", 2, 5, 7)}


def test_two_types_on_one_topic_name_both_publishers():
    bus = MessageBus()
    bus.advertise("/scan", "a/msg/Scan", "/World/G/one")
    with pytest.raises(
        RunError, match=r"topic /scan: /World/G/two sends a/msg/Cloud, but /World/G/one sends a/msg/Scan"
    ):
        bus.advertise("scan", "a/msg/Cloud", "/World/G/two")


def test_publishers_of_a_topic_are_listed_once():
    bus = MessageBus()
    for owner in ("/a", "/b", "/a"):
        bus.advertise("/tf", "tf2_msgs/msg/TFMessage", owner)
    assert bus.topics["/tf"].owners == ["/a", "/b"]


def test_close_closes_every_sink_even_when_one_fails():
    closed = []

    class Failing(MemorySink):
        def close(self):
            closed.append("failing")
            raise OSError("disk full")

    class Last(MemorySink):
        def close(self):
            closed.append("last")

    bus = MessageBus()
    bus.subscribe(Failing())
    bus.subscribe(Last())
    with pytest.raises(OSError, match="disk full"):
        bus.close()
    assert closed == ["failing", "last"]
    bus.close()


def test_time_in_sinks_is_measured():
    bus = MessageBus()
    bus.subscribe(MemorySink())
    bus.publish("/clock", "a/msg/B", None, 1)
    assert bus.io_seconds > 0


def test_what_was_due_adds_up_over_plays_and_keeps_no_publisher():
    from graph.sim.messages.message import Cadence, Ticks

    bus, ticks = MessageBus(), Ticks()
    topic = bus.advertise("/points", "std_msgs/msg/String", cadence=Cadence("/World/Lidar", Fraction(20), 2, ticks))
    ticks.count = 9
    assert topic.due == 4  # every second of nine ticks
    bus.restart()
    assert (topic.due, topic.cadences) == (4, [])
    bus.advertise("/points", "std_msgs/msg/String", cadence=Cadence("/World/Lidar", Fraction(20), 2, Ticks(2)))
    assert topic.due == 5
    assert bus.advertise("/clock", "rosgraph_msgs/msg/Clock").due is None
