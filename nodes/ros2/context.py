"""The ROS 2 context and the quality of service profiles that publishers and subscribers share."""

from __future__ import annotations

import json
import os

from graph.node import Attribute, Database, node_type

from .profiles import POLICY, PRESETS, SUBSCRIPTION

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"
HIGHEST_DOMAIN = 232


@node_type(
    "isaacsim.ros2.bridge.ROS2Context",
    version=2,
    volatile=True,
    inputs={
        "domain_id": Attribute("uchar", "domain, where the environment does not say", default=0),
        "useDomainIDEnvVar": Attribute("bool", f"whether the variable {DOMAIN_VARIABLE} wins", default=True),
    },
    outputs={"context": Attribute("uint64", "opaque id of the context, the same for all nodes of a domain", default=0)},
)
def ros2_context(db: Database) -> None:
    """Give the handle of a domain's context."""
    domain = db.inputs.domain_id
    text = os.environ.get(DOMAIN_VARIABLE, "") if db.inputs.useDomainIDEnvVar else ""
    if text:
        if not text.isdecimal() or int(text) > HIGHEST_DOMAIN:
            db.fail(f"{DOMAIN_VARIABLE} is {text!r}; it must be a number from 0 to {HIGHEST_DOMAIN}")
        domain = int(text)
    db.outputs.context = domain + 1


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
