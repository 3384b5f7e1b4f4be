"""`Attribute` and `AttributeData`: an attribute of a node, and its value."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from graph.editing.graph_set import GraphSet
from graph.evaluate.omnigraph_names import AttributeOf
from graph.isaac.og import Compound, OmniGraphError
from graph.isaac.outcomes import tell_inert
from graph.isaac.watched import watch
from graph.values.types import TYPES, Extended

from .editing import connections, plain, set_value
from .enums import (
    ACCORDING_TO_CONTEXT_GRAPH_INDEX,
    AUTHORING_GRAPH_INDEX,
    AttributePortType,
    ExtendedAttributeType,
)
from .handle import Handle
from .types import Type, type_of

if TYPE_CHECKING:
    from .handles import Node

_PORTS = {"inputs": AttributePortType.INPUT, "outputs": AttributePortType.OUTPUT, "state": AttributePortType.STATE}
_METADATA: WeakKeyDictionary[GraphSet, dict[str, dict[str, str]]] = WeakKeyDictionary()
"""What scripts have set on attributes, by the attribute's path."""


class Attribute(Handle):
    """An attribute of a node."""

    def __init__(self, node: Node, name: str) -> None:
        super().__init__(node._graphs, f"{node.path}.{name}")
        self._node, self.full_name = node, name
        self.is_optional_for_compute = False
        if name.startswith("outputs:"):
            with suppress(OmniGraphError):
                ours = node.ours
                if not isinstance(ours, Compound):
                    ours.graph.asked.add((ours.name, name))

    @property
    def ours(self) -> AttributeOf:
        """The attribute itself. Raises OmniGraphError if it is gone."""
        found = attribute_or_none(self._node.ours, self.full_name)
        if found is None:
            raise OmniGraphError(f"{self.path} is gone")
        return found

    def is_valid(self) -> bool:
        with suppress(OmniGraphError):
            return attribute_or_none(self._node.ours, self.full_name) is not None
        return False

    def get(self, on_gpu: bool = False, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> Any:
        if on_gpu:
            tell_inert("omni.graph.core: on_gpu", "values are in the memory of the CPU; the argument changes nothing")
        found = self._of_instance(instance)
        return self._edit.get(self.path) if found is None else found.get()

    def _of_instance(self, instance: int) -> AttributeOf | None:
        """The attribute in the instance with that number; None for the graph itself."""
        if instance in (ACCORDING_TO_CONTEXT_GRAPH_INDEX, AUTHORING_GRAPH_INDEX):
            return None
        held = list(self._node.ours.graph.instances.values())
        if instance == 0 and not held:
            return None
        if not 0 <= instance < len(held):
            raise OmniGraphError(f"{self.path}: there is no instance {instance}; the graph has {len(held)}")
        return AttributeOf(held[instance].nodes[self._node.ours.name], self.full_name)

    def get_array(
        self, on_gpu: bool = False, get_for_write: bool = False, reserved_element_count: int = 0, *_: Any
    ) -> Any:
        return self.get(on_gpu, *_[:1])

    def set(self, value: Any, on_gpu: bool = False, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> bool:
        if on_gpu:
            tell_inert("omni.graph.core: on_gpu", "values are in the memory of the CPU; the argument changes nothing")
        if (found := self._of_instance(instance)) is not None:
            try:
                found.set(plain(value))
            except ValueError as error:
                raise OmniGraphError(str(error)) from None
            return True
        return set_value(self._graphs, self.ours, value)

    def set_default(self, value: Any, on_gpu: bool = False) -> bool:
        return self.set(value, on_gpu)

    def get_name(self) -> str:
        return self.full_name

    def get_path(self) -> str:
        return self.path

    def get_node(self) -> Node:
        return self._node

    def get_port_type(self) -> AttributePortType:
        return _PORTS.get(self.full_name.partition(":")[0], AttributePortType.UNKNOWN)

    def get_resolved_type(self) -> Type:
        return type_of(TYPES.get(self.ours.get_type_name()))

    def set_resolved_type(self, resolved_type: Type) -> None:
        """Connections and values resolve types here; asking for another type does nothing."""
        if resolved_type != self.get_resolved_type():
            tell_inert("omni.graph.core.Attribute.set_resolved_type")

    def get_type_name(self) -> str:
        return self.ours.get_type_name()

    def get_extended_type(self) -> ExtendedAttributeType:
        declared = self._declared()
        if not isinstance(declared, Extended):
            return ExtendedAttributeType.REGULAR
        return ExtendedAttributeType.UNION if declared.members else ExtendedAttributeType.ANY

    def get_union_types(self) -> list[str] | None:
        declared = self._declared()
        return [str(one) for one in declared.members] if isinstance(declared, Extended) and declared.members else None

    def _declared(self) -> Any:
        ours = self.ours
        try:
            return ours.node.attribute(ours.full_name).parsed
        except KeyError:
            return Extended("any")

    def is_array(self) -> bool:
        return self.get_resolved_type().array_depth > 0

    def is_dynamic(self) -> bool:
        ours = self.ours
        return ours.full_name in ours.node.added

    def is_deprecated(self) -> bool:
        return bool(self.deprecation_message())

    def deprecation_message(self) -> str:
        ours = self.ours
        with suppress(KeyError):
            return str(ours.node.attribute(ours.full_name).deprecated)
        return ""

    def get_metadata(self, key: str) -> str | None:
        return self.get_all_metadata().get(key)

    def get_all_metadata(self) -> dict[str, str]:
        ours = self.ours
        stored = _METADATA.get(self._graphs, {}).get(self.path, {})
        with suppress(KeyError):
            return {"__description": ours.node.attribute(ours.full_name).doc, **stored}
        return dict(stored)

    def set_metadata(self, key: str, value: str) -> bool:
        _METADATA.setdefault(self._graphs, {}).setdefault(self.path, {})[str(key)] = str(value)
        return True

    def connect(self, path: Any, modify_usd: bool = True) -> bool:
        self._edit.connect(self.path, getattr(path, "path", path))
        return True

    def disconnect(self, attribute: Any, modify_usd: bool = True) -> bool:
        self._edit.disconnect(self.path, getattr(attribute, "path", attribute))
        return True

    def get_upstream_connections(self) -> list[Attribute]:
        return [self._at(source) for source, target in self._connections() if target == self.path]

    def get_downstream_connections(self) -> list[Attribute]:
        return [self._at(target) for source, target in self._connections() if source == self.path]

    def get_upstream_connection_count(self) -> int:
        return len(self.get_upstream_connections())

    def get_downstream_connection_count(self) -> int:
        return len(self.get_downstream_connections())

    def is_connected(self, attribute: Any = None) -> bool:
        ends = [one.path for one in (*self.get_upstream_connections(), *self.get_downstream_connections())]
        return bool(ends) if attribute is None else getattr(attribute, "path", str(attribute)) in ends

    def _connections(self) -> list[tuple[str, str]]:
        return connections(self._graphs, self._node.ours.graph.path)

    def _at(self, path: str) -> Attribute:
        owner, _, name = path.rpartition(".")
        return Attribute(type(self._node)(self._graphs, owner), name)

    def is_compatible(self, attribute: Attribute) -> bool:
        from graph.values.conversion import converter

        mine, other = TYPES.get(self.get_type_name()), TYPES.get(attribute.get_type_name())
        return mine is None or other is None or mine is other or converter(mine, other) is not None

    def register_value_changed_callback(self, func: Callable[[Any], None] | None) -> None:
        watch(self._graphs, self.path, None if func is None else partial(func, self))

    def get_attribute_data(self, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> AttributeData:
        return AttributeData(self, instance)

    @staticmethod
    def get_port_type_from_name(name: str) -> AttributePortType:
        return _PORTS.get(name.partition(":")[0], AttributePortType.UNKNOWN)

    @staticmethod
    def ensure_port_type_in_name(name: str, port_type: Any, is_bundle: bool = False) -> str:
        prefix = next(one for one, port in _PORTS.items() if port == port_type)
        return name if name.startswith(f"{prefix}:") else f"{prefix}:{name}"

    @staticmethod
    def remove_port_type_from_name(name: str, is_bundle: bool = False) -> str:
        return name.partition(":")[2] if name.partition(":")[0] in _PORTS else name


class AttributeData:
    """The value of an attribute."""

    def __init__(self, attribute: Attribute, instance: int) -> None:
        self._attribute, self._instance = attribute, instance

    def get(self, on_gpu: bool = False, *_: Any, **__: Any) -> Any:
        return self._attribute.get(on_gpu, self._instance)

    def set(self, value: Any, on_gpu: bool = False, *_: Any, **__: Any) -> bool:
        return self._attribute.set(value, on_gpu, self._instance)

    def get_type(self) -> Type:
        return self._attribute.get_resolved_type()

    get_resolved_type = get_type

    def size(self) -> int:
        value = self.get()
        return len(value) if hasattr(value, "__len__") else 1

    def is_valid(self) -> bool:
        return self._attribute.is_valid()

    def is_read_only(self) -> bool:
        return self._attribute.full_name.startswith("outputs:")

    def cpu_valid(self) -> bool:
        return True

    def gpu_valid(self) -> bool:
        return False


def attribute_or_none(ours: Any, name: str) -> AttributeOf | None:
    try:
        found: AttributeOf = ours.get_attribute(name)
    except (KeyError, OmniGraphError):
        return None
    return found
