"""Values of the caller that replace those of a graph file: `--set NODE.ATTR=VALUE` and `--set /PRIM.ATTR=VALUE`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.forms import Form, FormError
from graph.base.suggest import did_you_mean
from graph.spec.file_spec import FileSpec, GraphSpec, SceneSpec

REPLACED = {"orient": "rotate", "rotate": "orient", "density": "mass"}
"""Keys of a prim that hold instead of another: setting one removes the other."""
SET = "--set"
FORMS = "write NODE.ATTR=VALUE for a node's input, or /PRIM/PATH.ATTR=VALUE for a prim of the scene"


def apply_overrides(spec: FileSpec, overrides: Mapping[str, Any], marks: Mapping[str, Mark] | None = None) -> FileSpec:
    """The file with some of its values replaced; a value given as text is read as YAML.

    `NODE.ATTR` is an input of a node, by the node's name, or by its path if the name is not unique. `/PRIM/PATH.ATTR`
    is a key of an inline prim (`translate`, `radius`, `config`) or any USD attribute, of a prim of the file or of its
    scene; the latter are found when the stage is built (`graph.session.stage`). `clock.KEY` and `scene.KEY` are keys of
    these sections. marks: where a file has the values; without one the caller set it. Raises UserError with a line for
    each target that cannot be.
    """
    problems: list[Problem] = []
    for target, given in overrides.items():
        mark = (marks or {}).get(target)
        try:
            if mark is None and isinstance(given, str):
                given = _read(given)
            spec = _applied(spec, target, given, mark or Mark(f"{SET} {target}", 0, 0))
        except UserError as error:
            where = f"randomize: {target}" if mark else f"{SET} {target}"
            problems += [Problem(f"{where}: {one.message}", mark) for one in error.problems]
    if problems:
        raise UserError(problems)
    return spec


def node_names(spec: FileSpec) -> list[str]:
    """The names by which `NODE.ATTR` can name the nodes of a file: their own, and their paths."""
    return [name for graph in spec.graphs for node in graph.nodes for name in (node.name, f"{graph.path}/{node.name}")]


def _read(text: str) -> Any:
    from graph.files import parse_value

    return parse_value(text)


def _applied(spec: FileSpec, target: str, value: Any, mark: Mark) -> FileSpec:
    name, dot, attribute = target.rpartition(".")
    if not dot or not name or not attribute:
        raise UserError(_missing_dot(spec, target))
    found = [
        (g, n)
        for g, graph in enumerate(spec.graphs)
        for n, node in enumerate(graph.nodes)
        if name in (node.name, f"{graph.path}/{node.name}")
    ]
    if len(found) > 1:
        raise UserError("several graphs have such a node; give its whole path")
    if found:
        [(g, n)] = found
        graphs = [*spec.graphs]
        graphs[g] = _with_input(graphs[g], n, attribute.removeprefix("inputs:"), value, mark)
        return replace(spec, graphs=tuple(graphs))
    if name in _SECTIONS:
        return _SECTIONS[name](spec, attribute, value)
    if not name.startswith("/") or any(name.startswith(f"{graph.path}/") for graph in spec.graphs):
        raise UserError(_unknown_node(spec, name, attribute))
    return replace(spec, scene=_with_key(spec.scene, name.removesuffix(".attributes"), attribute, value, mark))


def _missing_dot(spec: FileSpec, target: str) -> str:
    """What is wrong with a target without a dot; a path that ends in an attribute's name gets one."""
    prim, slash, attribute = target.rpartition("/")
    if slash and prim and (":" in attribute or prim in spec.scene.prims):
        return f"the attribute stands behind a dot: {prim}.{attribute}"
    return FORMS


