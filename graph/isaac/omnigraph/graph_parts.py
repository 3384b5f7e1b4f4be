"""`IVariable` and `GraphContext`: the variables of a graph, and its time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.evaluate.omnigraph_names import Variable as OurVariable

from .editing import kind_name, remove_variable
from .enums import eVariableScope
from .types import Type, type_of

if TYPE_CHECKING:
    from .handles import Graph


class IVariable:
    """A variable of a graph."""

    def __init__(self, graph: Graph, name: str) -> None:
        self._graph, self.name = graph, name
        self.category = self.display_name = self.tooltip = ""
        self.scope = eVariableScope.E_PRIVATE

    def __eq__(self, other: object) -> bool:
        return isinstance(other, IVariable) and (self._graph, self.name) == (other._graph, other.name)

    def __hash__(self) -> int:
        return hash(self.source_path)

    def __repr__(self) -> str:
        return f"<omni.graph.core.IVariable {self.source_path}>"

    @property
    def source_path(self) -> str:
        return f"{self._graph.path}.graph:variable:{self.name}"

    @property
    def valid(self) -> bool:
        return self._graph.is_valid() and self.name in self._graph.ours.variables

    def is_valid(self) -> bool:
        return self.valid

    def __bool__(self) -> bool:
        return self.valid

    @property
    def type(self) -> Type:
        return type_of(self._graph.ours.variables.types[self.name])

    @property
    def ours(self) -> OurVariable:
        return OurVariable(self._graph.ours, self.name)

    def get(self, graph_context: Any = None, instance_path: str | None = None) -> Any:
        return self.ours.get(instance_path)

    def get_array(self, graph_context: Any = None, *_: Any, instance_path: str | None = None) -> Any:
        return self.ours.get(instance_path)

    def set(self, graph_context: Any, value: Any, instance_path: str | None = None) -> bool:
        self.ours.set(value, instance_path)
        return True

    def set_type(self, variable_type: Any) -> bool:
        """Gives it another type and that type's zero; False if a node uses it."""
        if kind_name(variable_type) == str(self._graph.ours.variables.types[self.name]):
            return True
        if not remove_variable(self._graph._graphs, self._graph.path, self.name):
            return False
        self._graph._edit.create_variable(self._graph.ours, self.name, kind_name(variable_type))
        return True


class GraphContext:
    """The time of a graph."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def get_graph(self) -> Graph:
        return self._graph

    def get_graph_target(self, index: int = 0) -> str:
        return self._graph.path

    def get_time(self) -> float:
        return float(self._graph._graphs.context.time)

    def get_time_since_start(self) -> float:
        return float(self._graph._graphs.context.since_start)

    def get_elapsed_time(self) -> float:
        return float(self._graph._graphs.context.delta)

    def get_frame(self) -> float:
        return float(self._graph._graphs.context.update)

    def get_is_playing(self) -> bool:
        return bool(self._graph._graphs.context.is_playing)

    def is_valid(self) -> bool:
        return self._graph.is_valid()
