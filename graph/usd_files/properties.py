"""The properties of one prim as written: values, types, sources and targets, without any check.

Every call into USD costs as much as ten lines of Python, and a large file has half a million properties, most of which
only repeat their node's type. So a property is read when it is needed, and only the needed part.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from graph.sim.scene.layer_text import BINARY, layer_bytes
from graph.sim.usd import EARLIEST, Sdf, Usd

from .values import from_usd, plain

_NOTHING: Mapping[str, Any] = {}


class RawAttribute:
    """A property that is read lazily, as long as its stage exists."""

    __slots__ = ("name",)
    name: str
    is_relationship = False

    @property
    def is_animated(self) -> bool:
        """Whether it has time samples, of which `value` is the first."""
        return False

    @property
    def sdf_type(self) -> str:
        """The Sdf type name; "rel" for a relationship."""
        raise NotImplementedError

    @property
    def value(self) -> Any:
        """Plain data, or None if no value is authored. For a relationship, the list of targets."""
        raise NotImplementedError

    @property
    def sources(self) -> tuple[str, ...]:
        """The property paths that feed an attribute, composed and absolute."""
        raise NotImplementedError

    @property
    def custom(self) -> Mapping[str, Any]:
        """Its customData as plain data."""
        raise NotImplementedError

    @property
    def is_execution(self) -> bool:
        """Whether the file itself marks it as execution; inputs of old files have no mark."""
        return bool(self.custom.get("isExecution"))

    @property
    def extended(self) -> Mapping[str, Any]:
        """The data on an extended attribute, see `extended_in`."""
        return extended_in(self.custom)


def extended_in(custom: Mapping[str, Any]) -> Mapping[str, Any]:
    """The data on an extended attribute in its customData: attrType, resolvedType, attrValue."""
    nested = custom.get("omni")
    inner = nested.get("graph") if isinstance(nested, dict) else None
    found = dict(inner) if isinstance(inner, dict) else {}
    for key in ("attrType", "resolvedType", "attrValue"):
        if f"omni:graph:{key}" in custom:
            found[key] = custom[f"omni:graph:{key}"]
    return found


class Properties:
    """The authored properties of one prim."""

    def names(self) -> Sequence[str]:
        """Their names, in order."""
        raise NotImplementedError

    def find(self, name: str) -> RawAttribute:
        """The property of that name, which must exist."""
        raise NotImplementedError

    def text(self, name: str) -> str:
        """The property's value as text, "" without a value; the property must exist."""
        return str(self.find(name).value or "")

    def custom(self, key: str) -> Any:
        """The prim's customData under a key, as plain data, or None."""
        raise NotImplementedError


_COMPOSING = (b"subLayers", b"references", b"payload", b"inherits", b"specializes", b"variant", b"relocates")
"""Words without which a text layer cannot compose other layers."""


_FED_OUTPUT = re.compile(rb"""outputs:[^\s.=<>()"']*\s*\.\s*connect|\brel\s+outputs:""")


class LoneLayer:
    """The only layer that wrote the prims of a stage, each at its own path, and facts from its text."""

    __slots__ = ("find_prim", "find_property", "outputs_unfed")

    def __init__(self, layer: Any, text: bytes) -> None:
        self.find_prim, self.find_property = layer.GetPrimAtPath, layer.GetPropertyAtPath
        self.outputs_unfed = _FED_OUTPUT.search(text) is None
        """Whether no output has a connection, and no output is a relationship."""


def lone_layer(stage: Any) -> LoneLayer | None:
    """The lone layer of a stage; None if that is not certain."""
    layers = [layer for layer in stage.GetUsedLayers() if not layer.anonymous or layer.rootPrims]
    if len(layers) != 1 or layers[0].dirty or not layers[0].realPath.endswith((".usd", ".usda")):
        return None
    data = layer_bytes(layers[0].realPath)
    composed = data.startswith(BINARY) or any(word in data for word in _COMPOSING)
    return None if composed else LoneLayer(layers[0], data)


def properties_of(prim: Any, path: Any, lone: LoneLayer | None = None) -> Properties:
    """The properties of a prim with path `path`: read from its layer if only one wrote it, else composed.

    lone: the stage's `lone_layer`, which avoids a query for each prim.
    """
    if lone is not None:
        return _Written(prim, path, lone.find_prim(path), lone.find_property, lone.outputs_unfed)
    stack = prim.GetPrimStack()
    if len(stack) == 1 and stack[0].path == path:
        return _Written(prim, path, stack[0], stack[0].layer.GetPropertyAtPath)
    return _Composed(prim)


