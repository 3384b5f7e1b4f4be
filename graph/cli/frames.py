"""The parent of each published transform frame, frames that have two parents, and frames that nobody publishes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass, field
from graph.base.suggest import did_you_mean

from .explain_topics import TIES

if TYPE_CHECKING:
    from graph.sim.messages.bus import MessageBus

TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC = "_static"
CODE = "tf-two-parents"
LISTED = 8


@dataclass(slots=True)
class _Hung:
    """A frame's present parent, the message since which it holds, and former parents."""

    parent: str
    topic: str
    stamp_ns: int
    before: set[str] = field(default_factory=set)


class FrameSink:
    """A sink of all messages; of transforms it keeps each frame's parent, and records frames that have two at a time.

    A frame that changes its parent once is not one of these: TF allows that.
    """

    def __init__(self) -> None:
        self._frames: dict[tuple[str, str], _Hung] = {}
        self._named: dict[str, str] = {}
        """Topic -> the frame that its first message names."""
        self._torn: dict[tuple[str, str], tuple[str, str, tuple[str, ...]]] = {}

    def advertise(self, topic: str, type_name: str) -> None:
        """Does nothing."""

    def write(self, message: Any) -> None:
        """Examines one message."""
        if message.type_name != TRANSFORMS:
            if message.topic not in self._named:
                header = getattr(message.message, "header", None)
                self._named[message.topic] = "" if message.type_name in TIES else getattr(header, "frame_id", "")
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
        """Does nothing."""

    def expect(self, topic: str, frame: str) -> None:
        """Notes the frame that the messages of a topic name, for a topic of which none came."""
        self._named.setdefault(topic, frame)

    def warnings(self, bus: MessageBus) -> Iterator[tuple[str, str, str]]:
        """Code, where and message for each frame with two parents, and each that messages name and no transform has."""
        placed = {frame for _, frame in self._frames} | {hung.parent for hung in self._frames.values()}
        for topic, frame in self._named.items():
            yield from unpublished(topic, bus.topics[topic].owners, frame, placed)
        for (_, frame), (one, other, topics) in self._torn.items():
            owners = dict.fromkeys(owner for topic in topics for owner in bus.topics[topic].owners)
            by = ", ".join(list(owners)[:LISTED]) or "nobody"
            yield (
                CODE,
                " and ".join(topics),
                f'frame "{frame}" hangs on "{one}" and on "{other}" (published by {by}); a tree of frames takes one '
                "parent: leave it out of one of them, or rename it (isaac:nameOverride)",
            )


def unpublished(
    topic: str, senders: Sequence[str], frame: str, placed: Collection[str]
) -> Iterator[tuple[str, str, str]]:
    """Code, where and message if the messages of a topic name a frame that is not placed.

    Nothing where no frame is placed: another program may publish the transforms.
    """
    if placed and frame and frame not in placed:
        yield (
            "frame-unpublished",
            topic,
            f'its messages (of {", ".join(senders) or "nobody"}) name the frame "{frame}", which no published '
            f"transform places; set frameId to a published frame, or publish it{did_you_mean(frame, placed)}",
        )
