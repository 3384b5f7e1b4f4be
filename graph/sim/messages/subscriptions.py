"""A bounded queue of the messages on one topic."""

from __future__ import annotations

from collections import deque

from .message import Message


class Subscription:
    """What a subscriber has not taken yet, oldest first; when `depth` messages wait, the oldest makes room.

    `topic`, `type_name` and `owner` say what and who; `dropped` counts the messages that made room; depth 0 is no
    limit.
    """

    __slots__ = ("_queue", "dropped", "owner", "topic", "type_name")

    def __init__(self, topic: str, type_name: str, depth: int, owner: str = "") -> None:
        self.topic, self.type_name, self.owner = topic, type_name, owner
        self.dropped = 0
        self._queue: deque[Message] = deque(maxlen=depth or None)

    def put(self, message: Message) -> None:
        """Adds a message."""
        if len(self._queue) == self._queue.maxlen:
            self.dropped += 1
        self._queue.append(message)

    def take(self) -> Message | None:
        """The oldest waiting message, taken off the queue; None if none waits."""
        return self._queue.popleft() if self._queue else None

    def __len__(self) -> int:
        return len(self._queue)
