"""Attributes of prims, read and written by name: OGN types, NumPy arrays, quaternions x, y, z, w."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from graph.node import Attribute, Database, node_type
from graph.values.coercion import coerce, dtype_of, shown
from graph.values.conversion import converter, convertible
from graph.values.types import TYPES, Type

from .stage_prims import PRIM, USE_PATH, edited_layer, find_attribute, find_prim, path_of

NAME = Attribute("token", "name of the attribute, such as xformOp:translate", default="")
HANDLE = Attribute("uint64", "kept for files that carry it; unused")
TOKEN = Attribute("token", "kept for files that carry it; unused")
SET_UP = Attribute("bool", "whether the attribute has been found", default=False)


@node_type(
    "omni.graph.nodes.ReadPrimAttribute",
    version=3,
    volatile=True,
    inputs={
        "name": NAME,
        "prim": PRIM,
        "primPath": Attribute("token", "path of the prim where usePath is set", optional=True, role="prim"),
        "usdTimecode": Attribute(
            "timecode",
            "when to read the stage; nan means the latest value",
            default=math.nan,
            optional=True,
            unit="frames",
        ),
        "usePath": USE_PATH,
    },
    outputs={"value": Attribute("any", "the value, in the type of the attribute")},
    state={
        "correctlySetup": SET_UP,
        "importPath": HANDLE,
        "reimportAtTime": Attribute("bool", "kept for files that carry it; unused"),
        "srcAttrib": HANDLE,
        "srcPath": HANDLE,
        "srcPathAsToken": HANDLE,
        "time": Attribute("double", "time code of the value last read", unit="frames"),
    },
)
def read_prim_attribute(db: Database) -> bool:
    """Read an attribute:

    Fabric's value if one was written, else the stage's; of an animated attribute, the value of now.

    With a usdTimecode it is the stage's value at that time. For a missing prim the outputs keep their values.
    """
    prim = find_prim(db, path_of(db))
    if prim is None:
        return False
    attribute = find_attribute(db, prim, db.inputs.name)
    type_ = _type_of(db, attribute)
    raw = _latest(db, attribute) if math.isnan(db.inputs.usdTimecode) else attribute.Get(db.inputs.usdTimecode)
    if raw is None:
        db.fail(f"{attribute.GetPath()} has no value; author one")
    value, wanted = from_usd(raw, type_), db.output_type("value")
    if wanted is not None and TYPES[wanted] is not type_:
        value = _converted(db, value, type_, TYPES[wanted], f"{attribute.GetPath()} ({type_}) cannot feed {wanted}")
    db.outputs.value = value
    db.state.correctlySetup = True
    return True


@node_type(
    "omni.graph.nodes.WritePrimAttribute",
    version=3,
    inputs={
        "execIn": Attribute("execution", "writes the value"),
        "layerIdentifier": Attribute(
            "token", "layer of the stage to write to; none means its edit target", default="", optional=True
        ),
        "name": NAME,
        "prim": PRIM,
        "primPath": Attribute("token", "path of the prim where usePath is set", default="", optional=True, role="prim"),
        "usdWriteBack": Attribute(
            "bool", "whether the stage gets the value; if not, only Fabric has it", default=True, optional=True
        ),
        "usePath": USE_PATH,
        "value": Attribute("any", "the value to write"),
    },
    outputs={"execOut": Attribute("execution", "follows once the value is written")},
    state={
        "correctlySetup": SET_UP,
        "destAttrib": HANDLE,
        "destPath": HANDLE,
        "destPathToken": HANDLE,
        "layerIdentifier": TOKEN,
        "resolvedLayerIdentifier": TOKEN,
    },
)
def write_prim_attribute(db: Database) -> bool:
    """Write an attribute to the stage, or to Fabric only; a type that does not fit fails, a missing prim is skipped.

    A new transform of a moving body on the stage moves the body.
    """
    prim = find_prim(db, path_of(db))
    if prim is None:
        return False
    attribute = find_attribute(db, prim, db.inputs.name)
    type_ = _type_of(db, attribute)
    value = to_usd(_value_for(db, attribute, type_), type_, attribute)
    fabric, path, name = db.app.fabric, str(prim.GetPath()), db.inputs.name
    if not db.inputs.usdWriteBack or fabric.change_stamp(path, name) >= 0:
        fabric.set(path, name, value)
    if db.inputs.usdWriteBack and attribute.Get() != value:
        with edited_layer(db):
            attribute.Set(value)
        failure = db.app.live.take_failure() if db.app.live is not None else None
        if failure is not None:
            db.fail(str(failure))
    db.state.correctlySetup = True
    db.fire("execOut")
    return True


def _type_of(db: Database, attribute: Any) -> Type:
    type_ = attribute_type(attribute)
    if type_ is None:
        db.fail(f"{attribute.GetPath()} is of type {attribute.GetTypeName()}, which graphs do not have")
    assert type_ is not None
    return type_


def _latest(db: Database, attribute: Any) -> Any:
    """Fabric's value if one was written, else the stage's of now."""
    path, name = str(attribute.GetPrim().GetPath()), attribute.GetName()
    if db.app.fabric.change_stamp(path, name) < 0 and attribute.GetNumTimeSamples():
        db.state.time = db.context.frame
        return attribute.Get(db.state.time)
    return db.app.fabric.get(path, name)


def _value_for(db: Database, attribute: Any, type_: Type) -> Any:
    """The value to write, in the attribute's type; a value from the file may be read as any type that it fits."""
    value, given = db.inputs.value, db.input_type("value")
    message = f"the value ({given or shown(value)}) cannot be written to {attribute.GetPath()} ({type_})"
    if given is None or not db.connected("value"):
        return _coerced(db, value, type_, message)
    return _converted(db, value, TYPES[given], type_, message)


