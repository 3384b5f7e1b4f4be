"""Loads a model into MuJoCo: specification and compiled model; its errors get their places in the files."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import Mark, Problem, UserError
from graph.base.silence import silenced
from graph.sim.physics.mujoco.library import give_memory, mujoco
from graph.sim.scene.stage import Warn

from .files import Document, shown
from .urdf import hide_collisions

_LINE = re.compile(r"(?:Element '(?P<tag>\w*)'|Element name '(?P<name>[^\n]*)', id -?\d+)(?:, line (?P<line>\d+))?")
_KINDS = ("bodies", "joints", "geoms", "sites", "cameras", "lights", "actuators", "sensors")


def load(document: Document, warn: Warn) -> tuple[Any, Any]:
    """The `MjSpec` and `MjModel` of a document; every element with a prim has a name.

    Raises UserError, one line with file and line, for models that MuJoCo refuses. Its warnings become `mjcf-model`.
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            spec = mujoco.MjSpec.from_string(document.text, include=document.models, assets=document.assets)
            if document.is_urdf:
                hide_collisions(spec)
            _name_all(spec)
            give_memory(spec, len(spec.bodies))
            with silenced():  # Qhull prints pages about meshes that have no hull
                model = spec.compile()
        except (ValueError, mujoco.FatalError) as error:
            raise UserError(_problem(document, str(error))) from error
    for mark, text in document.left_out:
        warn("urdf-left-out", str(mark), text)
    _check_numbers(document, model)
    for each in said:
        problem = _problem(document, str(each.message))
        warn("mjcf-model", str(problem.mark or shown(document.file)), problem.message)
    return spec, model


SHORTEST_STEP = 1e-9
"""Durations are exact fractions with a denominator of at most 10^9."""


def _check_numbers(document: Document, model: Any) -> None:
    """Checks values that MuJoCo accepts: a time step of 0, and positions that are not finite."""
    step = float(model.opt.timestep)
    if not 0 < step < math.inf:
        raise UserError(f"{shown(document.file)}: option timestep is {step:g}; it must be above 0")
    if step < SHORTEST_STEP:
        raise UserError(f"{shown(document.file)}: option timestep is {step:g}; the shortest is {SHORTEST_STEP:g} s")
    for kind, names in (("body", model.body), ("geom", model.geom)):
        places = np.concatenate([getattr(model, f"{kind}_pos"), getattr(model, f"{kind}_quat")], axis=1)
        bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
        if len(bad):
            name = names(int(bad[0])).name
            raise UserError(f"{shown(document.file)}: the place of {kind} {name} is not finite; correct it")


def _name_all(spec: Any) -> None:
    """Names each unnamed body, joint and other element, because MuJoCo's numbers change when a model grows."""
    for kind in _KINDS:
        found = list(getattr(spec, kind))
        taken = {element.name for element in found}
        for number, element in enumerate(found):
            if element.name:
                continue
            name = f"{'body' if kind == 'bodies' else kind.removesuffix('s')}{number}"
            while name in taken:
                name += "_"
            element.name = name
            taken.add(name)


def _problem(document: Document, text: str) -> Problem:
    """One of MuJoCo's messages as one line, with its place in the files."""
    place: Mark | None = None
    found = _LINE.search(text)
    about = ""
    if found:
        place = document.mark(int(found["line"] or 0))
        about = found["tag"] or found["name"] or ""
        text = text[: found.start()]
    words = " ".join(text.split())
    while words.startswith(("XML Error:", "Error:")):
        words = words.partition(":")[2].strip()
    words = words.removeprefix("Schema violation: ").rstrip(".")
    for name in (*document.assets, *document.models):
        words = words.replace(name, name.partition("-")[2])
    if about and about not in words:
        words = f"{about}: {words}"
    return Problem(words, place or Mark(shown(document.file), 0, 0))


def keyframe_number(model: Any, keyframe: str | int, file: Path) -> int:
    """The number of the keyframe with a name or number. Raises UserError for an unknown one."""
    names = [model.key(number).name for number in range(model.nkey)]
    if isinstance(keyframe, int) and not isinstance(keyframe, bool) and 0 <= keyframe < model.nkey:
        return keyframe
    if keyframe in names:
        return names.index(str(keyframe))
    there = ", ".join(name or str(number) for number, name in enumerate(names))
    has = f"it has {there}" if names else "it has none"
    raise UserError(f"scene.keyframe: {shown(file)} has no keyframe {keyframe!r}; {has}")
