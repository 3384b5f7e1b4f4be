"""The meaning of ids in sensor data, as ROS 2 topics of JSON text."""

from __future__ import annotations

import json
from functools import partial
from typing import Any

from graph.node import Attribute, Database, node_type
from sensors import handles

from .messages import STRING, object_id_map, stamped_json
from .publishing import Publisher, check_names, publishes, stamped_inputs

CLASS = "class:"


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishSemanticLabels",
    version=1,
    check=check_names,
    inputs={
        **stamped_inputs("labels"),
        "ids": Attribute("uint[]", "semantic ids", role="data"),
        "labels": Attribute("token[]", "one text per id; `class:car` is the class car", role="data"),
        "semantics": Attribute("token[]", "kinds of the labels; not part of the message"),
        "idToLabels": Attribute("string", "JSON of ids to labels; where set, ids and labels are not read", role="data"),
    },
    memory=partial(Publisher, STRING),
)
@publishes
def publish_semantic_labels(db: Database, nanoseconds: int) -> Any:
    """Publish `std_msgs/String`: JSON of ids to labels, with the stamp as time_stamp."""
    return stamped_json(_content(db), nanoseconds)


def _content(db: Database) -> dict[str, Any]:
    inputs = db.inputs
    if inputs.idToLabels:
        try:
            content: Any = json.loads(inputs.idToLabels)
        except ValueError as error:
            db.fail(f"idToLabels is not JSON ({error})")
        if not isinstance(content, dict):
            db.fail("idToLabels is not a JSON object of ids to labels")
        return dict(content)
    ids, labels = inputs.ids.tolist(), inputs.labels
    if len(ids) != len(labels):
        db.fail(f"there are {len(ids)} ids and {len(labels)} labels; give one label for each id")
    return {
        str(number): {"class": label.removeprefix(CLASS)} if label.startswith(CLASS) else label
        for number, label in zip(ids, labels, strict=True)
    }


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishObjectIdMap",
    version=1,
    check=check_names,
    inputs={
        **stamped_inputs("labels"),
        "dataPtr": Attribute(
            "uint64", "handle of a StableIdMap: its buffer, or a mapping of ids to prim paths", default=0, role="data"
        ),
        "bufferSize": Attribute("uint", "size of dataPtr; not needed, the handle knows", default=0, unit="bytes"),
    },
    memory=partial(Publisher, STRING),
)
@publishes
def publish_object_id_map(db: Database, nanoseconds: int) -> Any:
    """Publish `std_msgs/String`: JSON of 128-bit object ids to prim paths; without a map nothing is sent."""
    found = handles.resolve(db.inputs.dataPtr) if db.inputs.dataPtr else None
    if found is None:
        return None
    if not isinstance(found, dict):
        from sensors import parse_stable_id_map_data

        found = parse_stable_id_map_data(found)
    return object_id_map(found, nanoseconds)
