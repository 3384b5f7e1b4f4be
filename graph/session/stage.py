"""Builds the stage of a graph file and checks it for the graphs that will run on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark, Problem, UserError
from graph.node.at_load import NodeAtLoad
from graph.node.context import Warn
from graph.spec.file_spec import FileSpec, NodeSpec, Note, SceneSpec

from .overrides import SET
from .scene_checks import named_sensors, scaled_place

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Graph, Node
    from graph.sim.settings import Settings

GRAPH_PRIMS = ("", "Scope", "Xform", "OmniGraph", "ComputeGraph")
"""Prim types that a graph's path may have on the stage."""


def build_stage(
    spec: FileSpec, allow: Sequence[Path], warn: Warn, *, skip_outside: bool = False
) -> tuple[Usd.Stage, Any, list[Problem]]:
    """The file's scene with its inline prims authored on top; the MJCF model (`MjcfScene`) that it mirrors, if any.

    The last item is the problems of the inline prims. Raises UserError without a scene to author them on.
    """
    from graph.sim.scene.placed_types import give_transforms
    from graph.sim.scene.prims import author_prims
    from graph.sim.scene.stage import add_scene, open_stage
    from graph.sim.scene.stage_metadata import meters_per_unit, up_axis
    from sensors.configs import author_config
    from sensors.sensor_types import sensor_types

    scene = spec.scene
    roots = [root for root in (spec.folder, *allow) if root is not None]
    mjcf: Any = None
    if scene.mjcf is not None:
        from graph.sim.world import model_opener

        open_model = model_opener()
        try:
            mjcf = open_model(scene.mjcf, roots, scene.keyframe, warn, is_urdf=scene.is_urdf)
        except UserError as error:
            placed = [one if one.mark else Problem(one.message, scene.mark) for one in error.problems]
            raise UserError(placed) from error
        stage = mjcf.stage
        if scene.usd is not None:  # a USD file of graphs on top of the model
            add_scene(stage, scene.usd, roots, warn, skip_outside=skip_outside)
    else:
        stage = open_stage(scene.usd, roots, warn, skip_outside=skip_outside)
    meters_per_unit(stage), up_axis(stage)
    types = sensor_types()
    give_transforms(stage)

    def where(path: str, key: str | None = None) -> Mark | None:
        return scene.prim_marks.get((path, key) if key else (path,)) or scene.prim_marks.get((path,))

    try:
        for prims in (scene.prims, scene.changes):
            if prims is scene.changes:
                _copy_prims(stage, scene)
                _require_prims(stage, scene)
            author_prims(
                stage,
                prims,
                where,
                sensor_config=author_config,
                sensor_types=types,
                allow_roots=roots,
                folder=spec.folder,
                warn=warn,
            )
    except UserError as error:
        return stage, mjcf, [_of_caller(problem) for problem in error.problems]
    if mjcf is not None:
        mjcf.overridden({**scene.prims, **scene.changes}, warn)
        mjcf.settle(warn)
    return stage, mjcf, []


def _copy_prims(stage: Usd.Stage, scene: SceneSpec) -> None:
    """Copies prims of the scene's own files, by references within the stage, or removes them (`SceneSpec.copies`)."""
    from graph.sim.scene.prim_paths import near_prim, prim_at

    problems = []
    for path, source in scene.copies.items():
        given, mark = source or path, scene.prim_marks.get((path,))
        if not prim_at(stage, given):
            problems.append(Problem(f"randomize: {given}.copies: there is no such prim{near_prim(stage, given)}", mark))
        elif not source:
            stage.GetPrimAtPath(path).SetActive(False)
        elif stage.GetPrimAtPath(path) and source != path:
            problems.append(Problem(f"randomize: {given}.copies: the scene has a prim {path} already", mark))
        elif source != path:
            stage.DefinePrim(path).GetReferences().AddInternalReference(source)
    if problems:
        raise UserError(problems)


def _require_prims(stage: Usd.Stage, scene: SceneSpec) -> None:
    """Raises UserError with a line for each change of a prim that neither the file nor its scene has."""
    from graph.sim.scene.prim_paths import near_prim, prim_at

    problems = []
    for path, keys in scene.changes.items():
        if not prim_at(stage, path):
            first = next(iter(keys.get("attributes") or keys))
            mark = scene.prim_marks.get((path, first))
            drawn = mark is not None and not mark.file.startswith(SET)
            where = f"{'randomize:' if drawn else SET} {path}.{first}"
            problems.append(Problem(f"{where}: there is no such prim{near_prim(stage, path)}", mark if drawn else None))
    if problems:
        raise UserError(problems)


