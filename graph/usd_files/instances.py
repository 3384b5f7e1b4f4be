"""Which prims of a stage have which graphs: the relationship `omniGraphs` of OmniGraphAPI."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.shorten import listed

from .json_values import decoded
from .raw_graph import Tell, schemas_of, some
from .variables import variable_name, variables_of

if TYPE_CHECKING:
    from .raw_graph import RawGraph

GRAPHS = "omniGraphs"
_API = "OmniGraphAPI"


class Users:
    """Collects the prims that have graphs."""

    def __init__(self) -> None:
        self.of: dict[str, dict[str, dict[str, Any]]] = {}
        """By graph path, the prims that have the graph, each with its own variable values."""
        self._bare: list[str] = []
        """Prims without the API schema that gives the relationship its meaning."""

    def add(self, prim: Any) -> None:
        """Adds a prim that has the relationship."""
        targets, path = prim.GetRelationship(GRAPHS).GetTargets(), str(prim.GetPath())
        if targets and _API not in schemas_of(prim):
            self._bare.append(path)
        for target in targets:
            self.of.setdefault(str(target), {})[path] = variables_of(prim)

    def give(self, graphs: Iterable[RawGraph], tell: Tell) -> None:
        """Gives each graph its prims, with the values that concern it; reports prims and values without a meaning."""
        given: dict[str, set[str]] = {}
        for graph in graphs:
            users = self.of.pop(graph.path, {})
            noted = decoded(graph.custom, "instances")
            if isinstance(noted, dict) and noted.keys() == users.keys():
                graph.instances = noted  # in the order, and with the values, that our own writer recorded
            else:
                names = {variable_name(one) for one in graph.variables}
                graph.instances = {path: _only(names, values) for path, values in users.items()}
                if graph.evaluation_mode == "instanced" and not users and not graph.custom:
                    message = f"{graph.path} runs for the prims that have it (evaluationMode Instanced), and none has"
                    tell("usd-no-instances", graph.path, message)
            for path, values in users.items():
                given.setdefault(path, set(values)).difference_update(graph.instances.get(path, {}))
        self._tell(given, tell)

    def _tell(self, unused: Mapping[str, Collection[str]], tell: Tell) -> None:
        for path, names in unused.items():
            if names:
                message = f"{path} gives values to {listed(sorted(names))}, which no graph of it has; they are left out"
                tell("usd-instance-variable", path, message)
        for graph, users in self.of.items():
            message = f"{graph}, named in omniGraphs of {some(list(users), 'prim')}, is not a graph that runs"
            tell("usd-instance-lost", next(iter(users)), message)
        if self._bare:
            message = f"omniGraphs of {some(self._bare, 'prim')} counts, though the API schema {_API} is not applied"
            tell("usd-instance-schema", self._bare[0], message)


def _only(names: Collection[str], values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name in names}


def instances_on(stage: Any) -> dict[str, dict[str, dict[str, Any]]]:
    """By graph path, the prims that have the graph, in stage order, each with its own variable values."""
    users = Users()
    for prim in stage.Traverse():
        if prim.HasRelationship(GRAPHS):
            users.add(prim)
    return users.of
