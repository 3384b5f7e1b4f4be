"""Lets prims of USD take API schemas that USD does not know, by their classes."""

from __future__ import annotations

from functools import cache, wraps
from typing import Any

from graph.sim.usd import Tf, Usd


class OwnSchema:
    """An API schema whose classes `prim.HasAPI` and its siblings take once `take_own_schemas` was called."""

    name = ""


def take_own_schemas() -> None:
    """Lets `prim.HasAPI`, `ApplyAPI`, `RemoveAPI` and `CanApplyAPI` of USD take subclasses of OwnSchema."""
    for name in ("HasAPI", "ApplyAPI", "RemoveAPI", "CanApplyAPI"):
        usual = getattr(Usd.Prim, name)
        if not hasattr(usual, "__wrapped__"):
            setattr(Usd.Prim, name, _taking(name, usual))


def _taking(name: str, usual: Any) -> Any:
    @wraps(usual)
    def call(self: Any, schema: Any, *instance: Any, **named: Any) -> Any:
        own = isinstance(schema, type) and issubclass(schema, OwnSchema)
        if not own and not (isinstance(schema, str) and schema not in _known()):
            return usual(self, schema, *instance, **named)
        schema_name = schema.name if own else schema
        part = str(named.get("instanceName") or (instance[0] if instance else ""))
        full = f"{schema_name}:{part}" if part else schema_name
        if name == "HasAPI":
            return any(one == full or (not part and one.startswith(f"{full}:")) for one in applied(self))
        if name == "CanApplyAPI":
            return bool(self)
        return (self.AddAppliedSchema if name == "ApplyAPI" else self.RemoveAppliedSchema)(full)

    return call


@cache
def _known() -> frozenset[str]:
    """The API schemas that USD itself has."""
    registry = Usd.SchemaRegistry
    found = Tf.Type.Find(Usd.APISchemaBase).GetAllDerivedTypes()
    return frozenset(str(registry.GetSchemaTypeName(one)) for one in found)


def applied(prim: Any) -> list[str]:
    """The API schemas of a prim, those that USD does not know too."""
    return [str(one) for one in prim.GetPrimTypeInfo().GetAppliedAPISchemas()] if prim else []