def _of_caller(problem: Problem) -> Problem:
    """A problem of a value that the caller set, without the path and key that its place names; others as they are."""
    mark = problem.mark
    if mark is None or not mark.file.startswith(f"{SET} "):
        return problem
    path, _, name = mark.file.removeprefix(f"{SET} ").rpartition(".")
    message = problem.message
    for known in (path.removesuffix(".attributes"), "attributes", name, name):
        message = message.removeprefix(f"{known}: ")
    return Problem(f"{mark.file}: {message}")


def stage_problems(stage: Usd.Stage, spec: FileSpec) -> Iterator[Problem]:
    """Stage conflicts: sensor prims that describe no sensor, graph paths already taken."""
    yield from bad_sensors(stage, spec)
    yield from taken_paths(stage, spec)


def bad_sensors(stage: Usd.Stage, spec: FileSpec) -> list[Problem]:
    """A line for each mistake in a sensor of the stage, at its prim if the file authors it, else with the scene."""
    from sensors.sensor_types import sensor_problems

    problems = []
    for path, message in sensor_problems(stage):
        mark = spec.scene.prim_marks.get((path,))
        scene = "" if mark is not None or spec.scene.usd is None else f"{spec.scene.usd.name}: "
        problems.append(Problem(f"{scene}{message}", mark))
    return problems


def taken_paths(stage: Usd.Stage, spec: FileSpec) -> list[Problem]:
    """A line for each graph whose path is that of another prim."""
    problems = []
    for graph in spec.graphs:
        kind = str(stage.GetPrimAtPath(graph.path).GetTypeName()) if stage.GetPrimAtPath(graph.path) else ""
        if kind not in GRAPH_PRIMS:
            problems.append(Problem(f"{graph.path} is a {kind} on the stage; give the graph another path", graph.mark))
    return problems


def missing_targets(
    stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph], *, flawed: bool = False
) -> list[Problem]:
    """A line for each input of a node that names a prim, as a target or by its path, that is not on the stage.

    Graphs and render products are excluded: they are created when the file runs. flawed: an inline prim of the file is
    wrong, so that it, or one below it, may be missing for that reason.
    """
    from graph.sim.scene.prim_paths import is_prim_path, near_prim

    graph_paths = {graph.path for graph in graphs}
    problems = []
    for node, author in _written_nodes(spec, graphs):
        for name in node.type.inputs:
            for target in _named_prims(node, name):
                if not is_prim_path(target):
                    wrong = f"{target} is not a path of a prim; write / and names of letters, digits and _"
                elif (
                    target in graph_paths
                    or target.startswith("/Render/")
                    or stage.GetPrimAtPath(target)
                    or (flawed and any(f"{target}/".startswith(f"{path}/") for path in spec.scene.prims))
                ):
                    continue
                else:
                    wrong = f"there is no prim {target} on the stage{near_prim(stage, target)}"
                message = f"{node.path}.inputs:{name}: {wrong}"
                problems.append(Problem(message, author.input_marks.get(name, author.mark)))
    return problems


def _named_prims(node: Node, name: str) -> Sequence[str]:
    """The paths of the prims that an input names, as far as the file determines them; none for other inputs."""
    attribute = node.type.inputs[name]
    if attribute.type == "target":
        return node.get(name) or ()
    if attribute.role != "prim" or node.connected(name):
        return ()
    if "usePath" in node.type.inputs and (node.connected("usePath") or not node.get("usePath")):
        return ()
    value = node.get(name)
    paths = [value] if isinstance(value, str) else value
    return [str(path).partition(".")[0] for path in paths if path]


