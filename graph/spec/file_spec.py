"""What a graph file says, as plain data: the result of loading, the input of compiling.

Every part keeps the `Mark` of its place, so that later stages can still name file, line and column.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

from graph.base.errors import Mark

Evaluator = Literal["execution", "push", "dirty_push"]
PipelineStage = Literal["simulation", "pre_render", "post_render", "on_demand"]
EvaluationMode = Literal["automatic", "standalone", "instanced"]
"""Runs once, once for each prim that has the graph, or (automatic) the second where any prim has it."""
Note = tuple[str, str, str]
"""A warning before there is an App to take it: its code, where, the message."""


@dataclass(frozen=True, slots=True)
class NodeSpec:
    """A node of a graph: its name, its type id as written, the inputs (and state) that the file sets.

    `attributes` are those the file adds to the node, full name to OGN type: `inputs:gain` to `double`. A node of a
    compound lies below it and is named by its path from the graph: `compound/Subgraph/add`.
    """

    name: str
    type: str
    inputs: Mapping[str, Any] = field(default_factory=dict)
    mark: Mark | None = None
    input_marks: Mapping[str, Mark] = field(default_factory=dict)
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConnectionSpec:
    """One source to one destination, as written: `tick.tick`, `tick.outputs:tick`, `/World/G/n.outputs:x`."""

    source: str
    target: str
    mark: Mark | None = None


@dataclass(frozen=True, slots=True)
class VariableSpec:
    """A graph variable: OGN type name and value (None: the type's zero)."""

    type: str
    value: Any = None
    mark: Mark | None = None


@dataclass(frozen=True, slots=True)
class GraphSpec:
    """One graph: its path, how and when it is evaluated, its variables, nodes and connections in file order.

    compounds: by the name of each compound, its ports (`inputs:x`, `outputs:y`) and the ends inside that each stands
    for (`compound/Subgraph/add.inputs:a`); the nodes inside are among `nodes`. unfinished: open inputs may be unset as
    long as nothing computes their node. saved: it comes from a saved scene (`lenient` in a graph file), where what a
    node lacks is a warning, its work is left out and the run goes on. instances: prims that have the graph, each with
    the variable values it gives.
    """

    path: str
    nodes: tuple[NodeSpec, ...] = ()
    connections: tuple[ConnectionSpec, ...] = ()
    evaluator: Evaluator = "execution"
    pipeline_stage: PipelineStage = "simulation"
    variables: Mapping[str, VariableSpec] = field(default_factory=dict)
    mark: Mark | None = None
    compounds: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    unfinished: bool = False
    saved: bool = False
    evaluation_mode: EvaluationMode = "automatic"
    instances: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SceneSpec:
    """Where the world comes from: a USD or MJCF file (absolute path) and prims authored inline, in order.

    keyframe: of the MJCF model, by name or number, the one to start in.
    """

    usd: Path | None = None
    mjcf: Path | None = None
    prims: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    mark: Mark | None = None
    prim_marks: Mapping[tuple[str, ...], Mark] = field(default_factory=dict)
    """Marks by (prim path,) and (prim path, key)."""
    keyframe: str | int | None = None


@dataclass(frozen=True, slots=True)
class ClockSpec:
    """Rates [Hz] that the file authors (None: the scene's, else 60) and the clock's behaviour."""

    physics_hz: Fraction | None = None
    loop_hz: Fraction | None = None
    experience: Literal["base", "full", "zero_delay"] = "base"
    parity: Literal["documented", "isaacsim-6.0.1"] = "documented"
    mark: Mark | None = None


@dataclass(frozen=True, slots=True)
class FileSpec:
    """A whole graph file. `folder` is the root below which every file it names must lie."""

    path: Path | None = None
    folder: Path | None = None
    scene: SceneSpec = field(default_factory=SceneSpec)
    clock: ClockSpec = field(default_factory=ClockSpec)
    duration: Fraction | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    fidelity: Mapping[str, Any] = field(default_factory=dict)
    graphs: tuple[GraphSpec, ...] = ()
    record_mcap: str = "run.mcap"
    marks: Mapping[tuple[str, ...], Mark] = field(default_factory=dict)
    """Marks by key path, e.g. ("settings", "/a/b") or ("fidelity", "lidar.motion")."""
    notes: tuple[Note, ...] = ()
    """Warnings that do not stop loading."""

    @property
    def lenient(self) -> bool:
        """Whether what cannot be compiled is left out with a note, as it is of scenes that people saved."""
        return any(graph.saved for graph in self.graphs)
