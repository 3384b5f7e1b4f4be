"""A bounded queue of the messages on one topic."""

from __future__ import annotations

from collections import deque

from .message import Message
from .quality import DEFAULT, Quality


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
