"""A graph of a stage as its prims describe it, before names and types are resolved."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from graph.spec.file_spec import EvaluationMode, Evaluator, PipelineStage

from .node_prims import RawNode
from .properties import LoneLayer, RawAttribute


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
