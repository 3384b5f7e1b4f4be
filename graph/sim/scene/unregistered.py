"""Physics attributes and schemas that no USD schema here defines (of PhysX, Newton, MuJoCo) that files may write."""

from __future__ import annotations

from typing import Any

from .physics_settings import (
    ARRAYS,
    INSTANCED,
    NAMESPACES,
    RELATIONSHIPS,
    SCHEMAS,
    SIMULATED,
    TOKENS,
    VECTORS,
    generic,
)
from .stored_settings import QUIET_SCHEMAS, STORED, UNKNOWN, stored_as

_APPLIED = ("Scene", "RigidBody", "Collision", "Material", "Joint", "JointAxis", "Limit", "MimicJoint", "Force")
_APPLIED_WITH = frozenset(f"physx{name}" for name in (*_APPLIED, "SurfaceVelocity", "Articulation"))
"""Namespaces whose schema is `Physx...API`, which their attributes bring along."""

_WHOLE = ("Axis", "Count", "PerSecond", "terations")
"""Ends of the names of whole numbers."""


def schema_of(name: str) -> str:
    """The API schema, with its instance, that an attribute brings along; "" for none."""
    namespace, instance = name.partition(":")[0], generic(name)[1]
    if namespace not in _APPLIED_WITH:
        return ""
    return f"P{namespace[1:]}API" + (f":{instance}" if instance else "")


def takes_instance(schema: str) -> bool | None:
    """Whether an API schema that physics knows is applied with an instance; None if physics does not know it."""
    known = schema in QUIET_SCHEMAS or (schema.startswith(SCHEMAS) and stored_as(schema) is not UNKNOWN)
    if not known or not schema.endswith("API"):
        return None
    return f"p{schema[1:]}".removesuffix("API") in INSTANCED


def value_type(name: str, value: Any) -> str:
    """The USD type that an attribute gets for a value, "rel" for a relationship; "" if physics does not know it."""
    known, instance = generic(name)
    if not name.startswith(NAMESPACES) or ("*" in known and not instance):
        return ""
    if known not in SIMULATED and (stored_as(known) is UNKNOWN or stored_as(known) is _OTHER_MUJOCO):
        return ""
    if known in RELATIONSHIPS:
        return "rel"
    if known in VECTORS:
        return "vector3f"
    if known in ARRAYS:
        return "point3f[]" if known.endswith("Points") else "int[]"
    if known in TOKENS:
        return "token"
    if known in SIMULATED or isinstance(value, (bool, int, float)):
        whole = isinstance(value, int) and known.endswith(_WHOLE)
        return "bool" if isinstance(value, bool) else "int" if whole else "float"
    if isinstance(value, str):
        return "rel" if value.startswith("/") else "token"
    return "float[]"


def names() -> list[str]:
    """All names with an effect, to suggest one."""
    return [name for name in SIMULATED if "*" not in name]


_OTHER_MUJOCO = next(row for row in STORED if "mjc:*" in row.names)