class _Written(Properties):
    """The data of a prim that only one layer describes."""

    __slots__ = ("_find", "_path", "_prim", "_spec", "_unfed")

    def __init__(self, prim: Any, path: Any, spec: Any, find: Callable[[Any], Any], unfed: bool = False) -> None:
        self._prim, self._path, self._spec, self._find, self._unfed = prim, path, spec, find, unfed

    def names(self) -> Sequence[str]:
        names: Sequence[str] = self._spec.GetInfo("properties")  # twice as fast as `properties`
        return names

    def find(self, name: str) -> RawAttribute:
        return _UnfedOutput(name, self) if self._unfed and name.startswith("outputs:") else self.read(name)

    def read(self, name: str) -> RawAttribute:
        """The property of that name, looked up directly."""
        spec = self._find(self._path.AppendProperty(name))
        kind = _WrittenRelationship if type(spec) is Sdf.RelationshipSpec else _WrittenAttribute
        return kind(name, spec, self._prim)

    def text(self, name: str) -> str:
        value = self._find(self._path.AppendProperty(name)).default
        return value if isinstance(value, str) else super().text(name)

    def custom(self, key: str) -> Any:
        return plain(self._prim.GetCustomDataByKey(key)) if self._spec.HasInfo("customData") else None


class _WrittenAttribute(RawAttribute):
    __slots__ = ("_prim", "_spec")

    def __init__(self, name: str, spec: Any, prim: Any) -> None:
        self.name = name
        self._spec = spec
        self._prim = prim

    @property
    def is_animated(self) -> bool:
        return bool(self._spec.HasInfo("timeSamples"))

    @property
    def sdf_type(self) -> str:
        return str(self._spec.typeName)

    @property
    def value(self) -> Any:
        spec = self._spec
        value = spec.default
        if value is None and self.is_animated:
            value = self._prim.GetAttribute(self.name).Get(EARLIEST)
        return None if value is None else _plain(value, str(spec.typeName))

    @property
    def sources(self) -> tuple[str, ...]:
        spec = self._spec
        if not spec.HasInfo("connectionPaths"):
            return ()
        return tuple([path.pathString for path in spec.GetInfo("connectionPaths").GetAppliedItems()])

    @property
    def custom(self) -> Mapping[str, Any]:
        spec = self._spec
        return (plain(spec.GetInfo("customData")) or _NOTHING) if spec.HasInfo("customData") else _NOTHING


class _UnfedOutput(RawAttribute):
    """An output that is known to have no source, which is all that matters about most outputs."""

    __slots__ = ("_properties",)
    is_animated = False
    sources = ()

    def __init__(self, name: str, properties: _Written) -> None:
        self.name = name
        self._properties = properties

    @property
    def sdf_type(self) -> str:
        return self._properties.read(self.name).sdf_type

    @property
    def value(self) -> Any:
        return self._properties.read(self.name).value

    @property
    def custom(self) -> Mapping[str, Any]:
        return self._properties.read(self.name).custom


class _WrittenRelationship(_WrittenAttribute):
    __slots__ = ()
    is_relationship = True
    is_animated = False
    sdf_type = "rel"
    sources = ()

    @property
    def value(self) -> Any:
        spec = self._spec
        listed = spec.GetInfo("targetPaths").GetAppliedItems() if spec.HasInfo("targetPaths") else ()
        return [path.pathString for path in listed]


class _Composed(Properties):
    """The data of a prim that several layers or arcs describe."""

    __slots__ = ("_prim",)

    def __init__(self, prim: Any) -> None:
        self._prim = prim

    def names(self) -> Sequence[str]:
        names: Sequence[str] = self._prim.GetAuthoredPropertyNames()
        return names

    def find(self, name: str) -> RawAttribute:
        prop = self._prim.GetProperty(name)
        return (_ComposedRelationship if isinstance(prop, Usd.Relationship) else _ComposedAttribute)(name, prop)

    def custom(self, key: str) -> Any:
        return plain(self._prim.GetCustomDataByKey(key)) if self._prim.HasCustomData() else None


class _ComposedAttribute(RawAttribute):
    __slots__ = ("_property",)

    def __init__(self, name: str, prop: Any) -> None:
        self.name = name
        self._property = prop

    @property
    def is_animated(self) -> bool:
        return bool(self._property.GetNumTimeSamples())

    @property
    def sdf_type(self) -> str:
        return str(self._property.GetTypeName())

    @property
    def value(self) -> Any:
        value = self._property.Get(EARLIEST)
        return None if value is None else _plain(value, self.sdf_type)

    @property
    def sources(self) -> tuple[str, ...]:
        prop = self._property
        return tuple(map(str, prop.GetConnections())) if prop.HasAuthoredConnections() else ()

    @property
    def custom(self) -> Mapping[str, Any]:
        prop = self._property
        return (plain(prop.GetCustomData()) or _NOTHING) if prop.HasCustomData() else _NOTHING


class _ComposedRelationship(_ComposedAttribute):
    __slots__ = ()
    is_relationship = True
    is_animated = False
    sdf_type = "rel"
    sources = ()

    @property
    def value(self) -> Any:
        return [str(path) for path in self._property.GetTargets()]


def _plain(value: Any, sdf: str) -> Any:
    if type(value) is Sdf.ValueBlock:
        return None
    try:
        return from_usd(value, sdf)
    except (TypeError, ValueError, AttributeError, OverflowError):  # layers that disagree about the attribute's type
        return plain(value)
