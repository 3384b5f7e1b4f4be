"""Resolves the names in one edit: nodes, compounds and attributes, in the edited graph and in others."""

from __future__ import annotations

from typing import Any

from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError
from graph.editing.graph_set import GraphSet
from graph.editing.model import PREFIXES, Model, Side
from graph.spec.migration import changed_attribute

from .names import end_text, node_text


class ToldError(Exception):
    """The problem has already been reported for another entry."""


class EditNames:
    """Finds the objects that the entries of an edit name. `scope` is the prefix of the names inside a compound."""

    def __init__(self, graphs: GraphSet, main: Model) -> None:
        """main: the model of the graph to edit."""
        self.main = main
        self.models = {main.path: main}
        """Models of the graphs that the edit concerns, by path."""
        self.short: dict[str, str] = {}
        """Name in the edited graph by short name, of new nodes."""
        self.broken: set[str] = set()
        """Names of new nodes that could not be made."""
        self.notes: dict[tuple[str, str, str], None] = {}
        """Warnings about old attributes: code, node, sentence."""
        self._graphs = graphs

    def model(self, path: str) -> Model:
        """The model of a graph, made at first use."""
        if path not in self.models:
            self.models[path] = self._graphs.model(path)
        return self.models[path]

    def new_name(self, written: Any, scope: str) -> str:
        """The name that a new node gets. Raises OmniGraphError for a path outside the edited graph."""
        text = node_text(written)
        if text.startswith("/"):
            if not text.startswith(f"{self.main.path}/"):
                raise OmniGraphError(f"node {text} does not lie below the graph {self.main.path}; give a name instead")
            return text[len(self.main.path) + 1 :]
        return scope + text

    def known_name(self, written: str, scope: str) -> tuple[Model, str]:
        """The model and the name of a node or compound. Raises OmniGraphError with the nearest name."""
        main = self.main
        if written.startswith("/"):
            for model in (main, *self.models.values()):
                name = model.local_name(written)
                if name in model.nodes or name in model.compounds:
                    return model, name
            path = written
            if path.rpartition("/")[2].count("."):
                path = path[::-1].replace(".", "/", 1)[::-1]
            owner = self._graphs.owner_of(path)
            if owner is not None and owner.path not in self.models:
                model = self.model(owner.path)
                name = model.local_name(path)
                if name in model.nodes or name in model.compounds:
                    return model, name
            raise OmniGraphError(f'"{written}" is not a legal node; no node has that path')
        for name in (scope + written, self.short.get(written, ""), written):
            if name in main.nodes or name in main.compounds:
                return main, name
            if name in self.broken:
                raise ToldError
        near = did_you_mean(written, (*self.short, *main.nodes))
        raise OmniGraphError(f'"{written}" is not a legal node; graph {main.path} does not contain it{near}')

    def ends(self, spec: Any, scope: str, side: Side) -> list[tuple[Model, str, str]]:
        """The model, node and full attribute of an end; several for an input of a compound."""
        owner, _, attribute = end_text(spec).rpartition(".")
        model, name = self.known_name(owner, scope)
        if name not in model.compounds:
            return [(model, name, model.full_attribute(name, attribute, side))]
        ports = model.compounds[name]
        prefixed = (
            [attribute] if attribute.partition(":")[0] in PREFIXES else [f"inputs:{attribute}", f"outputs:{attribute}"]
        )
        full = next((one for one in prefixed if one in ports), None)
        if full is None:
            near = did_you_mean(attribute, ports)
            raise OmniGraphError(
                f'"{owner}.{attribute}" is not a legal attribute; the compound has no such port{near}; make one with '
                "PROMOTE_ATTRIBUTES"
            )
        inside = [end.rpartition(".") for end in ports[full]]
        return [(model, node, inner) for node, _, inner in inside]

    def present_ends(self, spec: Any, scope: str, side: Side) -> list[tuple[Model, str, str]]:
        """As `ends`, with old attributes under their present names; removed ones are left out.

        An attribute that the script made itself is never an old one.
        """
        found = []
        default = "outputs" if side == "source" else "inputs"
        for model, name, full in self.ends(spec, scope, side):
            node = model.nodes.get(name)
            long = full if full.partition(":")[0] in PREFIXES else f"{default}:{full}"
            change = None
            if node is not None and long not in node.attributes:
                change = changed_attribute(node.type, long, self._graphs.registry)
            if change is None:
                found.append((model, name, full))
                continue
            new, code, sentence = change
            self.notes[code, f"{model.path}/{name}", sentence] = None
            if new:
                found.append((model, name, new))
        return found
