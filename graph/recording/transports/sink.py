"""The sink of a live transport: a bounded queue and a thread, so that no listener slows, stops or blocks a run."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from graph.base.errors import RunError, reason_of
from graph.recording.recorded_file import decoding
from graph.sim.messages.bus import MessageBus, Topic
from graph.sim.messages.message import Message

from .inbox import Inbox, Received
from .transport import NotSentError, Outgoing, Transport

QUEUED_BYTES = 64_000_000
"""Most bytes of messages that wait to be sent, and most that wait to be put on the bus."""
DISCOVERY_S = 0.5
"""How long the first message of a topic waits for a listener: discovery takes a moment after the announcement."""
LINGER_S = 2.0
"""How long a sink that closes goes on sending what waits."""


@dataclass(slots=True)
class Counts:
    """What became of a topic's messages; `reason`: why the last one that failed could not be sent or read."""

    sent: int = 0
    dropped: int = 0
    not_sent: int = 0
    received: int = 0
    unreadable: int = 0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class _Task:
    """A call of the transport for a topic."""

    topic: str
    call: Callable[[], None]


class LiveSink:
    """Sends every message of a bus over `transport`, and puts what others publish for its subscriptions on the bus.

    `write` only queues; a thread sends. When more than `most_bytes` wait, the oldest message that is not kept for late
    subscribers (transient local) is dropped. `deliver`, called in every update, puts what was received on the bus.
    `counts` by topic. `close` goes on sending what waits, for two seconds at most.
    """

    def __init__(self, name: str, transport: Transport, bus: MessageBus, most_bytes: int = QUEUED_BYTES) -> None:
        self.name, self.transport = name, transport
        self.counts: dict[str, Counts] = {}
        self._bus, self._most_bytes = bus, most_bytes
        self._inbox = Inbox(most_bytes)
        self._changed = threading.Condition()
        self._tasks: deque[_Task] = deque()
        self._waiting: deque[Outgoing] = deque()
        self._waiting_bytes = 0
        self._subscribed: set[str] = set()
        self._announced_at: dict[str, float] = {}
        self._alone = True
        self._deadline: float | None = None
        self._thread = threading.Thread(target=self._run, name=f"live {name}", daemon=True)
        self._thread.start()
        # A library may take long to leave a listener that takes nothing: in a thread that refers to nothing else, which
        # ends with the process.
        self._closer = threading.Thread(target=transport.close, name=f"live {name} closes", daemon=True)

    def advertise(self, topic: str, type_name: str) -> None:
        """Announces the topic, with the quality that its publisher offers."""
        known = self._bus.topics[topic]
        self._plan(topic, lambda: self._announce(known))

    def write(self, message: Message) -> None:
        """Queues the message, unless this sink has received it from outside."""
        if message.origin is self or self._deadline is not None:
            return
        # Only bytes wait, no arrays of the message: what waits is no more than it counts.
        latched = message.quality.durability == "transientLocal"
        out = Outgoing(message.topic, message.type_name, message.cdr(), message.sent_ns, latched)
        with self._changed:
            self._waiting.append(out)
            self._waiting_bytes += len(out.data)
            while self._waiting_bytes > self._most_bytes and len(self._waiting) > 1:
                self._drop_oldest()
            self._changed.notify()

    def deliver(self) -> None:
        """Puts what was received since the last call on the bus, and subscribes to what the bus listens to by now."""
        for topic, wanted in self._bus.listened().items():
            if topic not in self._subscribed:
                self._subscribed.add(topic)
                self._plan(topic, partial(self._subscribe, Topic(topic, wanted.type_name, wanted.quality)))
        for message in self._inbox.take():
            count = self.counts[message.topic]
            try:
                content = decoding(message.data, message.type_name, f"{self.name} {message.topic}")()
            except RunError as error:
                count.unreadable += 1
                count.reason = str(error)
                continue
            count.received += 1
            self._bus.publish(message.topic, message.type_name, content, self._bus.now_ns, origin=self)

    def close(self) -> None:
        """Sends what waits, for two seconds at most, then leaves the network; calling it twice is harmless."""
        with self._changed:
            if self._deadline is not None:
                return
            self._deadline = time.monotonic() + LINGER_S
            self._changed.notify()
        self._thread.join(LINGER_S + 1)
        with self._changed:
            while self._waiting:
                self._drop_oldest(latched_too=True)
        self._closer.start()
        self._closer.join(1)

    def warnings(self) -> Iterator[tuple[str, str, str]]:
        """Code, where and message of what was lost; call it after `close`."""
        for topic, count in self.counts.items():
            where = f"{self.name} {topic}"
            total = count.dropped + count.sent + count.not_sent
            if count.dropped:
                message = f"dropped {count.dropped:,} of {total:,} messages, which came faster than they were sent"
                yield "live-dropped", where, f"{message}; run with --realtime, or publish less"
            if count.not_sent:
                yield "live-not-sent", where, f"could not send {count.not_sent:,} of {total:,} messages: {count.reason}"
            if count.unreadable:
                message = f"could not read {count.unreadable:,} of the messages from outside: {count.reason}"
                yield "live-unreadable", where, message
            if lost := self._inbox.dropped(topic):
                message = f"dropped {lost:,} of the messages from outside, which came faster than updates took them"
                yield "live-dropped", where, message
        sent = sum(count.sent for count in self.counts.values())
        if sent and self._alone and not any(count.received for count in self.counts.values()):
            message = (
                f"no listener was there: nobody took the {sent:,} messages that were sent to {self.transport.place}"
            )
            yield "live-no-listener", self.name, message
        for code, message in self.transport.notes():
            yield code, self.name, message

    def facts(self) -> dict[str, Any]:
        """What `report.json` holds of this sink: its place, and by topic what became of the messages."""
        shown = ("sent", "dropped", "not_sent", "received")
        topics = {topic: {name: getattr(count, name) for name in shown} for topic, count in self.counts.items()}
        return {"place": self.transport.place, "topics": topics}

    def _plan(self, topic: str, call: Callable[[], None]) -> None:
        with self._changed:
            self.counts.setdefault(topic, Counts())
            self._tasks.append(_Task(topic, call))
            self._changed.notify()

    def _announce(self, topic: Topic) -> None:
        self.transport.advertise(topic)
        self._announced_at[topic.name] = time.monotonic()

    def _subscribe(self, topic: Topic) -> None:
        inbox = self._inbox
        depth = topic.quality.depth
        self.transport.subscribe(topic, lambda data: inbox.put(Received(topic.name, topic.type_name, data), depth))

    def _drop_oldest(self, *, latched_too: bool = False) -> None:
        place = next((at for at, one in enumerate(self._waiting) if latched_too or not one.latched), 0)
        message = self._waiting[place]
        del self._waiting[place]
        self._waiting_bytes -= len(message.data)
        self.counts[message.topic].dropped += 1

    def _run(self) -> None:
        while (task := self._next()) is not None:
            self._do(task)
        self.transport.flush(max(0.0, (self._deadline or 0.0) - time.monotonic()))

    def _next(self) -> _Task | Outgoing | None:
        """The next thing to do, topics before messages; None when the sink closes and all is sent or time is over."""
        with self._changed:
            while True:
                if self._deadline is not None and time.monotonic() > self._deadline:
                    return None
                if self._tasks:
                    return self._tasks.popleft()
                if self._waiting:
                    message = self._waiting.popleft()
                    self._waiting_bytes -= len(message.data)
                    return message
                if self._deadline is not None:
                    return None
                self._changed.wait()

    def _do(self, task: _Task | Outgoing) -> None:
        count = self.counts[task.topic]
        try:
            if isinstance(task, _Task):
                task.call()
            else:
                self._await_listener(task.topic)
                self.transport.send(task)
                count.sent += 1
                self._alone = self._alone and not self.transport.matched(task.topic)
        except Exception as error:  # a network's library may raise anything; a run goes on without its listeners
            count.reason = str(error) if isinstance(error, NotSentError) else reason_of(error)
            count.not_sent += isinstance(task, Outgoing)

    def _await_listener(self, topic: str) -> None:
        announced = self._announced_at.pop(topic, None)
        while announced is not None and not self.transport.matched(topic):
            if self._deadline is not None or time.monotonic() > announced + DISCOVERY_S:
                return
            time.sleep(0.005)
