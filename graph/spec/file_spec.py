"""A graph file's content as plain data: the result of loading and the input of compiling.

Every part keeps the `Mark` of its place, so that later stages can report file, line and column.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

from graph.base.errors import Mark
from graph.base.records import dataclass, field

Evaluator = Literal["execution", "push", "dirty_push"]
PipelineStage = Literal["simulation", "pre_render", "post_render", "on_demand"]
EvaluationMode = Literal["automatic", "standalone", "instanced"]
"""Whether a graph runs once, once for each prim that has it, or (automatic) once for each prim if any prim has it."""
Note = tuple[str, str, str]
"""A warning from before the App exists: code, place, message."""


@dataclass(frozen=True, slots=True)
class NodeSpec:
    """A node of a graph: its name, its type id as written, the inputs (and state) that the file sets.

    `attributes` are those that the file adds to the node, full name to OGN type: `inputs:gain` to `double`. A node
    inside a compound is named by its path from the graph: `compound/Subgraph/add`.
    """

    name: str
    type: str
    inputs: Mapping[str, Any] = field(default_factory=dict)
    mark: Mark | None = None
    input_marks: Mapping[str, Mark] = field(default_factory=dict)
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConnectionSpec:
    """A connection from one source to one destination, as written:

    `tick.tick`, `tick.outputs:tick`, `/World/G/n.outputs:x`.
    """

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

    compounds: for each compound, its ports (`inputs:x`, `outputs:y`) and the inner attributes that each port stands for
    (`compound/Subgraph/add.inputs:a`); the inner nodes are among `nodes`. unfinished: open inputs may be unset as long
    as nothing computes their node. saved: the graph comes from a saved scene (`lenient` in a graph file): if something
    that a node needs is missing, the run warns, leaves out the node's work and goes on. partial: so it does because
    nodes of unknown types were left out. instances: prims that have the graph, each with its own variable values.
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
    partial: bool = False

    @property
    def excuses_lacks(self) -> bool:
        """Whether something missing in the file is only a warning."""
        return self.saved or self.partial


@dataclass(frozen=True, slots=True)
class SceneSpec:
    """Where the world comes from: a USD or MJCF file (absolute path), and prims in the graph file, in order.

    keyframe: the initial keyframe of the MJCF model, by name or number.
    """

    usd: Path | None = None
    mjcf: Path | None = None
    prims: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    mark: Mark | None = None
    prim_marks: Mapping[tuple[str, ...], Mark] = field(default_factory=dict)
    """Marks by (prim path,) and (prim path, key)."""
    keyframe: str | int | None = None
    is_urdf: bool = False
    """Whether the model is a URDF."""
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Keys that the caller sets on prims of the scene's own files, by path; as those of inline prims."""
    copies: Mapping[str, str] = field(default_factory=dict)
    """Copies of prims of the scene's own files: path of the copy to that of the prim, or to itself; "" removes it."""


@dataclass(frozen=True, slots=True)
class ClockSpec:
    """Rates [Hz] that the file sets (None: the scene's rate, else 60), and how the clock behaves."""

    physics_hz: Fraction | None = None
    loop_hz: Fraction | None = None
    experience: Literal["base", "full", "zero_delay"] = "base"
    parity: Literal["documented", "isaacsim-6.0.1"] = "documented"
    mark: Mark | None = None


@dataclass(frozen=True, slots=True)
class RecordSpec:
    """What a run records: the file's name, when a part ends (bytes, seconds; None: never), patterns of topics."""

    mcap: str = "run.mcap"
    split_size: int | None = None
    split_seconds: Fraction | None = None
    topics: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FileSpec:
    """A whole graph file. Every file that it names must lie below `folder`."""

    path: Path | None = None
    folder: Path | None = None
    scene: SceneSpec = field(default_factory=SceneSpec)
    clock: ClockSpec = field(default_factory=ClockSpec)
    duration: Fraction | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    fidelity: Mapping[str, Any] = field(default_factory=dict)
    randomize: Mapping[str, str] = field(default_factory=dict)
    """Distributions as text, by what each seed draws: /PRIM/PATH.ATTR, /PRIM/PATH.copies or NODE.ATTR."""
    graphs: tuple[GraphSpec, ...] = ()
    record: RecordSpec = field(default_factory=RecordSpec)
    marks: Mapping[tuple[str, ...], Mark] = field(default_factory=dict)
    """Marks by key path, e.g. ("settings", "/a/b") or ("fidelity", "lidar.motion")."""
    notes: tuple[Note, ...] = ()
    """Warnings that do not stop loading."""

    @property
    def lenient(self) -> bool:
        """Whether what cannot be compiled is left out with a warning, as in saved scenes."""
        return any(graph.saved for graph in self.graphs)
