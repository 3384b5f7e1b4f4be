"""Messages that a transport has received and the bus has not yet got."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Received:
    """One message from outside, as CDR."""

    topic: str
    type_name: str
    data: bytes


class Inbox:
    """Received messages in the order of their arrival; beyond `most_bytes` the oldest are dropped and counted.

    `put` may be called in any thread.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._lock = threading.Lock()
        self._waiting: deque[Received] = deque()
        self._bytes = 0
        self._dropped: dict[str, int] = {}

    def put(self, message: Received) -> None:
        """Adds a message."""
        with self._lock:
            self._waiting.append(message)
            self._bytes += len(message.data)
            while self._bytes > self._most_bytes and len(self._waiting) > 1:
                oldest = self._waiting.popleft()
                self._bytes -= len(oldest.data)
                self._dropped[oldest.topic] = self._dropped.get(oldest.topic, 0) + 1

    def take(self) -> deque[Received]:
        """All messages that wait, which leave the inbox."""
        if not self._waiting:
            return deque()
        with self._lock:
            waiting, self._waiting, self._bytes = self._waiting, deque(), 0
        return waiting

    def dropped(self, topic: str) -> int:
        """How many messages of a topic were dropped."""
        return self._dropped.get(topic, 0)
