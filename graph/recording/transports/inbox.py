"""Messages that a transport has received and the bus has not yet got."""

from __future__ import annotations

import heapq
import threading
from collections import Counter, deque
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Received:
    """One message from outside, as CDR."""

    topic: str
    type_name: str
    data: bytes


MOST_MESSAGES = 100
"""Messages of a topic that wait for an update, at most; a topic's own depth may be larger."""


class Inbox:
    """Received messages in the order of their arrival.

    Beyond `most_bytes` in all, or a topic's depth, the oldest are dropped and counted: a publisher that floods a topic
    loses its own messages, and an update never has more than that to put on the bus. `put` may be called in any thread.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._lock = threading.Lock()
        self._waiting: dict[str, deque[tuple[int, Received]]] = {}
        self._bytes = self._arrived = 0
        self._dropped: Counter[str] = Counter()

    def put(self, message: Received, depth: int = 0) -> None:
        """Adds a message of a topic of which so many may wait."""
        with self._lock:
            queue = self._waiting.setdefault(message.topic, deque())
            queue.append((self._arrived, message))
            self._arrived += 1
            self._bytes += len(message.data)
            if len(queue) > max(depth, MOST_MESSAGES):
                self._drop(queue)
            while self._bytes > self._most_bytes and sum(map(len, self._waiting.values())) > 1:
                self._drop(min(filter(None, self._waiting.values()), key=lambda one: one[0][0]))

    def take(self) -> list[Received]:
        """All messages that wait, which leave the inbox."""
        if not self._bytes and not any(self._waiting.values()):
            return []
        with self._lock:
            waiting, self._waiting, self._bytes = self._waiting, {}, 0
        return [message for _, message in heapq.merge(*waiting.values(), key=lambda one: one[0])]

    def dropped(self, topic: str) -> int:
        """How many messages of a topic were dropped."""
        return self._dropped[topic]

    def _drop(self, queue: deque[tuple[int, Received]]) -> None:
        _, oldest = queue.popleft()
        self._bytes -= len(oldest.data)
        self._dropped[oldest.topic] += 1