def _converted(db: Database, value: Any, given: Type, wanted: Type, message: str) -> Any:
    if not convertible(given, wanted):
        db.fail(message)
    convert = converter(given, wanted)
    return _coerced(db, value if convert is None else convert(value), wanted, message)


def _coerced(db: Database, value: Any, type_: Type, message: str) -> Any:
    try:
        return coerce(type_, value)
    except ValueError as error:
        return db.fail(f"{message}: {error}")


_PATTERNS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"(point|vector|normal|color|texCoord)([234])([hfd])"), lambda m: f"{m[1].lower()}{m[3]}[{m[2]}]"),
    (re.compile(r"quat([hfd])"), lambda m: f"quat{m[1]}[4]"),
    (re.compile(r"matrix([234])d"), lambda m: f"matrixd[{m[1]}]"),
    (re.compile(r"(int|half|float|double)([234])"), lambda m: f"{m[1]}[{m[2]}]"),
)
_NAMES = {"frame4d": "frame[4]", "asset": "token"}


def attribute_type(attribute: Any) -> Type | None:
    """The OGN type of a stage attribute; None if OGN has no such type."""
    type_name = attribute.GetTypeName()
    element = str(type_name.scalarType)
    name = _NAMES.get(element, element)
    for pattern, naming in _PATTERNS:
        match = pattern.fullmatch(element)
        if match:
            name = naming(match)
    return TYPES.get(f"{name}[]" if type_name.isArray else name)


def from_usd(value: Any, type_: Type) -> Any:
    """The node value of a USD value of an attribute of this type."""
    import numpy as np

    if type_.array:
        return [str(getattr(one, "path", one)) for one in value] if type_.storage == "token" else np.array(value)
    if type_.role == "quat":
        return np.array([*value.GetImaginary(), value.GetReal()], dtype_of(type_))
    if type_.count > 1:
        return np.array(value, dtype_of(type_))
    if type_.role == "timecode":
        return float(value.GetValue() if hasattr(value, "GetValue") else value)
    return str(getattr(value, "path", value)) if type_.storage in ("token", "string") else value


def to_usd(value: Any, type_: Type, attribute: Any) -> Any:
    """The USD value, for the attribute, of a node's value of this type."""
    import numpy as np

    type_name = attribute.GetTypeName()
    kind = type(type_name.defaultValue)
    if type_.array:
        return kind(list(value)) if type_.storage == "token" else kind.FromNumpy(np.array(value, dtype_of(type_)))
    if type_.role == "quat":
        x, y, z, w = map(float, value)
        return kind(w, x, y, z)
    if type_.square:
        return kind(np.asarray(value, float).tolist())
    if type_.count > 1:
        number = int if type_.storage == "int" else float
        return kind(*map(number, value))
    return kind(value)
