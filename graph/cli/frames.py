"""Which frame hangs on which, as far as published transforms say, and frames that hang on two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.sim.messages.bus import MessageBus

TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC = "_static"
CODE = "tf-two-parents"
LISTED = 8


@dataclass(slots=True)
class _Hung:
    """What a frame hangs on at present: the parent, since which message; what it hung on before."""

    parent: str
    topic: str
    stamp_ns: int
    before: set[str] = field(default_factory=set)


class FrameSink:
    """Takes every message; of transforms it keeps each frame's parent, and where there are two at a time.

    A frame that moves from one parent to another, once and for all, is not one of these: TF knows that.
    """

    def __init__(self) -> None:
        self._frames: dict[tuple[str, str], _Hung] = {}
        self._torn: dict[tuple[str, str], tuple[str, str, tuple[str, ...]]] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Nothing to do."""

    def write(self, message: Any) -> None:
        """Looks at one message."""
        if message.type_name != TRANSFORMS:
            return
        tree = message.topic.removesuffix(STATIC)
        for transform in message.message.transforms:
            parent, key = transform.header.frame_id, (tree, transform.child_frame_id)
            known = self._frames.get(key)
            if known is None:
                self._frames[key] = _Hung(parent, message.topic, message.stamp_ns)
            elif known.parent == parent:
                known.stamp_ns = message.stamp_ns
            else:
                static = known.topic.endswith(STATIC) or message.topic.endswith(STATIC)
                if static or parent in known.before or known.stamp_ns == message.stamp_ns:
                    topics = tuple(dict.fromkeys((known.topic, message.topic)))
                    self._torn.setdefault(key, (known.parent, parent, topics))
                before = known.before | {known.parent}
                self._frames[key] = _Hung(parent, message.topic, message.stamp_ns, before)

    def close(self) -> None:
        """Nothing to do."""

    def warnings(self, bus: MessageBus) -> Iterator[tuple[str, str, str]]:
        """Code, where and message for each frame with two parents."""
        for (_, frame), (one, other, topics) in self._torn.items():
            owners = dict.fromkeys(owner for topic in topics for owner in bus.topics[topic].owners)
            by = ", ".join(list(owners)[:LISTED]) or "nobody"
            yield (
                CODE,
                " and ".join(topics),
                f'frame "{frame}" hangs on "{one}" and on "{other}" (published by {by}); a tree of frames takes one '
                "parent: leave it out of one of them, or rename it (isaac:nameOverride)",
            )
