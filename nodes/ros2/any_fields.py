"""Attributes made from message fields: `linear:x` for field x of field linear, of any message type."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from graph.base.suggest import did_you_mean
from graph.node import Attribute, Database, KnownTypes, NodeAtLoad
from graph.node.attribute_names import python_name

from .publishing import check_names

FIELD = Attribute("any", "a field of the message; its type comes from the message type", optional=True)


def type_inputs(kind: str) -> dict[str, Attribute]:
    """The three inputs that name a message or service type; kind: msg or srv."""
    example = "Twist of geometry_msgs" if kind == "msg" else "SetBool of std_srvs"
    blank: dict[str, Any] = {"default": ""} if kind == "srv" else {}
    return {
        "messagePackage": Attribute("string", "package of the type, such as that in " + example, **blank),
        "messageSubfolder": Attribute("string", f"{kind}, the folder of the type in its package", default=kind),
        "messageName": Attribute("string", "name of the type", **blank),
    }


def type_name(value: Callable[[str], Any]) -> str:
    """The type that the three inputs name; `value` returns each input; "" while package or name is empty.

    Raises ValueError for an unknown type.
    """
    package, folder, name = (value(one) for one in ("messagePackage", "messageSubfolder", "messageName"))
    if not package or not name:
        return ""
    from graph.sim.messages.ros_types import known, type_names

    full = f"{package}/{folder}/{name}"
    if known(full) or (folder == "srv" and known(f"{full}_Request")):
        return full
    near = did_you_mean(full, {one.removesuffix("_Request").removesuffix("_Response") for one in type_names()})
    raise ValueError(f'there is no ROS 2 type "{full}", here or below AMENT_PREFIX_PATH{near}')


def field_types(known: KnownTypes, parts: Mapping[str, str]) -> dict[str, str]:
    """Types of the attributes that a file adds; for a node type's `resolve`.

    parts: prefix of attribute names ("outputs:", "inputs:Request:") -> message type. Raises ValueError for an attribute
    that is not a field of its message type.
    """
    found: dict[str, str] = {}
    for prefix, message in parts.items():
        fields = _fields(message)
        side = prefix.partition(":")[0]
        for full in known:
            if not full.startswith(f"{side}:") or known[full] is not None:
                continue
            field = full.removeprefix(prefix)
            if not full.startswith(prefix) or field not in fields:
                listed = ", ".join(list(fields)[:12]) or "none"
                raise ValueError(
                    f"{full} is not a field of {message}{did_you_mean(field, fields)}; "
                    f"its fields are {prefix}... {listed}"
                )
            found[full] = fields[field]
    return found


class Fields:
    """Reads and writes the fields of one message type as attributes that the file added to a node.

    names: the added attributes of that side; prefix: of their names ("", "Request:").
    """

    def __init__(self, message: str, names: Iterable[str], prefix: str = "") -> None:
        from graph.sim.messages.ros_fields import leaves, unpack, zero

        self.message = message
        self._zeros = unpack(message, zero(message))
        added = set(names)
        self._places = [
            (place, python_name(prefix + leaf.name))
            for place, leaf in enumerate(leaves(message))
            if prefix + leaf.name in added
        ]

    def read(self, db: Database) -> Any:
        """The message of the node's inputs; fields without an attribute are zero.

        Fails the node, with the field's name, for a wrong value.
        """
        from graph.sim.messages.ros_fields import pack

        values = list(self._zeros)
        for place, name in self._places:
            value = getattr(db.inputs, name)
            if value is not None:
                values[place] = value
        try:
            return pack(self.message, values)
        except ValueError as error:
            db.fail(f"{self.message}: {error}")

    def write(self, db: Database, message: Any) -> None:
        """Sets the node's outputs to the fields of a message."""
        from graph.sim.messages.ros_fields import unpack

        values = unpack(self.message, message)
        for place, name in self._places:
            setattr(db.outputs, name, values[place])


def _fields(message: str) -> dict[str, str]:
    from graph.sim.messages.ros_fields import leaves

    return {leaf.name: leaf.type for leaf in leaves(message)}


def planned_type(db: Database) -> str:
    """The type that the node's inputs name now, "" if it is unknown; for `message_type`."""
    try:
        return type_name(lambda one: getattr(db.inputs, one))
    except ValueError:
        return ""


def check_type(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Reports wrong names, as for every publisher, and an unknown message type; for `check`."""
    yield from check_names(node)
    named = ("messagePackage", "messageSubfolder", "messageName")
    if not any(node.db.connected(f"inputs:{name}") for name in named):
        try:
            type_name(lambda one: getattr(node.db.inputs, one))
        except ValueError as error:
            yield "messageName", str(error)


def required_type(db: Database) -> str:
    """The type that the node's inputs name. Fails the node if they are empty or the type is unknown."""
    try:
        name = type_name(lambda one: getattr(db.inputs, one))
    except ValueError as error:
        db.fail(str(error))
    if not name:
        db.lack("no message type; set messagePackage and messageName")
    return name
