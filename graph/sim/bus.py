"""The App's message bus: publishers put ROS 2 messages on topics, sinks receive them."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol

from graph.errors import RunError


@dataclass(frozen=True, slots=True)
class Message:
    """One published message; `stamp_ns` is simulation time, `sequence` counts from 1 on its topic since play."""

    topic: str
    type_name: str
    message: Any
    stamp_ns: int
    sequence: int


class Sink(Protocol):
    """Receives what is published."""

    def advertise(self, topic: str, type_name: str) -> None:
        """A publisher of `topic` exists."""

    def write(self, message: Message) -> None:
        """Takes one message."""

    def close(self) -> None:
        """Takes no more; calling it twice is harmless."""


@dataclass(slots=True)
class Topic:
    """A topic: its type, who publishes, how many messages so far, the sequence number of the last one."""

    name: str
    type_name: str
    owners: list[str] = field(default_factory=list)
    messages: int = 0
    sequence: int = 0


class MessageBus:
    """Topics by name (with a leading slash) and the sinks, called in the order in which they subscribed."""

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.io_seconds = 0.0
        """Real time spent in sinks [s]."""
        self._sinks: list[Sink] = []

    def advertise(self, topic: str, type_name: str, owner: str = "") -> Topic:
        """Declares that `owner` publishes `type_name` on `topic`. Raises RunError if the topic has another type."""
        name = topic_name(topic)
        known = self.topics.get(name)
        if known is None:
            known = self.topics[name] = Topic(name, type_name)
            for sink in self._sinks:
                sink.advertise(name, type_name)
        elif known.type_name != type_name:
            raise RunError(
                f"topic {name}: {owner or 'a publisher'} sends {type_name}, but "
                f"{' and '.join(known.owners) or 'another'} sends {known.type_name}; rename one of the two topics"
            )
        if owner and owner not in known.owners:
            known.owners.append(owner)
        return known

    def has_subscribers(self, topic: str = "") -> bool:
        """Whether anybody would receive a message on `topic` (every sink receives every topic)."""
        return bool(self._sinks)

    def publish(self, topic: str, type_name: str, message: Any, stamp_ns: int) -> None:
        """Hands `message` to every sink, stamped with simulation time [ns]."""
        known = self.topics.get(topic)
        if known is None or known.type_name != type_name:
            known = self.advertise(topic, type_name)
        known.messages += 1
        known.sequence += 1
        if self._sinks:
            record = Message(known.name, type_name, message, stamp_ns, known.sequence)
            started = time.perf_counter()
            for sink in tuple(self._sinks):
                sink.write(record)
            self.io_seconds += time.perf_counter() - started

    def restart(self) -> None:
        """Sequence numbers begin at 1 again (stop), so that every play publishes the same messages."""
        for topic in self.topics.values():
            topic.sequence = 0

    def subscribe(self, sink: Sink) -> None:
        """Adds a sink; it learns of the topics advertised so far."""
        self._sinks.append(sink)
        for topic in self.topics.values():
            sink.advertise(topic.name, topic.type_name)

    def unsubscribe(self, sink: Sink) -> None:
        """Takes a sink off the bus without closing it."""
        if sink in self._sinks:
            self._sinks.remove(sink)

    def close(self) -> None:
        """Closes every sink, also when one of them fails (the first failure is raised afterwards)."""
        failure: BaseException | None = None
        started = time.perf_counter()
        while self._sinks:
            try:
                self._sinks.pop(0).close()
            except BaseException as error:
                failure = failure or error
        self.io_seconds += time.perf_counter() - started
        if failure is not None:
            raise failure


class MemorySink:
    """Keeps every message by topic; for tests and for reading results in Python."""

    def __init__(self) -> None:
        self.messages: dict[str, list[Message]] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Shows the topic, without messages."""
        self.messages.setdefault(topic, [])

    def write(self, message: Message) -> None:
        """Keeps the message."""
        self.messages.setdefault(message.topic, []).append(message)

    def close(self) -> None:
        """Keeps what it has."""

    def __getitem__(self, topic: str) -> list[Message]:
        """The messages of a topic; none if nobody published it."""
        return self.messages.get(topic_name(topic), [])


@dataclass(slots=True)
class TopicCount:
    """How many messages a topic got, and the simulation times [ns] of its first and last."""

    type_name: str
    messages: int = 0
    first_ns: int | None = None
    last_ns: int | None = None


class CountingSink:
    """Counts messages by topic, without keeping them."""

    def __init__(self) -> None:
        self._counts: dict[str, TopicCount] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Shows the topic with count 0."""
        self._counts.setdefault(topic, TopicCount(type_name))

    def write(self, message: Message) -> None:
        """Counts the message."""
        count = self._counts.setdefault(message.topic, TopicCount(message.type_name))
        count.messages += 1
        count.last_ns = message.stamp_ns
        if count.first_ns is None:
            count.first_ns = message.stamp_ns

    def close(self) -> None:
        """Keeps its counts."""

    def topics(self) -> Iterable[tuple[str, TopicCount]]:
        """Every topic with its count, in order of first appearance, those that stayed silent included."""
        return self._counts.items()


def topic_name(topic: str) -> str:
    """The topic with its leading slash."""
    return topic if topic.startswith("/") else f"/{topic}"
