"""A graph of a stage as its prims say it, before names and types are settled."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from graph.spec.file_spec import EvaluationMode, Evaluator, PipelineStage

from .node_prims import RawNode
from .properties import LoneLayer, RawAttribute


@dataclass(slots=True)
class RawGraph:
    """A graph prim with everything below it that is a node; nodes inside compounds are among `nodes`."""

    path: str
    stage: Any
    """The stage, without which nothing of it could be read."""
    lone: LoneLayer | None = None
    """Its `lone_layer`."""
    evaluator: Evaluator = "push"
    pipeline_stage: PipelineStage = "simulation"
    variables: list[RawAttribute] = field(default_factory=list)
    nodes: list[RawNode] = field(default_factory=list)
    compounds: list[RawNode] = field(default_factory=list)
    custom: dict[str, Any] = field(default_factory=dict)
    """Our own customData of the prim."""
    evaluation_mode: EvaluationMode = "automatic"
    instances: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Prims that have the graph, each with the variable values it gives."""
    overs: list[str] = field(default_factory=list)
    """Paths of prims below it that only override nodes which nothing defines."""
