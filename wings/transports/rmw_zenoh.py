"""The names and bytes of rmw_zenoh, ROS 2's middleware over zenoh: key expressions, liveliness tokens, attachments.

After rmw_zenoh's docs/design.md and its `liveliness_utils`.
"""

from __future__ import annotations

import struct

from graph.sim.messages.bus import Topic
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import type_hash

from .dds_types import dds_name

NODE = "tickgraph"
"""The ROS 2 node under which the topics of a run are listed."""
PUBLISHER, SUBSCRIPTION = "MP", "MS"
_DEFAULT_DEPTH = 42
"""The depth that rmw_zenoh takes for 0, and leaves out of tokens."""
_GID_BYTES = 16


def topic_key(domain: int, topic: Topic) -> str:
    """The key on which a topic's messages are sent. Raises ValueError for types without a hash."""
    return f"{domain}/{topic.name.strip('/')}/{dds_name(topic.type_name)}/{type_hash(topic.type_name)}"


def node_token(domain: int, session: str) -> str:
    """The liveliness token of the node; session: the zenoh id, in hexadecimal."""
    return f"@ros2_lv/{domain}/{session}/0/0/NN/%/%/{NODE}"


def topic_token(domain: int, session: str, number: int, kind: str, topic: Topic) -> str:
    """The liveliness token of a publisher or subscription; number: its own in this session, from 1."""
    names = f"{topic.name.replace('/', '%')}/{dds_name(topic.type_name)}/{type_hash(topic.type_name)}"
    return f"@ros2_lv/{domain}/{session}/0/{number}/{kind}/%/%/{NODE}/{names}/{quality_key(topic.quality)}"


def quality_key(quality: Quality) -> str:
    """A quality of service as tokens have it: the numbers of rmw/types.h, nothing for those of the default."""
    reliability = "2" if quality.reliability == "bestEffort" else ""
    durability = "1" if quality.durability == "transientLocal" else ""
    history = "2" if quality.history == "keepAll" else ""
    depth = str(quality.depth) if quality.depth not in (0, _DEFAULT_DEPTH) else ""
    liveliness = "3" if quality.liveliness == "manualByTopic" else ""
    deadline, lifespan, lease = map(_time, (quality.deadline_ns, quality.lifespan_ns, quality.lease_ns))
    return f"{reliability}:{durability}:{history},{depth}:{deadline}:{lifespan}:{liveliness},{lease}"


def gid(token: str) -> bytes:
    """The 16 bytes that identify the owner of a token: its XXH3 hash, the low word first."""
    import xxhash

    digest: bytes = xxhash.xxh3_128_digest(token.encode())
    return digest[::-1]


def attachment(sequence: int, source_ns: int, identity: bytes) -> bytes:
    """The 33 bytes beside each message: sequence number and wall time [ns] as int64, the length 16, the `gid`."""
    return struct.pack("<qqB", sequence, source_ns, _GID_BYTES) + identity


def _time(nanoseconds: int) -> str:
    return ",".join(map(str, divmod(nanoseconds, 10**9))) if nanoseconds else ","
