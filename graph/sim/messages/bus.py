"""The App's message bus: publishers put ROS 2 messages on topics, sinks receive them."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Any, Protocol

from graph.base.callables import CallableError
from graph.base.errors import RunError
from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.base.suggesting import Suggesting

from .message import DEFAULT, Cadence, Message, Quality
from .services import Services


class Subscription:
    """The waiting messages of a subscriber, oldest first; when `depth` messages wait, a new one drops the oldest.

    `topic`, `type_name` and `owner` identify the subscription; `quality` is what it asks of publishers outside the App;
    `dropped` counts dropped messages; depth 0 means no limit.
    """

    __slots__ = ("_queue", "dropped", "owner", "quality", "topic", "type_name")

    def __init__(self, topic: str, type_name: str, depth: int, owner: str = "", quality: Quality = DEFAULT) -> None:
        self.topic, self.type_name, self.owner, self.quality = topic, type_name, owner, quality
        self.dropped = 0
        self._queue: deque[Message] = deque(maxlen=depth or None)

    def put(self, message: Message) -> None:
        """Adds a message."""
        if len(self._queue) == self._queue.maxlen:
            self.dropped += 1
        self._queue.append(message)

    def take(self) -> Message | None:
        """The oldest waiting message, removed from the queue, or None."""
        return self._queue.popleft() if self._queue else None

    def __len__(self) -> int:
        return len(self._queue)


class Clock(Protocol):
    """Gives the simulation time."""

    @property
    def time(self) -> Fraction:
        """Seconds."""


class Sink(Protocol):
    """Receives published messages; a sink with `reached(now_ns)` also gets the time at which each update begins."""

    def advertise(self, topic: str, type_name: str) -> None:
        """A publisher of `topic` exists."""

    def write(self, message: Message) -> None:
        """Receives one message."""

    def close(self) -> None:
        """Ends receiving; calling it twice is harmless."""


@dataclass(slots=True)
class Topic:
    """A topic: its type, its publishers, the number of messages, the last sequence number, its quality."""

    name: str
    type_name: str
    quality: Quality = DEFAULT
    owners: list[str] = field(default_factory=list)
    messages: int = 0
    sequence: int = 0
    cadences: list[Cadence] = field(default_factory=list)
    """The schedules of its publishers that follow a sensor, of this play, in the order in which they were announced."""
    cadence: Cadence | None = None
    """The schedule of its messages; None if they follow no sensor, or several schedules."""

    due_before: int | None = None
    """Messages that were due by schedules of earlier plays."""

    @property
    def due(self) -> int | None:
        """Messages that were due by the schedules so far; None if its publishers follow no sensor."""
        if self.due_before is None and not self.cadences:
            return None
        return (self.due_before or 0) + sum(cadence.due for cadence in self.cadences)

    def end_play(self) -> None:
        """Ends the schedules: the next play announces its own. Sequence numbers restart at 1."""
        self.due_before, self.sequence = self.due, 0
        self.cadences.clear()

    def refollow(self, before: Cadence, now: Cadence) -> None:
        """Replaces the schedule of a publisher."""
        self.cadences = [now if one is before else one for one in self.cadences]
        self.cadence = now if len(set(self.cadences)) == 1 else None

    def follow(self, cadence: Cadence) -> None:
        """Notes that a publisher of the topic follows this schedule."""
        self.cadences.append(cadence)
        self.cadence = cadence if len(set(self.cadences)) == 1 else None


@dataclass(slots=True)
class _Gathered:
    """Parts of a message that waits for more: its type, its stamp, the function that makes it."""

    type_name: str
    stamp_ns: int
    join: Callable[[list[Any]], Any]
    parts: list[Any] = field(default_factory=list)


class MessageBus(Suggesting):
    """Topics by name (with a leading slash), sinks that receive every topic, and subscriptions that receive one.

    Sinks are called in the order in which they subscribed. A subscription made during an update also gets the messages
    on its topic from earlier in that update, so no message is lost by the order in which nodes compute. clock: the
    simulation time, when messages are sent; without a clock a message is sent at its own stamp.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.clock = clock
        self.topics: dict[str, Topic] = {}
        self.io_seconds = 0.0
        """Real time spent in sinks [s]."""
        self.services = Services()
        self._sinks: list[Sink] = []
        self._timed: dict[Sink, Callable[[int], None]] = {}
        self._subscriptions: dict[str, list[Subscription]] = {}
        self._recent: list[Message] = []
        self._gathered: dict[tuple[str, Quality], _Gathered] = {}
        self._unheard: list[tuple[str, str, int, Callable[[], Any]]] = []

    @property
    def now_ns(self) -> int:
        """The simulation time [ns]; 0 without a clock."""
        return 0 if self.clock is None else nanoseconds(self.clock.time)

    def advertise(
        self,
        topic: str,
        type_name: str,
        owner: str = "",
        quality: Quality = DEFAULT,
        cadence: Cadence | None = None,
    ) -> Topic:
        """Declares that `owner` publishes `type_name` on `topic`. Raises RunError if the topic has another type.

        Of several publishers, the first one's quality is used.
        """
        name = topic_name(topic)
        known = self.topics.get(name)
        if known is None:
            for subscription in self._subscriptions.get(name, ()):
                _same_type(name, type_name, owner, subscription.type_name, subscription.owner, "expects")
            known = self.topics[name] = Topic(name, type_name, quality)
            for sink in self._sinks:
                sink.advertise(name, type_name)
        else:
            _same_type(name, type_name, owner, known.type_name, " and ".join(known.owners), "sends")
        if owner and owner not in known.owners:
            known.owners.append(owner)
        if cadence is not None:
            known.follow(cadence)
        return known

    def has_subscribers(self, topic: str = "") -> bool:
        """Whether any receiver would get a message on `topic` (every sink receives every topic)."""
        return bool(self._sinks) or topic in self._subscriptions

    def is_listened_to(self, topic: str) -> bool:
        """Whether a subscription receives this topic (sinks do not count)."""
        return topic_name(topic) in self._subscriptions

    def count_subscriptions(self, topic: str) -> int:
        """The number of subscriptions to this topic (sinks do not count)."""
        return len(self._subscriptions.get(topic_name(topic), ()))

    def listened(self) -> dict[str, Subscription]:
        """The topics that subscriptions receive, each with its first subscription."""
        return {topic: listed[0] for topic, listed in self._subscriptions.items()}

    def publish(
        self,
        topic: str,
        type_name: str,
        message: Any,
        stamp_ns: int,
        *,
        sent_ns: int | None = None,
        origin: Sink | None = None,
    ) -> None:
        """Gives `message` to every sink, stamped with simulation time [ns]; `sent_ns` replaces the clock's time.

        origin: the sink that received the message from outside.
        """
        known = self.topics.get(topic)
        if known is None or known.type_name != type_name:
            known = self.advertise(topic, type_name)
        known.messages += 1
        known.sequence += 1
        if sent_ns is None:
            sent_ns = stamp_ns if self.clock is None else self.now_ns
        record = Message(
            known.name, type_name, message, stamp_ns, known.sequence, sent_ns, known.quality, known.cadence, origin
        )
        self._recent.append(record)
        for subscription in self._subscriptions.get(known.name, ()):
            subscription.put(record)
        if self._sinks:
            started = time.perf_counter()
            for sink in tuple(self._sinks):
                sink.write(record)
            self.io_seconds += time.perf_counter() - started

    def gather(
        self,
        topic: str,
        type_name: str,
        parts: Sequence[Any],
        join: Callable[[list[Any]], Any],
        stamp_ns: int,
        quality: Quality,
    ) -> None:
        """Publishes `join(parts)` at the end of the phase, together with the parts of others of this quality and stamp.

        A topic that a subscription receives gets its messages at once and apart, because a node may wait for them.
        """
        if topic in self._subscriptions:
            self.publish(topic, type_name, join(list(parts)), stamp_ns)
            return
        waiting = self._gathered.get((topic, quality))
        if waiting is not None and waiting.stamp_ns != stamp_ns:
            self.release()
            waiting = None
        if waiting is None:
            waiting = self._gathered[topic, quality] = _Gathered(type_name, stamp_ns, join)
        waiting.parts += parts

    def release(self) -> None:
        """Publishes what is gathered; the update loop calls it at the end of each phase with graphs."""
        gathered, self._gathered = self._gathered, {}
        for (topic, _), one in gathered.items():
            self.publish(topic, one.type_name, one.join(one.parts), one.stamp_ns)

    def offer(self, topic: str, type_name: str, stamp_ns: int, load: Callable[[], Any]) -> None:
        """Publishes `load()` if a subscription receives the topic, now or by the end of this update; else drops it."""
        name = topic_name(topic)
        if name in self._subscriptions:
            self.publish(name, type_name, load(), stamp_ns, sent_ns=stamp_ns)
        else:
            self._unheard.append((name, type_name, stamp_ns, load))

    def listen(
        self, topic: str, type_name: str, *, depth: int = 10, owner: str = "", quality: Quality = DEFAULT
    ) -> Subscription:
        """A queue of the messages on `topic`, including those of the running update.

        depth: most messages in the queue before the oldest is dropped; 0 means no limit. quality: what it asks of
        publishers outside the App. Raises RunError if the topic has another type.
        """
        name = topic_name(topic)
        if name in self.topics:
            known = self.topics[name]
            _same_type(name, known.type_name, " and ".join(known.owners), type_name, owner, "expects")
        subscription = Subscription(name, type_name, depth, owner, quality)
        for message in self._recent:
            if message.topic == name:
                subscription.put(message)
        self._subscriptions.setdefault(name, []).append(subscription)
        waiting = [offer for offer in self._unheard if offer[0] == name]
        self._unheard = [offer for offer in self._unheard if offer[0] != name]
        for _, offered_type, stamp_ns, load in waiting:
            self.publish(name, offered_type, load(), stamp_ns)
        return subscription

    def unlisten(self, subscription: Subscription) -> None:
        """Ends a subscription; doing so twice is harmless."""
        listed = self._subscriptions.get(subscription.topic, [])
        if subscription in listed:
            listed.remove(subscription)
        if not listed:
            self._subscriptions.pop(subscription.topic, None)

    def begin_update(self) -> None:
        """Starts an update: new subscriptions no longer get the messages of the one before."""
        if self._gathered:  # of a graph that was evaluated between two phases
            self.release()
        self._recent.clear()
        self._unheard.clear()
        if self._timed and self.clock is not None:
            for reached in self._timed.values():
                reached(self.now_ns)

    def restart(self) -> None:
        """Restarts sequence numbers at 1 (at a stop), so that every play publishes the same messages."""
        self.begin_update()
        for topic in self.topics.values():
            topic.end_play()

    def subscribe(self, sink: Sink) -> None:
        """Adds a sink and announces the present topics to it. Raises CallableError without a sink's methods."""
        lacking = [name for name in ("advertise", "write", "close") if not callable(getattr(sink, name, None))]
        if lacking:
            kind, methods = type(sink).__name__, " and ".join(lacking)
            raise CallableError(f"bus.subscribe takes a sink (advertise, write, close); this {kind} has no {methods}")
        self._sinks.append(sink)
        if reached := getattr(sink, "reached", None):
            self._timed[sink] = reached
        for topic in self.topics.values():
            sink.advertise(topic.name, topic.type_name)

    def unsubscribe(self, sink: Sink) -> None:
        """Removes a sink from the bus without closing it."""
        if sink in self._sinks:
            self._sinks.remove(sink)
            self._timed.pop(sink, None)

    def close(self) -> None:
        """Closes every sink, even if one of them fails (the first failure is raised afterwards)."""
        failure: BaseException | None = None
        try:
            self.release()
        except BaseException as error:
            failure = error
        started = time.perf_counter()
        self._timed.clear()
        self._recent.clear()
        self._unheard.clear()
        while self._sinks:
            try:
                self._sinks.pop(0).close()
            except BaseException as error:
                failure = failure or error
        self.io_seconds += time.perf_counter() - started
        if failure is not None:
            raise failure


