"""The ROS 2 context that publishers share."""

from __future__ import annotations

import os

from graph.node import Attribute, Database, node_type

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
