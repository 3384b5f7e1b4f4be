"""Quality of service profiles as texts: the offers of publishers and the queue lengths of subscribers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from graph.node import Database
from graph.sim.messages.message import DEFAULT, Quality

SUBSCRIPTION = "Default for publishers/subscribers"
POLICY = ("history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness", "leaseDuration")
_NO_TIMES = {"deadline": 0.0, "lifespan": 0.0, "leaseDuration": 0.0}
_USUAL = {
    "history": "keepLast",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "liveliness": "systemDefault",
    **_NO_TIMES,
}
PRESETS: Mapping[str, Mapping[str, Any]] = {
    SUBSCRIPTION: _USUAL,
    "Services": _USUAL,
    "Sensor Data": {**_USUAL, "depth": 5, "reliability": "bestEffort"},
    "System Default": {
        "history": "systemDefault",
        "depth": 0,
        "reliability": "systemDefault",
        "durability": "systemDefault",
        "liveliness": "systemDefault",
        **_NO_TIMES,
    },
}
"""The policies of createProfile's presets, which replace the policy inputs."""


def queue_depth(db: Database) -> int:
    """How many messages a subscriber's queue holds; 0 means no limit. From qosProfile if set, else queueSize.

    Fails the node if qosProfile is not a profile.
    """
    try:
        profile = _profile(db.inputs.qosProfile)
    except ValueError as error:
        db.fail(f"{error}; connect the output of a ROS2QoSProfile, or leave it empty")
    if profile.get("history") == "keepAll":
        return 0
    return max(int(profile.get("depth", db.inputs.queueSize)), 1)


def offered_quality(db: Database, *, latched: bool = False) -> Quality:
    """What a publisher offers: its qosProfile if set, else ROS 2's default with queueSize.

    latched: the last message is kept for late subscribers, as of /tf_static. An invalid qosProfile gives a warning
    (`qos-profile-unknown`) and the default; a node without that input offers the default too.
    """
    profile: Mapping[str, Any] = {}
    if "qosProfile" not in db.node.type.inputs:
        return DEFAULT
    try:
        profile = _profile(db.inputs.qosProfile)
    except ValueError as error:
        db.warn("qos-profile-unknown", f"{error}; the default is noted beside its topic")
    profile = {**_USUAL, "depth": int(db.inputs.queueSize), **profile}
    return Quality(
        history=str(profile["history"]),
        depth=profile["depth"],
        reliability=str(profile["reliability"]),
        durability="transientLocal" if latched else str(profile["durability"]),
        deadline_ns=_nanoseconds(profile["deadline"]),
        lifespan_ns=_nanoseconds(profile["lifespan"]),
        liveliness=str(profile["liveliness"]),
        lease_ns=_nanoseconds(profile["leaseDuration"]),
    )


def profile_fault(text: str) -> str:
    """What is wrong with the text of a profile; "" if nothing is."""
    try:
        _profile(text)
    except ValueError as error:
        return str(error)
    return ""


def _profile(text: str) -> Mapping[str, Any]:
    """The policies in the text of a profile; empty for an empty text. Raises ValueError if it is not a profile."""
    if not text:
        return {}
    try:
        profile = json.loads(text)
    except ValueError:
        profile = None
    if not isinstance(profile, dict) or not profile.keys() <= set(POLICY):
        raise ValueError(f"qosProfile {text!r:.60} is not a profile")
    depth = profile.get("depth", 0)
    if not isinstance(depth, int) or isinstance(depth, bool) or depth < 0:
        raise ValueError(f"qosProfile: depth {depth!r} is not a number of messages")
    return profile


def _nanoseconds(seconds: Any) -> int:
    """A time of a profile; 0, no limit, for anything that is not a span of time."""
    usual = isinstance(seconds, int | float) and 0 < seconds < 2**33
    return round(seconds * 10**9) if usual else 0
