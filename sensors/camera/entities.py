"""What pixels can show: the prims, labelled prims and labels of the stage's surfaces, by number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from graph.base.records import dataclass, field
from sensors.raycast.world import CastWorld, once_a_world
from sensors.surfaces.semantics import Labels, labels_of, numbered

from .channels import FIRST, INSTANCE, LABELLED, SEMANTIC


@dataclass(frozen=True)
class Entities:
    """Entities of one kind. numbers: (n + 1,) uint32, that of each surface, last 0 for nothing.

    paths: of the prim of each number. labels: the labels of each number. layers: how many prims at or above that of a
    number have labels.
    """

    numbers: np.ndarray
    paths: Mapping[int, str]
    labels: Mapping[int, Labels]
    layers: Mapping[int, int] = field(default_factory=dict)


@once_a_world
def entities_of(world: CastWorld, kind: str) -> Entities:
    """The entities that the numbers of a segmentation stand for; see `sensors.camera.channels`."""
    return _READ[kind](world.scene.stage, world.surfaces)


def _instances(stage: Any, surfaces: Sequence[Any]) -> Entities:
    """Each prim, copy of a prim and subset by itself, in the order of their paths."""
    return _numbered(stage, surfaces, [str(surface.path) for surface in surfaces])


def _labelled(stage: Any, surfaces: Sequence[Any]) -> Entities:
    """Each labelled prim with what has no label of its own below it."""
    return _numbered(stage, surfaces, [_owner(stage, surface) for surface in surfaces])


def _semantic(stage: Any, surfaces: Sequence[Any]) -> Entities:
    """Each different set of labels, those of the prims above included, in the order of their text."""
    numbers, labels = numbered([_joined(stage, surface)[0] for surface in surfaces])
    return Entities(np.append(numbers, np.uint32(0)).astype(np.uint32), {}, labels)


_READ = {INSTANCE: _instances, LABELLED: _labelled, SEMANTIC: _semantic}


def _numbered(stage: Any, surfaces: Sequence[Any], owners: Sequence[str]) -> Entities:
    """Numbers the owners of surfaces in the order of their paths; an empty owner has no number."""
    first = {owner: surface for owner, surface in zip(reversed(owners), reversed(surfaces), strict=True) if owner}
    known = dict(enumerate(sorted(first), start=FIRST))
    number = {path: place for place, path in known.items()}
    numbers = np.array([*(number.get(owner, 1) for owner in owners), 0], np.uint32)
    found = {place: _joined(stage, first[path]) for place, path in known.items()}
    labels = {place: each for place, (each, _) in found.items()}
    return Entities(numbers, known, labels, {place: layers for place, (_, layers) in found.items()})


def lineage(stage: Any, surface: Any) -> Iterator[tuple[str, Any]]:
    """(path, prim) of a surface's prim and of all above it, the nearest first.

    A copy's prims are those of its prototype, with the paths that they have in the copy; above the prototype's root the
    path stays that of the copy. The point instancer and the prims above it follow.
    """
    copy, bracket, below = str(surface.path).rpartition("]")
    starts = [str(surface.source or surface.path)]
    if bracket:
        starts.append(copy.partition("[")[0])
    seen = set()
    for start in starts:
        prim = stage.GetPrimAtPath(start)
        while prim and not prim.IsPseudoRoot() and prim.GetPath() not in seen:
            seen.add(prim.GetPath())
            yield f"{copy}]{below}" if bracket else str(prim.GetPath()), prim
            prim, below = prim.GetParent(), below.rpartition("/")[0]


def _owner(stage: Any, surface: Any) -> str:
    """The nearest prim with labels at or above what a surface's shape comes from; empty if there is no such prim."""
    return next((path for path, prim in lineage(stage, surface) if labels_of(prim)), "")


def _joined(stage: Any, surface: Any) -> tuple[Labels, int]:
    """The labels of a surface's prim and of all above it, several of one taxonomy as "parent, child"; and how many of
    these prims have any.
    """
    found: Labels = {}
    layers = 0
    for _, prim in lineage(stage, surface):
        labels = labels_of(prim)
        layers += bool(labels)
        for taxonomy, label in labels.items():
            found[taxonomy] = f"{label}, {found[taxonomy]}" if taxonomy in found else label
    return found, layers


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