def _unknown_node(spec: FileSpec, name: str, attribute: str) -> str:
    near = did_you_mean(name, node_names(spec))
    whole = [path for path in spec.scene.prims if name and path.endswith(f"/{name.strip('/')}")]
    if whole and (not near or not name.startswith("/")):
        return f"a prim is named by its whole path: {whole[0]}.{attribute}"
    hint = "" if name.startswith("/") else f"; a prim is named by its whole path, such as /World/{name}.{attribute}"
    return f"no node has that name{near or hint}"


def _with_input(graph: GraphSpec, index: int, attribute: str, value: Any, mark: Mark) -> GraphSpec:
    node = graph.nodes[index]
    if _is_connected(graph, node.name, attribute):
        raise UserError("a connection feeds this input; set the attribute at its source")
    known = next((name for name in node.inputs if name.removeprefix("inputs:") == attribute), attribute)
    changed = replace(
        node, inputs={**node.inputs, known: value}, input_marks={**node.input_marks, known: mark, attribute: mark}
    )
    return replace(graph, nodes=(*graph.nodes[:index], changed, *graph.nodes[index + 1 :]))


def _is_connected(graph: GraphSpec, node: str, attribute: str) -> bool:
    ends = (connection.target.rpartition(".") for connection in graph.connections)
    return any(
        end in (node, f"{graph.path}/{node}") and name.removeprefix("inputs:") == attribute for end, _, name in ends
    )


def _with_key(scene: SceneSpec, path: str, name: str, value: Any, mark: Mark) -> SceneSpec:
    """The scene with a key or an attribute of one prim; prims that are not inline are among its `changes`."""
    from graph.files.prim_schema import PRIM

    inline = path in scene.prims
    keys = dict((scene.prims if inline else scene.changes).get(path, {}))
    if name in PRIM["properties"] and not (name == "attributes" and isinstance(value, Mapping)):
        keys.pop(REPLACED.get(name, ""), None)
        keys[name] = value
    else:
        more = value if name == "attributes" else {name: value}
        keys["attributes"] = {**keys.get("attributes", {}), **more}
    marks = {**scene.prim_marks, (path, name): mark} | ({} if inline else {(path,): mark})
    if inline:
        return replace(scene, prims={**scene.prims, path: keys}, prim_marks=marks)
    return replace(scene, changes={**scene.changes, path: keys}, prim_marks=marks)


def _with_clock(spec: FileSpec, key: str, value: Any) -> FileSpec:
    from graph.files.file_forms import Clock

    return replace(spec, clock=replace(spec.clock, **{key: getattr(_section(Clock, key, value), key)}))


def _with_scene(spec: FileSpec, key: str, value: Any) -> FileSpec:
    """The file with another scene, below its folder as the one that it names."""
    from graph.files.file_forms import Scene
    from graph.files.paths import confined

    found = getattr(_section(Scene, key, value), key)
    if key == "keyframe":
        return replace(spec, scene=replace(spec.scene, keyframe=found))
    if key not in ("usd", "mjcf", "urdf"):
        raise UserError("a prim is set by its path: /PRIM/PATH.ATTR")
    try:
        file = confined(found, spec.folder or Path.cwd())
    except ValueError as error:
        raise UserError(str(error)) from None
    usd, model = (file, None) if key == "usd" else (None, file)
    return replace(spec, scene=replace(spec.scene, usd=usd, mjcf=model, is_urdf=key == "urdf"))


def _section(form: type[Form], key: str, value: Any) -> Form:
    """A section of the file with one key. Raises UserError for an unknown key or an invalid value."""
    if key not in form.fields:
        raise UserError(f'there is no key "{key}"{did_you_mean(key, form.fields)}')
    try:
        return form.read({key: value})
    except FormError as error:
        first = error.errors[0]
        choices = f"; choose one of {', '.join(map(str, first.detail))}" if first.kind == "choice" else ""
        raise UserError(str(first.detail) if first.kind == "refused" else f"{value!r} cannot be{choices}") from None


_SECTIONS = {"clock": _with_clock, "scene": _with_scene}
