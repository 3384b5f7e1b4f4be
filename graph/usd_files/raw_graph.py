"""A graph of a stage and its nodes as their prims describe them, before names and types are resolved."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graph.spec.file_spec import EvaluationMode, Evaluator, PipelineStage

from .properties import LoneLayer, RawAttribute, properties_of
from .values import ogn_name

PREFIXES = ("inputs:", "outputs:", "state:")
GRAPH_TYPES = ("OmniGraph", "ComputeGraph")
NODE_TYPES = ("OmniGraphNode", "ComputeNode")
COMPOUND_TYPE = "omni:graph:compoundType"
"""The attribute of a node that contains a graph; its value is the kind of compound."""
KEY = "tickgraph"
"""Key of our own data in customData and customLayerData."""
COMMENTS = "comments"
"""Key, in the layer's own data, of the comments that are not a prim's documentation, as JSON."""
_NOTHING: Mapping[str, Any] = {}

Tell = Callable[[str, str, str], None]
"""Takes a code, the path that it concerns, and a message."""


def schemas_of(prim: Any) -> Sequence[str]:
    """The API schemas applied to a prim, including those that USD does not know."""
    schemas: Sequence[str] = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    return schemas


def some(paths: Sequence[str], noun: str) -> str:
    """The number of prims, and the names of the first."""
    names = ", ".join(path.rpartition("/")[2] for path in paths[:3]) + (", ..." if len(paths) > 3 else "")
    return f"{len(paths)} {noun}{'' if len(paths) == 1 else 's'} ({names})"


class RawNode:
    """A node prim. `name` is its path from the graph's."""

    __slots__ = ("_properties", "attributes", "custom", "has_compound_type", "name", "path", "type")

    def __init__(self, prim: Any, path: Any, text: str, name: str, lone: LoneLayer | None = None) -> None:
        """Reads a prim with path `path`, as text `text`; `lone` is as in `properties_of`."""
        self._properties = properties = properties_of(prim, path, lone)
        names = properties.names()
        self.path = text
        self.name = name
        self.type = properties.text("node:type") if "node:type" in names else ""
        self.attributes = [properties.find(one) for one in names if one.startswith(PREFIXES)]
        self.has_compound_type = COMPOUND_TYPE in names
        """Whether `COMPOUND_TYPE` is among its attributes."""
        custom = properties.custom(KEY)
        self.custom: Mapping[str, Any] = custom if isinstance(custom, dict) else _NOTHING
        """Our own data on the prim."""

    @property
    def version(self) -> int | None:
        """The version of its type with which it was saved, if recorded."""
        properties = self._properties
        value = properties.find("node:typeVersion").value if "node:typeVersion" in properties.names() else None
        return value if isinstance(value, int) else None


def ogn_type(attribute: RawAttribute) -> str | None:
    """The OGN type of an attribute as the file declares it; None for tokens that may mean any type."""
    if attribute.is_execution:
        return "execution"
    if attribute.is_relationship:
        return "target"
    return ogn_name(attribute.sdf_type)


@dataclass(slots=True)
class RawGraph:
    """A graph prim with all nodes below it; nodes inside compounds are among `nodes`."""

    path: str
    stage: Any
    """The stage, kept alive because everything is read from it."""
    lone: LoneLayer | None = None
    """Its `lone_layer`."""
    evaluator: Evaluator = "push"
    pipeline_stage: PipelineStage = "simulation"
    variables: list[RawAttribute] = field(default_factory=list)
    nodes: list[RawNode] = field(default_factory=list)
    compounds: list[RawNode] = field(default_factory=list)
    custom: dict[str, Any] = field(default_factory=dict)
    """Our own customData on the prim."""
    evaluation_mode: EvaluationMode = "automatic"
    instances: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Prims that have the graph, each with its own variable values."""
    overs: list[str] = field(default_factory=list)
    """Paths of prims below it that only override nodes that no layer defines."""