def unrenderable_cameras(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> list[Problem]:
    """A line for each sensor input in the file whose prim exists but is not a sensor that can be rendered."""
    from graph.sim.scene.prim_paths import prim_at
    from sensors.products import sensor_problem

    return [
        Problem(f"{node.path}.inputs:{name}: {problem}", mark)
        for node, name, mark in _given_inputs(spec, graphs)
        if name in node.type.inputs_as("sensor")
        for target in node.get(name) or ()
        if prim_at(stage, target) and (problem := sensor_problem(stage, target))
    ]


def sensors_in_solids(stage: Usd.Stage, graphs: Sequence[Graph]) -> Iterator[Note]:
    """A warning for each sensor that nodes name and that starts inside a shape, which all its rays would hit."""
    from graph.sim.geometry.inside import shapes_around
    from graph.sim.scene.prim_paths import prim_at
    from sensors.prim import read_exclude
    from sensors.products import sensor_problem

    named = named_sensors(graphs)
    sensors = [path for path in named if prim_at(stage, path) and not sensor_problem(stage, path)]
    prims = [prim_at(stage, path) for path in sensors]
    for path, around in zip(sensors, shapes_around(stage, prims, [*map(read_exclude, prims)]), strict=True):
        if around:
            shapes = ", ".join(around)
            # Where a scale has moved it, `exclude` would keep it at the wrong place.
            moved = "a scale above it moved it there, see sensor-scaled" if scaled_place(stage, path) else ""
            remedy = moved or f"move it, or let it pass: exclude: [{shapes}]"
            yield "sensor-in-solid", path, f"it starts inside {shapes}, which its rays hit first; {remedy}"


def prims_for_products(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> list[Problem]:
    """A line for each render product path in the file that is a prim of the scene: no frame would come from it."""
    from graph.sim.scene.prim_paths import prim_at

    problems = []
    for node, name, mark in _given_inputs(spec, graphs):
        path = str(node.get(name) or "") if name in node.type.inputs_as("product") else ""
        prim = prim_at(stage, path)
        if prim and prim.GetTypeName() != "RenderProduct":
            message = f"{node.path}.inputs:{name}: {path} is a prim, not a render product; connect it to"
            problems.append(Problem(f"{message} IsaacCreateRenderProduct with cameraPrim {path}", mark))
    return problems


def unmade_products(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> Iterator[Note]:
    """A warning for each written path of a render product where no node of the file makes a product."""
    if any(node.type.outputs_as("product") for graph in graphs for node in graph.nodes.values()):
        return
    for node, name, mark in _given_inputs(spec, graphs):
        path = str(node.get(name) or "") if name in node.type.inputs_as("product") else ""
        if path and not stage.GetPrimAtPath(path):
            where = str(mark or f"{node.path}.inputs:{name}")
            message = f"{node.path}.inputs:{name}: no node makes the render product {path}, so that only a script can"
            yield "render-product-missing", where, f"{message}; connect it to IsaacCreateRenderProduct"


def type_problems(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> list[Problem]:
    """A line for each mistake that the nodes' own types find in their values and connections (`NodeType.check`).

    Graphs that lost a wrong connection are left out: their nodes may need it. Of a node that lost a wrong value, only
    mistakes in its other inputs count.
    """
    whole = {graph.path for graph in spec.graphs for one in graphs if one.spec.connections == graph.connections}
    written = [
        (node, author)
        for node, author in _written_nodes(spec, graphs)
        if node.type.check is not None and node.graph.path in whole
    ]
    if not written:
        return []
    given: dict[Node, dict[str, Mark | None]] = {}
    for node, name, mark in _given_inputs(spec, graphs):
        given.setdefault(node, {})[name] = mark
    settings = _settings(spec)
    used = {f"{graph.path}/{one.name}": one.inputs for graph in graphs for one in graph.spec.nodes}
    problems = []
    for node, author in written:
        lost = author.inputs.keys() - used[node.path].keys()
        marks = given.get(node, {})
        sensors = _sensors_behind(node, given)
        check = node.type.check
        assert check is not None
        for name, wrong in check(NodeAtLoad(node.db, stage, tuple(marks), sensors, settings)):
            if lost and (not name or name in lost):
                continue
            end = f"{node.path}.inputs:{name}" if name else node.path
            problems.append(Problem(f"{end}: {wrong}", marks.get(name, author.mark)))
    return problems


def _settings(spec: FileSpec) -> Settings:
    from graph.sim.settings import of_profile

    try:
        return of_profile(spec.clock.parity, spec.settings)
    except UserError:  # reported at its place
        return of_profile(spec.clock.parity)


def _sensors_behind(node: Node, given: Mapping[Node, Mapping[str, Mark | None]]) -> tuple[str, ...]:
    """The sensor prims whose render product is connected to a node, as far as the file determines them."""
    if not any(node.connected(name) for name in node.type.inputs_as("product")):
        return ()
    makers = [source for source in node.sources if source.type.inputs_as("sensor")]
    if len(makers) != 1:
        return ()
    maker = makers[0]
    named = [name for name in maker.type.inputs_as("sensor") if name in given.get(maker, {})]
    return tuple(str(path) for name in named for path in maker.get(name) or ())


def _given_inputs(spec: FileSpec, graphs: Sequence[Graph]) -> Iterator[tuple[Node, str, Mark | None]]:
    """Each input that the file sets and no connection feeds, of enabled nodes."""
    for node, author in _written_nodes(spec, graphs):
        names = [name.removeprefix("inputs:") for name in author.inputs]
        names = [name for name in names if name in node.names["inputs"] and not node.connected(name)]
        if "enabled" in names and node.get("enabled") is False:
            continue
        for name in names:
            yield node, name, author.input_marks.get(name, author.mark)


def _written_nodes(spec: FileSpec, graphs: Sequence[Graph]) -> Iterator[tuple[Node, NodeSpec]]:
    """Each compiled node with its spec in the file."""
    written = {f"{graph.path}/{node.name}": node for graph in spec.graphs for node in graph.nodes}
    for graph in graphs:
        for node in graph.nodes.values():
            yield node, written[node.path]
