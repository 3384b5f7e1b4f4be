"""The stage as ROS 2 services: list prims and attributes, read and write attributes as JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at
from nodes.ros2.publishing import check_names, topic_name

PACKAGE = "isaac_ros2_messages/srv"
Answer = Mapping[str, Any]


@dataclass(slots=True)
class _Servers:
    opened: list[tuple[Any, Callable[[Any, Any], Answer]]] = field(default_factory=list)


def _close(db: Database) -> None:
    while db.memory.opened:
        db.app.bus.services.close(db.memory.opened.pop()[0])


def _service(default: str, what: str) -> Attribute:
    return Attribute("string", f"service that {what}; one that begins with / ignores the namespace", default=default)


@node_type(
    "isaacsim.ros2.bridge.ROS2ServicePrim",
    version=1,
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "answers one waiting request of each service"),
        "context": Attribute("uint64", "a ROS2Context; 0 is the default context", default=0),
        "nodeNamespace": Attribute(
            "string", "put before the services; empty takes the isaac:namespace of the prims above", default=""
        ),
        "primsServiceName": _service("get_prims", "lists a prim and all prims below it"),
        "getAttributesServiceName": _service("get_prim_attributes", "lists the attributes of a prim"),
        "getAttributeServiceName": _service("get_prim_attribute", "reads an attribute as JSON"),
        "setAttributeServiceName": _service("set_prim_attribute", "writes an attribute from JSON"),
        "qosProfile": Attribute("string", "quality of service, for live transports", default=""),
    },
    outputs={"execOut": Attribute("execution", "a request was answered")},
    memory=_Servers,
    release=_close,
)
def service_prim(db: Database) -> bool:
    """Serve the stage to the run's service clients (package isaac_ros2_messages).

    Values are JSON: numbers, texts, lists; quaternions are w, x, y, z, matrices are rows as in USD. A request that
    fails is answered with success False and a message; it never stops the run.
    """
    memory = db.memory
    if not memory.opened:
        for attribute, type_name, answer in SERVICES:
            name = getattr(db.inputs, attribute)
            if not name.strip("/ "):
                db.lack(f"input {attribute} is empty; give the service a name")
            server = db.app.bus.services.serve(topic_name(db, db.path, name), f"{PACKAGE}/{type_name}", db.path)
            memory.opened.append((server, answer))
    answered = False
    for server, answer in memory.opened:
        request = server.take()
        if request is not None:
            server.answer(_response(server.type_name, answer(db.app.stage, request)))
            answered = True
    if answered:
        db.fire("execOut")
    return answered


def _response(type_name: str, fields: Answer) -> Any:
    from graph.sim.messages.ros_fields import from_plain

    return from_plain(f"{type_name}_Response", fields)


def _prims(stage: Any, request: Any) -> Answer:
    from graph.sim.usd import Usd

    prim = _prim(stage, request.path)
    if prim is None:
        return _refused(f"Invalid prim: '{request.path}'")
    found = list(Usd.PrimRange(prim))
    return {
        "paths": [str(one.GetPath()) for one in found],
        "types": [str(one.GetTypeName()) for one in found],
        "success": True,
    }


def _attributes(stage: Any, request: Any) -> Answer:
    prim = _prim(stage, request.path)
    if prim is None:
        return _refused(f"Invalid prim: '{request.path}'")
    found = prim.GetAttributes()
    return {
        "names": [one.GetName() for one in found],
        "displays": [one.GetDisplayName() for one in found],
        "types": [str(one.GetTypeName()) for one in found],
        "success": True,
    }


def _read(stage: Any, request: Any) -> Answer:
    attribute, why = _attribute(stage, request)
    if attribute is None:
        return _refused(why)
    value = attribute.Get()
    try:
        text = json.dumps(to_json(value))
    except TypeError:
        return _refused(f"'{request.attribute}' is of type {attribute.GetTypeName()}, which JSON cannot hold")
    return {"value": text, "type": str(attribute.GetTypeName()), "success": True}


def _write(stage: Any, request: Any) -> Answer:
    from graph.sim.scene.prim_attributes import set_property

    attribute, why = _attribute(stage, request)
    if attribute is None:
        return _refused(why)
    try:
        set_property(attribute.GetPrim(), request.attribute, json.loads(request.value))
    except (ValueError, TypeError) as error:
        return _refused(f"'{request.attribute}' does not take {request.value!r:.80}: {error}")
    return {"success": True}


SERVICES: tuple[tuple[str, str, Callable[[Any, Any], Answer]], ...] = (
    ("primsServiceName", "GetPrims", _prims),
    ("getAttributesServiceName", "GetPrimAttributes", _attributes),
    ("getAttributeServiceName", "GetPrimAttribute", _read),
    ("setAttributeServiceName", "SetPrimAttribute", _write),
)
"""Input with the service's name, service type, function that answers a request."""


def _prim(stage: Any, path: str) -> Any:
    """The prim at a path; None for a missing prim or an invalid path."""
    return prim_at(stage, path) or None


def _attribute(stage: Any, request: Any) -> tuple[Any, str]:
    prim = _prim(stage, request.path)
    if prim is None:
        return None, f"Invalid prim: '{request.path}'"
    attribute = prim.GetAttribute(request.attribute)
    return (attribute, "") if attribute else (None, f"Prim has no attribute: '{request.attribute}'")


def to_json(value: Any) -> Any:
    """A USD value as JSON data. Raises TypeError for a value without a JSON form."""
    from graph.sim.usd import Gf, Sdf

    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Gf.Quatd | Gf.Quatf | Gf.Quath):
        return [value.GetReal(), *value.GetImaginary()]
    if isinstance(value, Sdf.AssetPath):
        return value.path
    if isinstance(value, Sdf.TimeCode):
        return value.GetValue()
    if hasattr(value, "__len__") and hasattr(value, "__getitem__"):
        return [to_json(value[index]) for index in range(len(value))]
    raise TypeError(f"{type(value).__name__} has no JSON form")


def _refused(message: str) -> Answer:
    return {"success": False, "message": message}