class MemorySink:
    """Stores every message by topic; for tests and for reading results in Python."""

    def __init__(self) -> None:
        self.messages: dict[str, list[Message]] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Lists the topic, without messages."""
        self.messages.setdefault(topic, [])

    def write(self, message: Message) -> None:
        """Stores the message."""
        self.messages.setdefault(message.topic, []).append(message)

    def close(self) -> None:
        """Keeps its messages."""

    def __getitem__(self, topic: str) -> list[Message]:
        """The messages of a topic; empty if no message was published."""
        return self.messages.get(topic_name(topic), [])


@dataclass(slots=True)
class TopicCount:
    """The number of messages of a topic, and the simulation times [ns] of the first and the last."""

    type_name: str
    messages: int = 0
    first_ns: int | None = None
    last_ns: int | None = None


class CountingSink:
    """Counts messages by topic, without storing them."""

    def __init__(self) -> None:
        self._counts: dict[str, TopicCount] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Lists the topic with count 0."""
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
        """Every topic with its count, in order of first appearance, including topics without messages."""
        return self._counts.items()


def _same_type(topic: str, sent: str, sender: str, other: str, who: str, does: str) -> None:
    if sent != other:
        raise RunError(
            f"topic {topic}: {sender or 'a publisher'} sends {sent}, but "
            f"{who or ('another' if does == 'sends' else 'a subscriber')} {does} {other}; rename one of the two topics"
        )


def topic_name(topic: str) -> str:
    """The topic with its leading slash."""
    return topic if topic.startswith("/") else f"/{topic}"
