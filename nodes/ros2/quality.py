"""Quality of service: the profile node and what readers take from its text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from graph.node import Attribute, Database, node_type

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
"""What the presets of createProfile set, whatever the policy inputs say."""


@node_type(
    "isaacsim.ros2.bridge.ROS2QoSProfile",
    version=1,
    inputs={
        "createProfile": Attribute(
            "token",
            "a preset, which wins over the other inputs; Custom (and the default) takes the other inputs",
            default="defaultPubSub",
            allowed_tokens=(*(SUBSCRIPTION, "Services", "Sensor Data", "System Default"), "Custom"),
        ),
        "history": Attribute(
            "token",
            "keep the last `depth` messages, or all",
            default="keepLast",
            allowed_tokens=("systemDefault", "keepLast", "keepAll", "unknown"),
        ),
        "depth": Attribute("uint64", "queue length where history is keepLast", default=10, unit="messages"),
        "reliability": Attribute(
            "token",
            "whether lost messages are sent again",
            default="reliable",
            allowed_tokens=("systemDefault", "reliable", "bestEffort", "unknown"),
        ),
        "durability": Attribute(
            "token",
            "whether late subscribers get earlier messages",
            default="volatile",
            allowed_tokens=("systemDefault", "transientLocal", "volatile", "unknown"),
        ),
        "deadline": Attribute("double", "longest time between two messages; 0 is any", default=0.0, unit="s"),
        "lifespan": Attribute("double", "longest time from sending to receiving; 0 is any", default=0.0, unit="s"),
        "liveliness": Attribute(
            "token",
            "how a publisher shows that it is alive",
            default="systemDefault",
            allowed_tokens=("systemDefault", "automatic", "manualByTopic", "unknown"),
        ),
        "leaseDuration": Attribute("double", "longest time without a sign of life; 0 is any", default=0.0, unit="s"),
    },
    outputs={"qosProfile": Attribute("string", "the profile as JSON, for the qosProfile input of other nodes")},
)
def qos_profile(db: Database) -> None:
    """Build a quality of service profile. In a run, history and depth shape subscribers' queues; the rest is kept."""
    preset = PRESETS.get(db.inputs.createProfile)
    profile = preset or {name: getattr(db.inputs, name) for name in POLICY}
    db.outputs.qosProfile = json.dumps({name: profile[name] for name in POLICY})


def queue_depth(db: Database) -> int:
    """How many messages a subscriber's queue holds; 0 is no limit. From qosProfile where it is set, else queueSize.

    Fails the node where qosProfile is no profile.
    """
    text = db.inputs.qosProfile
    if not text:
        return max(int(db.inputs.queueSize), 1)
    try:
        profile = json.loads(text)
    except ValueError:
        profile = None
    if not isinstance(profile, dict) or not profile.keys() <= set(POLICY):
        db.fail(f"qosProfile {text!r:.60} is no profile; connect the output of a ROS2QoSProfile, or leave it empty")
    if profile.get("history") == "keepAll":
        return 0
    depth = profile.get("depth", db.inputs.queueSize)
    if not isinstance(depth, int) or isinstance(depth, bool) or depth < 0:
        db.fail(f"qosProfile: depth {depth!r} is no number of messages")
    return max(int(depth), 1)
