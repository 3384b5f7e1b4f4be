"""What pixels can show: the prims, labelled prims and labels of the stage's surfaces, by number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sensors.raycast.shared import cast_world, surface_classes, surface_labels
from sensors.surfaces.semantics import Labels, labels_of

from .channels import FIRST, INSTANCE, LABELLED, SEMANTIC

if TYPE_CHECKING:
    from graph.sim import App


@dataclass(frozen=True)
class Entities:
    """Entities of one kind. numbers: (n + 1,) uint32, that of each surface, last 0 for nothing.

    paths: of the prim of each number. labels: the labels of each number.
    """

    numbers: np.ndarray
    paths: Mapping[int, str]
    labels: Mapping[int, Labels]


def entities_of(app: App, kind: str) -> Entities:
    """The entities that the numbers of a segmentation stand for; see `sensors.camera.channels`."""
    world = cast_world(app)
    key = f"camera {kind}"
    if key not in world.cache:
        world.cache[key] = _READ[kind](app, world.surfaces)
    found: Entities = world.cache[key]
    return found


def _instances(app: App, surfaces: Sequence[Any]) -> Entities:
    """Each prim, copy of a prim and subset by itself, in the order of their paths."""
    paths = [str(surface.path) for surface in surfaces]
    return _numbered(app, paths, paths)


def _labelled(app: App, surfaces: Sequence[Any]) -> Entities:
    """Each labelled prim with what has no label of its own below it."""
    owners = [_owner(app.stage, surface) for surface in surfaces]
    return _numbered(app, owners, [owner for owner in owners if owner])


def _semantic(app: App, surfaces: Sequence[Any]) -> Entities:
    return Entities(np.append(surface_classes(app), np.uint32(0)).astype(np.uint32), {}, surface_labels(app))


_READ = {INSTANCE: _instances, LABELLED: _labelled, SEMANTIC: _semantic}


def _numbered(app: App, owners: Sequence[str], paths: Sequence[str]) -> Entities:
    number = {path: place for place, path in enumerate(sorted(set(paths)), start=FIRST)}
    numbers = np.array([*(number.get(owner, 1) for owner in owners), 0], np.uint32)
    known = {place: path for path, place in number.items()}
    return Entities(numbers, known, {place: joined_labels(app.stage, path) for place, path in known.items()})


def _owner(stage: Any, surface: Any) -> str:
    """The nearest prim with labels at or above what a surface's shape comes from; a copy is one of its own."""
    path = str(surface.path)
    instancer, bracket, _ = path.partition("[")
    prim = stage.GetPrimAtPath(str(surface.source or path))
    while prim and not prim.IsPseudoRoot():
        if labels_of(prim):
            return path if bracket else str(prim.GetPath())
        prim = prim.GetParent()
    if bracket:
        prim = stage.GetPrimAtPath(instancer)
        while prim and not prim.IsPseudoRoot():
            if labels_of(prim):
                return path
            prim = prim.GetParent()
    return ""


def joined_labels(stage: Any, path: str) -> Labels:
    """The labels of a prim and of all above it; several of one taxonomy as "parent, child"."""
    found: Labels = {}
    prim = stage.GetPrimAtPath(path.partition("[")[0])
    while prim and not prim.IsPseudoRoot():
        for taxonomy, label in labels_of(prim).items():
            found[taxonomy] = f"{label}, {found[taxonomy]}" if taxonomy in found else label
        prim = prim.GetParent()
    return found


class PixelNumbers:
    """Turns what rays hit into the numbers of entities, with one table a frame for each kind."""

    def __init__(self) -> None:
        self._composed: dict[str, tuple[np.ndarray, np.ndarray]] = {}

    def of(self, numbers: np.ndarray, kind: str, surface_of: np.ndarray, hit: np.ndarray) -> np.ndarray:
        """(n,) uint32. numbers: of the surfaces; surface_of, hit: of `Hits`."""
        known = self._composed.get(kind)
        if known is None or known[0] is not surface_of or len(known[1]) != len(surface_of):
            known = self._composed[kind] = surface_of, np.take(numbers, surface_of, mode="wrap")
        return np.take(known[1], hit, mode="clip")
