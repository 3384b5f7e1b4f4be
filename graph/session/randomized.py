"""Resolves `randomize:` of a graph file: what a seed draws becomes values of the file, before anything is built."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.limits import check
from graph.spec.distributions import Stream, parse
from graph.spec.file_spec import FileSpec, SceneSpec

from .overrides import apply_overrides

COPIES = "copies"


def randomized(spec: FileSpec, seed: int, fixed: Iterable[str] = ()) -> tuple[FileSpec, dict[str, Any]]:
    """The file with the values that the seed draws, and those values by what they are of.

    First the numbers of copies, from the outer prims to the inner ones: copies are named /World/Rock_1, /World/Rock_2
    beside /World/Rock, and each draws its own values. fixed: targets that the caller sets, which are not drawn. Raises
    UserError with a line for each target that cannot be.
    """
    fixed = frozenset(fixed)
    drawn: dict[str, Any] = {}
    problems: list[Problem] = []
    targets = [name.rpartition(".") for name in spec.randomize]
    counted = sorted((path for path, _, key in targets if key == COPIES), key=lambda path: path.count("/"))
    copies: dict[str, list[str]] = {}
    for path in counted:
        for one in _instances(path, copies):
            name = f"{one}.{COPIES}"
            if name in fixed:
                problems.append(Problem("copies are drawn, not set; write them into the file", _mark(spec, path)))
                continue
            count = drawn[name] = _draw(spec, f"{path}.{COPIES}", seed, name)
            try:
                spec, names = _copied(spec, one, count)
            except UserError as error:
                mark = _mark(spec, path)
                problems += [Problem(f"randomize: {name}: {found.message}", mark) for found in error.problems]
                names = [one]
            copies.setdefault(path, []).extend(names)
    values: dict[str, Any] = {}
    marks: dict[str, Mark] = {}
    for path, _, key in targets:
        if key == COPIES:
            continue
        for one in _instances(path, copies):
            name = f"{one}.{key}"
            if name in fixed:
                continue
            values[name] = _draw(spec, f"{path}.{key}", seed, name)
            if mark := spec.marks.get(("randomize", f"{path}.{key}")):
                marks[name] = mark
    try:
        spec = apply_overrides(spec, values, marks)
    except UserError as error:
        problems += error.problems
    if problems:
        raise UserError(problems)
    return spec, drawn | values


def _mark(spec: FileSpec, path: str) -> Mark | None:
    return spec.marks.get(("randomize", f"{path}.{COPIES}"))


def _draw(spec: FileSpec, target: str, seed: int, purpose: str) -> Any:
    return parse(spec.randomize[target]).draw(Stream(seed, f"randomize {purpose}"))


def _instances(path: str, copies: Mapping[str, list[str]]) -> list[str]:
    """The paths that stand for a path of the file: itself, or those in every copy of the innermost copied prim."""
    inner = max((one for one in copies if path == one or path.startswith(f"{one}/")), key=len, default=None)
    return [path] if inner is None else [one + path.removeprefix(inner) for one in copies[inner]]


def _copied(spec: FileSpec, path: str, count: Any) -> tuple[FileSpec, list[str]]:
    """The file with `count` prims instead of one, and their paths. Raises UserError for a count that cannot be."""
    if type(count) is not int or count < 0:
        raise UserError(f"{count!r} is not a number of copies; draw whole numbers from 0, such as integers(0, 5)")
    check("file.prims", count, f"{path}: too many copies")
    scene, paths = spec.scene, [path, *(f"{path}_{number}" for number in range(1, count))][:count]
    if not path.startswith("/") or "." in path:
        raise UserError("only a prim has copies; write /PRIM/PATH.copies")
    if taken := [one for one in paths[1:] if one in scene.prims]:
        raise UserError(f"{taken[0]} is a prim of the file already; rename it")
    if any(one == path or one.startswith(f"{path}/") for one in scene.prims):
        return replace(spec, scene=_inline(scene, path, paths)), paths
    if scene.mjcf is not None:
        raise UserError("only prims of USD scenes and inline prims have copies, not bodies of an MJCF or URDF model")
    made: dict[str, str] = {path: ""}
    if paths:
        made = dict.fromkeys(paths, path)
    mark = spec.marks.get(("randomize", f"{path}.{COPIES}"))
    marks = dict(scene.prim_marks)
    if mark is not None:
        marks |= {(one,): mark for one in made}
    return replace(spec, scene=replace(scene, copies={**scene.copies, **made}, prim_marks=marks)), paths


def _inline(scene: SceneSpec, path: str, paths: list[str]) -> SceneSpec:
    prims: dict[str, Mapping[str, Any]] = {}
    marks = dict(scene.prim_marks)
    for name, keys in scene.prims.items():
        if name != path and not name.startswith(f"{path}/"):
            prims[name] = keys
            continue
        for one in paths:
            copy = one + name.removeprefix(path)
            prims[copy] = keys if one == path else _renamed(keys, path, one)
            marks |= {(copy, *rest): mark for rest, mark in _marks_of(scene, name)}
    return replace(scene, prims=prims, prim_marks=marks)


def _marks_of(scene: SceneSpec, path: str) -> Iterator[tuple[tuple[str, ...], Mark]]:
    for key in ((path,), *((path, one) for one in scene.prims[path])):
        if key in scene.prim_marks:
            yield key[1:], scene.prim_marks[key]


def _renamed(value: Any, old: str, new: str) -> Any:
    """The value of a copy, with paths inside the prim led to the copy's own prims."""
    if isinstance(value, Mapping):
        return {key: _renamed(one, old, new) for key, one in value.items()}
    if isinstance(value, list):
        return [_renamed(one, old, new) for one in value]
    if isinstance(value, str) and (value == old or value.startswith(f"{old}/")):
        return new + value.removeprefix(old)
    return value
