"""The queue and the thread of a live sink, with transports that are as slow, absent or broken as a test wants."""

import threading
import time

import pytest

from graph.recording.transports.sink import LiveSink
from graph.recording.transports.transport import NotSentError
from graph.sim import App
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import deserialize, message_type, serialize

STRING = "std_msgs/msg/String"
TEXT = message_type(STRING)
BYTES = len(serialize(TEXT("x" * 991), STRING))
"""A text of 991 letters: 4 bytes of header, 4 of length, the letters and a zero: 1000."""


class Gate:
    """A transport that sends when its gate is open."""

    place = "nowhere"

    def __init__(self):
        self.sent, self.topics, self.receivers = [], [], {}
        self.open, self.reached, self.closed = threading.Event(), threading.Event(), False

    def advertise(self, topic):
        self.topics.append(topic)

    def matched(self, topic):
        return True

    def send(self, message):
        self.reached.set()
        self.open.wait(120)
        text = deserialize(message.data, message.type_name).data
        if text == "bad":
            raise NotSentError("it is bad")
        self.sent.append(text)

    def subscribe(self, topic, receive):
        self.receivers[topic.name] = receive

    def flush(self, seconds):
        pass

    def close(self):
        self.closed = True

    def notes(self):
        return []


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """A sink that closes waits for what its thread still sends, however busy the machine is."""
    monkeypatch.setattr("graph.recording.transports.sink.LINGER_S", 120.0)


@pytest.fixture
def bus():
    return MessageBus()


def sink_of(bus, transport, **options):
    sink = LiveSink("gate", transport, bus, **options)
    bus.subscribe(sink)
    return sink


def test_what_does_not_fit_into_the_queue_is_dropped_oldest_first_and_counted(bus):
    assert BYTES == 1000
    gate = Gate()
    sink = sink_of(bus, gate, most_bytes=5000)
    bus.publish("/a", STRING, TEXT("x" * 991), 0)
    assert gate.reached.wait(120)  # the first is being sent, so five more fit
    for number in range(1, 13):
        bus.publish("/a", STRING, TEXT(f"{number:991}"), number)
    gate.open.set()
    sink.close()
    assert [text.strip() for text in gate.sent] == ["x" * 991, "8", "9", "10", "11", "12"]
    assert sink.facts()["topics"]["/a"] == {"sent": 6, "dropped": 7, "not_sent": 0, "received": 0}
    [(code, where, message)] = sink.warnings()
    assert (code, where) == ("live-dropped", "gate /a")
    assert message.startswith("dropped 7 of 13 messages, ")


def test_messages_that_nobody_took_are_a_warning(bus):
    gate = Gate()
    gate.matched = lambda topic: False
    gate.open.set()
    sink = sink_of(bus, gate)
    bus.publish("/a", STRING, TEXT("x"), 0)
    sink.close()
    assert [(code, where) for code, where, _ in sink.warnings()] == [("live-no-listener", "gate")]


def test_what_late_subscribers_are_to_get_is_not_dropped(bus):
    gate = Gate()
    sink = sink_of(bus, gate, most_bytes=2000)
    bus.advertise("/tf_static", STRING, quality=Quality(durability="transientLocal"))
    bus.publish("/a", STRING, TEXT(""), 0)
    assert gate.reached.wait(120)
    bus.publish("/tf_static", STRING, TEXT("kept"), 0)
    for number in range(5):
        bus.publish("/a", STRING, TEXT(f"{number:991}"), 0)
    gate.open.set()
    sink.close()
    assert [text.strip() for text in gate.sent] == ["", "kept", "4"]


def test_a_transport_that_hangs_holds_neither_the_publisher_nor_for_long_the_end(bus, monkeypatch):
    monkeypatch.setattr("graph.recording.transports.sink.LINGER_S", 1.0)
    gate = Gate()
    sink = sink_of(bus, gate)
    began = time.monotonic()
    for _ in range(1000):
        bus.publish("/a", STRING, TEXT("x" * 991), 0)
    published = time.monotonic() - began
    sink.close()
    closed = time.monotonic() - began
    gate.open.set()
    assert published < closed  # which waited for its thread; the gate would have taken 120 s a message
    assert sink.counts["/a"].dropped == 999  # all but the one that hangs


