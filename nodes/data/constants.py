"""Constants: `inputs:value` is both the value and the source of connections."""

from __future__ import annotations

from typing import Any

from graph.node import UNSET, Attribute, declare

# Name after "Constant" -> (attribute type, default; UNSET: the type's own zero).
_PLAIN: dict[str, tuple[str, Any]] = {
    "Bool": ("bool", False),
    "Int": ("int", 0),
    "Int64": ("int64", 0),
    "UChar": ("uchar", 0),
    "UInt": ("uint", 0),
    "UInt64": ("uint64", 0),
    "Half": ("half", 0.0),
    "Float": ("float", 0.0),
    "Double": ("double", 0.0),
    "Timecode": ("timecode", 0.0),
    "String": ("string", ""),
    "Token": ("token", ""),
    "Path": ("path", ""),
    "Target": ("target", UNSET),
    "Quatd": ("quatd[4]", UNSET),
    "Quatf": ("quatf[4]", UNSET),
    "Quath": ("quath[4]", UNSET),
    "Matrix2d": ("matrixd[2]", UNSET),
    "Matrix3d": ("matrixd[3]", UNSET),
    "Matrix4d": ("matrixd[4]", UNSET),
    "Frame": ("frame[4]", UNSET),
}
_TUPLES = [
    (f"{kind.capitalize()}{n}", f"{kind}[{n}]", n) for kind in ("int", "half", "float", "double") for n in (2, 3, 4)
]
_ROLES = [
    (f"{name}{n}{suffix}", f"{role}{suffix}[{n}]", n)
    for name, role, sizes in (
        ("Color", "color", (3, 4)),
        ("Normal", "normal", (3,)),
        ("Point", "point", (3,)),
        ("TexCoord", "texcoord", (2, 3)),
        ("Vector", "vector", (3,)),
    )
    for n in sizes
    for suffix in "dfh"
]


def _declare(name: str, ogn_type: str, default: Any) -> None:
    value = Attribute(ogn_type, "the value; connect it to any input that takes it", default=default, output_only=True)
    declare(
        f"omni.graph.nodes.Constant{name}",
        f"A constant of type {ogn_type}; it never computes.",
        inputs={"value": value},
    )


for _name, (_type, _default) in _PLAIN.items():
    _declare(_name, _type, _default)
for _name, _type, _size in (*_TUPLES, *_ROLES):
    _declare(_name, _type, [0 if _type.startswith("int") else 0.0] * _size)
