"""Services between nodes of one run: a client asks, a server receives the request and sends the response.

Fields are attributes: `Request:a` on the client's inputs and the server's outputs, `Response:sum` on the server's
inputs and the client's outputs. A server takes one request for each compute, and answers in the order of the requests.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, KnownTypes, node_type
from nodes.ros2.any_fields import FIELD, Fields, check_type, field_types, required_type, type_inputs, type_name
from nodes.ros2.publishing import topic_name

SHARED = {
    "context": Attribute("uint64", "a ROS2Context; 0 is the default context", default=0),
    "nodeNamespace": Attribute(
        "string", "put before the service; empty takes the isaac:namespace of the prims above", default=""
    ),
}
SERVICE = {
    **SHARED,
    "serviceName": Attribute(
        "string", "service; one that begins with / ignores the namespace", default="/service_name"
    ),
    **type_inputs("srv"),
    "qosProfile": Attribute("string", "quality of service, for live transports", default=""),
}
HANDLE = "the server, for its ROS2ServiceServerResponse"


def _resolving(parts: Mapping[str, str]) -> Any:
    """A node type's `resolve`: attribute beginning -> part of the service (Request, Response)."""

    def resolve(known: KnownTypes) -> Mapping[str, str]:
        name = type_name(known.value)
        return field_types(known, {start: f"{name}_{part}" for start, part in parts.items()}) if name else {}

    return resolve


def _service_type(db: Database) -> str:
    name = required_type(db)
    if db.inputs.messageSubfolder != "srv":
        db.fail(f'{name} is not a service type; messageSubfolder is "srv" for services')
    return name


def _service_name(db: Database) -> str:
    name: str = db.inputs.serviceName
    if not name.strip("/ "):
        db.lack("input serviceName is empty; give the service a name")
    return topic_name(db, db.path, name)


@dataclass(slots=True)
class _Server:
    server: Any = None
    fields: Fields | None = None


def _close(db: Database) -> None:
    if db.memory.server is not None:
        db.app.bus.services.close(db.memory.server)
        db.memory.server = None


@node_type(
    "isaacsim.ros2.bridge.OgnROS2ServiceServerRequest",
    version=1,
    needs=(("serviceName",), ("messagePackage",), ("messageName",)),
    check=check_type,
    inputs={"execIn": Attribute("execution", "takes the next request, if one has come"), **SERVICE},
    outputs={
        "onReceived": Attribute("execution", "a request was taken"),
        "serverHandle": Attribute("uint64", HANDLE, default=0),
    },
    dynamic_outputs={"{field}": FIELD},
    resolve=_resolving({"outputs:Request:": "Request"}),
    memory=_Server,
    release=_close,
)
def service_server_request(db: Database) -> bool:
    """Take the oldest waiting request; its fields are the outputs Request:..."""
    memory = db.memory
    if memory.server is None:
        name = _service_type(db)
        memory.fields = Fields(f"{name}_Request", db.dynamic_outputs(""), "Request:")
        memory.server = db.app.bus.services.serve(_service_name(db), name, db.path)
        db.outputs.serverHandle = memory.server.handle
    request = memory.server.take()
    if request is None:
        return False
    memory.fields.write(db, request)
    db.fire("onReceived")
    return True


@dataclass(slots=True)
class _Answer:
    fields: Fields | None = None


@node_type(
    "isaacsim.ros2.bridge.OgnROS2ServiceServerResponse",
    version=1,
    check=check_type,
    inputs={
        "onReceived": Attribute("execution", "sends the response to the oldest request that is not answered"),
        **SHARED,
        "serverHandle": Attribute("uint64", "serverHandle of a ROS2ServiceServerRequest", default=0),
        **type_inputs("srv"),
    },
    outputs={"execOut": Attribute("execution", "the response was sent")},
    dynamic_inputs={"{field}": FIELD},
    resolve=_resolving({"inputs:Response:": "Response"}),
    memory=_Answer,
)
def service_server_response(db: Database) -> bool:
    """Answer the oldest open request with the inputs Response:...; missing fields are zero or empty."""
    server = db.app.bus.services.server(db.inputs.serverHandle)
    if server is None:
        return False
    memory = db.memory
    if memory.fields is None:
        name = _service_type(db)
        if name != server.type_name:
            db.fail(f"the server {server.owner} is of type {server.type_name}, this response of {name}")
        memory.fields = Fields(f"{name}_Response", db.dynamic_input_names(), "Response:")
    if not server.open or not server.answer(memory.fields.read(db)):
        return False
    db.fire("execOut")
    return True


@dataclass(slots=True)
class _Client:
    name: str = ""
    type_name: str = ""
    request: Fields | None = None
    response: Fields | None = None
    call: Any = None


@node_type(
    "isaacsim.ros2.bridge.OgnROS2ServiceClient",
    version=1,
    needs=(("serviceName",), ("messagePackage",), ("messageName",)),
    check=check_type,
    inputs={"execIn": Attribute("execution", "asks, or looks whether the answer has come"), **SERVICE},
    outputs={"execOut": Attribute("execution", "a response came")},
    dynamic_inputs={"{field}": FIELD},
    dynamic_outputs={"{field}": FIELD},
    resolve=_resolving({"inputs:Request:": "Request", "outputs:Response:": "Response"}),
    memory=_Client,
)
def service_client(db: Database) -> bool:
    """Send the inputs Request:... as a request; the response's fields are the outputs Response:...

    One request is open at a time: each compute looks for its response, and sends the next request in the same compute.
    Without a server nothing is sent.
    """
    memory = db.memory
    if memory.request is None or memory.response is None:
        memory.type_name = _service_type(db)
        memory.name = _service_name(db)
        memory.request = Fields(f"{memory.type_name}_Request", db.dynamic_input_names(), "Request:")
        memory.response = Fields(f"{memory.type_name}_Response", db.dynamic_outputs(""), "Response:")
    answered = memory.call is not None and memory.call.response is not None
    if answered:
        memory.response.write(db, memory.call.response)
        memory.call = None
        db.fire("execOut")
    if memory.call is None or memory.call.lost:
        services = db.app.bus.services
        memory.call = services.call(memory.name, memory.type_name, memory.request.read(db), db.path)
    return answered or memory.call is not None
