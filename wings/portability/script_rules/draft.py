"""The graph file that a script amounts to, as far as its syntax tree tells: its sensor prims, graphs, settings, rates.

The rules on files look at it as at any file; what only a run knows is left out.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark
from graph.base.records import dataclass, field
from graph.isaac.syntax import Script
from graph.sim import settings as keys
from graph.spec.file_spec import ClockSpec, ConnectionSpec, FileSpec, GraphSpec, NodeSpec, PipelineStage, SceneSpec
from wings.portability.case import Asked

from .authored import CAMERA, UNKNOWN, authored_by
from .edits import edits_of
from .reading import all_settings, app_configs, argument

if TYPE_CHECKING:
    from pxr import Usd

WORLDS = ("World", "SimulationContext")
STAGES: Mapping[str, PipelineStage] = {"ONDEMAND": "on_demand", "PRERENDER": "pre_render", "POSTRENDER": "post_render"}
MOST_HZ = 1_000_000


@dataclass(slots=True)
class Draft:
    """The file, and values: those of each prim's attributes.

    Only a run knows all attributes of the uncertain prims, the values of the unknown attributes, and the prims on which
    attributes of the names `elsewhere` are set; and the pipeline stage of the graphs of the unstaged nodes.
    """

    spec: FileSpec
    values: dict[str, dict[str, Any]] = field(default_factory=dict)
    uncertain: set[str] = field(default_factory=set)
    unknown: set[tuple[str, str]] = field(default_factory=set)
    elsewhere: set[str] = field(default_factory=set)
    unstaged: set[str] = field(default_factory=set)
    asked: list[Asked] = field(default_factory=list)

    def decides(self, code: str, subject: str, detail: str) -> bool:
        """Whether a finding, by its subject and what it says, hangs on nothing that only a run knows."""
        if code == "physics-step-stage" and subject in self.unstaged:
            return False
        path, _, name = subject.partition(".")
        open_names = {name for of, name in self.unknown if of == path} | self.elsewhere
        last_words = {one.rpartition(":")[2] for one in open_names}
        return path not in self.uncertain and name not in open_names and not last_words & {*re.findall(r"\w+", detail)}


def author_rest(stage: Usd.Stage, values: Mapping[str, Mapping[str, Any]]) -> None:
    """Writes the values that no schema of their prims declares, as `CreateAttribute` does; graph files refuse them."""
    from graph.sim.usd import Sdf

    types = Sdf.ValueTypeNames
    kinds = {bool: types.Bool, int: types.Int, float: types.Double, str: types.String}
    for path, given in values.items():
        prim = stage.GetPrimAtPath(path)
        for name, value in given.items() if prim else ():
            if type(value) in kinds and Sdf.Path.IsValidNamespacedIdentifier(name) and not prim.HasAttribute(name):
                prim.CreateAttribute(name, kinds[type(value)]).Set(value)


def draft(script: Script) -> Draft:
    """The file that the script amounts to."""
    authored = authored_by(script)
    found = Draft(FileSpec(), elsewhere=authored.elsewhere)
    prims: dict[str, dict[str, Any]] = {}
    marks: dict[tuple[str, ...], Mark] = {}
    for path, prim in authored.prims.items():
        known = {name: value for name, value in prim.values.items() if value is not UNKNOWN}
        found.values[path] = known
        prims[path] = {"type": prim.type, **prim.options}
        if prim.type != CAMERA or "schemas" in prim.options:  # else attributes would bring the schema that is missing
            prims[path]["attributes"] = known
        marks[path,] = script.mark(prim.place)
        marks |= {(path, name): script.mark(place) for name, place in prim.places.items()}
        found.unknown |= {(path, name) for name in prim.values if name not in known}
        found.uncertain |= {path} if prim.uncertain else set()
        found.asked += [Asked(path, names, script.mark(place)) for place, names in prim.asked]
    written, where = _settings(script)
    found.spec = FileSpec(
        scene=SceneSpec(prims=prims, prim_marks=marks),
        clock=_clock(script),
        settings=written,
        graphs=tuple(_graphs(script, found)),
        marks=where,
    )
    return found


def _settings(script: Script) -> tuple[dict[str, Any], dict[tuple[str, ...], Mark]]:
    """The settings that the script writes or gives to the app, and their places."""
    values: dict[str, Any] = {}
    marks: dict[tuple[str, ...], Mark] = {}
    if not app_configs(script):  # the app of a Script Editor has settings of its own
        values[keys.MOTION_BVH] = True
    if any(name.rpartition(".")[2] in WORLDS for _, name in script.called):
        values[keys.MIN_FRAME_RATE] = 1  # a World sets what its rates need
    for place, path, value in all_settings(script):
        if value is not None:
            values[path], marks["settings", path] = value, script.mark(place)
    return values, marks


def _clock(script: Script) -> ClockSpec:
    """The rates that the script gives as constants."""
    rates: dict[str, tuple[Fraction, Mark]] = {}
    for call, name in script.called:
        last = name.rpartition(".")[2]
        given: dict[str, ast.expr | None] = {}
        if last in WORLDS:
            given = {"physics": argument(call, 0, "physics_dt"), "loop": argument(call, 1, "rendering_dt")}
        elif last in ("set_physics_dt", "setup_simulation"):
            given = {"physics": argument(call, 0, "dt")}
        elif name.endswith("RenderingManager.set_dt"):
            given = {"loop": argument(call, 0, "dt")}
        for kind, node in given.items():
            dt = script.value_of(node)
            if isinstance(dt, int | float) and not isinstance(dt, bool) and 1 / MOST_HZ <= dt <= 1:
                rates[kind] = Fraction(round(1 / dt)), script.mark(call)
    mark = next((place for kind in ("physics", "loop") if kind in rates for place in rates[kind][1:]), None)
    hz = {kind: rate for kind, (rate, _) in rates.items()}
    return ClockSpec(hz.get("physics"), hz.get("loop"), mark=mark)


def _graphs(script: Script, found: Draft) -> Iterator[GraphSpec]:
    """The graphs that the script's edits create, each with the values and connections of all edits of it."""
    edits = edits_of(script)
    for graph in dict.fromkeys(one.graph for one in edits.nodes):
        made = {one.name: one for one in edits.nodes if one.graph == graph}
        values: dict[str, dict[str, Any]] = {name: {} for name in made}
        marks: dict[str, dict[str, Mark]] = {name: {} for name in made}
        for one in edits.values:
            name, _, attribute = one.name.partition(".")
            if one.graph != graph or name not in made:
                continue
            short = attribute.removeprefix("inputs:")
            marks[name][short] = script.mark(one.place)
            if one.value is None:
                found.unknown.add((f"{graph}/{name}", f"inputs:{short}"))
            else:
                values[name][short] = one.value
        if graph not in edits.known:  # its pipeline stage is a matter of the run
            found.unstaged |= {f"{graph or '/graph'}/{name}" for name in made}
        ends = ((one, one.name.partition(".")[0], one.value.partition(".")[0]) for one in edits.wires)
        yield GraphSpec(
            graph or "/graph",
            tuple(NodeSpec(n, one.value, values[n], script.mark(one.place), marks[n]) for n, one in made.items()),
            tuple(
                ConnectionSpec(one.name, one.value, script.mark(one.place))
                for one, source, target in ends
                if one.graph == graph and source in made and target in made
            ),
            pipeline_stage=STAGES.get(edits.stages.get(graph, ""), "simulation"),
            unfinished=True,
            partial=True,
        )