def test_a_message_that_cannot_be_sent_is_counted_with_its_reason_and_the_next_goes_out(bus):
    gate = Gate()
    gate.open.set()
    sink = sink_of(bus, gate)
    for data in ("one", "bad", "two"):
        bus.publish("/a", STRING, TEXT(data), 0)
    sink.close()
    assert gate.sent == ["one", "two"]
    assert gate.closed
    assert [*sink.warnings()] == [("live-not-sent", "gate /a", "could not send 1 of 3 messages: it is bad")]


def test_what_is_received_comes_at_the_start_of_an_update_and_is_not_sent_back():
    gate = Gate()
    gate.open.set()
    with App() as app:
        sink = sink_of(app.bus, gate)
        subscription = app.bus.listen("/in", STRING, quality=Quality(reliability="bestEffort"))
        app.play()
        app.update()
        sink.deliver()
        while "/in" not in gate.receivers:
            time.sleep(0.001)
        gate.receivers["/in"](serialize(TEXT("hello"), STRING))
        assert len(subscription) == 0
        sink.deliver()
        assert subscription.take().message.data == "hello"
        sink.close()
    assert gate.sent == []
    assert sink.counts["/in"].received == 1


def test_bytes_that_are_no_message_give_a_warning_and_the_run_goes_on(bus):
    gate = Gate()
    sink = sink_of(bus, gate)
    subscription = bus.listen("/in", "sensor_msgs/msg/JointState")
    sink.deliver()
    while "/in" not in gate.receivers:
        time.sleep(0.001)
    gate.receivers["/in"](b"\x00\x01\x00\x00\xff\xff\xff\xff")
    sink.deliver()
    sink.close()
    assert len(subscription) == 0
    [(code, where, message)] = sink.warnings()
    assert (code, where) == ("live-unreadable", "gate /in")
    assert message.startswith("could not read 1 of the messages from outside: ")


def test_too_much_from_outside_is_dropped_oldest_first_and_counted(bus):
    gate = Gate()
    sink = sink_of(bus, gate, most_bytes=3000)
    subscription = bus.listen("/in", STRING, depth=0)
    sink.deliver()
    while "/in" not in gate.receivers:
        time.sleep(0.001)
    for number in range(7):
        gate.receivers["/in"](serialize(TEXT(f"{number:991}"), STRING))
    sink.deliver()
    sink.close()
    assert [subscription.take().message.data.strip() for _ in range(3)] == ["4", "5", "6"]
    assert [code for code, _, _ in sink.warnings()] == ["live-dropped"]


def test_whoever_floods_a_topic_loses_its_own_messages(bus):
    """Of 40,000 small messages 100 wait for an update; another topic's message is there, in the order of arrival."""
    gate = Gate()
    gate.open.set()
    sink = sink_of(bus, gate)
    flooded, quiet = bus.listen("/flood", STRING, depth=0), bus.listen("/quiet", STRING, depth=0)
    sink.deliver()
    while len(gate.receivers) < 2:
        time.sleep(0.001)
    gate.receivers["/quiet"](serialize(TEXT("here"), STRING))
    data = [serialize(TEXT(str(number)), STRING) for number in range(40_000)]
    for one in data:
        gate.receivers["/flood"](one)
    sink.deliver()
    sink.close()
    assert len(flooded) == 100
    assert flooded.take().message.data == "39900"
    assert quiet.take().message.data == "here"
    [(code, where, message)] = sink.warnings()
    assert (code, where) == ("live-dropped", "gate /flood")
    assert message.startswith("dropped 39,900 of the messages from outside")


def test_a_subscription_of_more_depth_gets_so_many(bus):
    gate = Gate()
    gate.open.set()
    sink = sink_of(bus, gate)
    deep = bus.listen("/in", STRING, quality=Quality(depth=500), depth=0)
    sink.deliver()
    while "/in" not in gate.receivers:
        time.sleep(0.001)
    for number in range(600):
        gate.receivers["/in"](serialize(TEXT(str(number)), STRING))
    sink.deliver()
    sink.close()
    assert len(deep) == 500
