"""Which colliders never collide: collision groups, filtered pairs, articulations without self-collision."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from graph.base.paths import at_or_below
from graph.base.records import dataclass
from graph.sim.attributes import value_of
from graph.sim.scene.scan import Scan
from graph.sim.scene.stage import Warn
from graph.sim.usd import EARLIEST, UsdPhysics

MOST_MASKS = 32
"""Kinds of colliders that MuJoCo's bit masks can distinguish."""


@dataclass(frozen=True)
class Filters:
    """masks: the kind of each collider prim by path; meets: (k, k) which kinds collide; apart: pairs that do not.

    The pairs are of moving bodies, or of a body and static geometry (`stills`: prims with everything below them).
    """

    masks: dict[str, int]
    meets: NDArray[np.bool_]
    apart: tuple[tuple[str, str], ...]
    stills: frozenset[str]


def read_filters(scan: Scan, warn: Warn) -> Filters:
    """Everything on a stage that keeps colliders apart."""
    apart: dict[tuple[str, str], None] = dict.fromkeys(_still_ends(scan))
    tokens: dict[str, set[tuple[int, int]]] = {}
    for number, (first, second) in enumerate(_filtered(scan)):
        bodies = [scan.body_of(path) for path in (first, second)]
        whole = [
            body if body == path and body in scan.moving else None
            for body, path in zip(bodies, (first, second), strict=True)
        ]
        if whole[0] and whole[1]:
            if whole[0] != whole[1]:
                apart[min(whole[0], whole[1]), max(whole[0], whole[1])] = None
            continue
        for side, path in enumerate((first, second)):
            for collider in scan.colliders:
                if at_or_below(collider, path):
                    tokens.setdefault(collider, set()).add((number, side))
    for group in _mechanisms_without_self_collision(scan):
        apart.update(dict.fromkeys(pair for pair in combinations(sorted(group), 2) if not scan.moving.isdisjoint(pair)))
    masks, meets = _masks(scan, tokens, warn)
    stills = frozenset(path for pair in apart for path in pair if path not in scan.moving)
    return Filters(masks, meets, tuple(apart), stills)


def _still_ends(scan: Scan) -> list[tuple[str, str]]:
    """A body and static geometry, connected by a joint whose ends do not collide."""
    out = []
    for joint in scan.joints:
        if UsdPhysics.Joint(joint.prim).GetCollisionEnabledAttr().Get(EARLIEST):
            continue
        ends = [body or target for body, target in zip(joint.bodies, joint.targets, strict=True)]
        first, second = ends
        if first and second and first != second and (first in scan.moving) != (second in scan.moving):
            out.append((min(first, second), max(first, second)))
    return out


def _filtered(scan: Scan) -> list[tuple[str, str]]:
    """Pairs of prims, one of which names the other in FilteredPairsAPI."""
    out: list[tuple[str, str]] = []
    roots = [scan.stage.GetPrimAtPath(path) for path in scan.articulation_roots]
    prims = {str(prim.GetPath()): prim for prim in roots if prim}
    prims |= {body.path: body.prim for body in scan.bodies.values()}
    prims |= scan.colliders
    for path, prim in prims.items():
        if prim.HasAPI(UsdPhysics.FilteredPairsAPI):
            targets = UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetForwardedTargets()
            out.extend((path, str(target.GetPrimPath())) for target in targets)
    return out


def _mechanisms_without_self_collision(scan: Scan) -> list[set[str]]:
    """The bodies of each articulation whose links do not collide with each other."""
    out = []
    for path in scan.articulation_roots:
        prim = scan.stage.GetPrimAtPath(path)
        said = [
            value_of(prim, name) for name in ("physxArticulation:enabledSelfCollisions", "newton:selfCollisionEnabled")
        ]
        if next((value for value in said if value is not None), True):
            continue
        out.append(set(scan.mechanisms.carriers(path)))
    return out


def _masks(scan: Scan, tokens: dict[str, set[tuple[int, int]]], warn: Warn) -> tuple[dict[str, int], NDArray[np.bool_]]:
    groups = [prim for prim in scan.stage.Traverse() if prim.IsA(UsdPhysics.CollisionGroup)]
    queries = [UsdPhysics.CollisionGroup(prim).GetCollidersCollectionAPI().ComputeMembershipQuery() for prim in groups]
    kinds: dict[tuple[frozenset[int], frozenset[tuple[int, int]]], int] = {}
    masks = {}
    for path, prim in scan.colliders.items() if groups or tokens else ():
        inside = frozenset(n for n, query in enumerate(queries) if query.IsPathIncluded(prim.GetPath()))
        kind = inside, frozenset(tokens.get(path, ()))
        masks[path] = kinds.setdefault(kind, len(kinds))
    if not kinds:
        return {}, np.ones((1, 1), dtype=np.bool_)
    table = UsdPhysics.CollisionGroup.ComputeCollisionGroupTable(scan.stage)
    paths = [prim.GetPath() for prim in groups]
    together = np.array([[table.IsCollisionEnabled(a, b) for b in paths] for a in paths], dtype=np.bool_)
    together = together.reshape(len(groups), len(groups))
    meets = np.ones((len(kinds), len(kinds)), dtype=np.bool_)
    for (first, marks), a in kinds.items():
        for (second, others), b in kinds.items():
            grouped = all(together[i, j] for i in first for j in second)
            named = any((number, 1 - side) in others for number, side in marks)
            meets[a, b] = grouped and not named
    return _merged(masks, meets, str(groups[0].GetPath()) if groups else next(iter(tokens)), warn)


def _merged(
    masks: dict[str, int], meets: NDArray[np.bool_], where: str, warn: Warn
) -> tuple[dict[str, int], NDArray[np.bool_]]:
    """Kinds that collide with the same others are merged; if too many remain, a warning says that they collide with
    all.
    """
    rows, number = np.unique(meets, axis=0, return_inverse=True)
    number = number.reshape(-1)
    first = np.array([int(np.flatnonzero(number == k)[0]) for k in range(len(rows))])
    out = meets[np.ix_(first, first)]
    masks = {path: int(number[kind]) for path, kind in masks.items()}
    if len(rows) > MOST_MASKS:
        warn(
            "collision-groups",
            where,
            f"collision groups and filtered pairs tell {len(rows)} kinds of colliders apart; {MOST_MASKS} can be, so "
            "that the rest collide with everything",
        )
        masks = {path: min(kind, MOST_MASKS - 1) for path, kind in masks.items()}
        out = out[:MOST_MASKS, :MOST_MASKS]
        out[-1, :] = out[:, -1] = True
    return masks, out


def bits(meets: NDArray[np.bool_], mask: int) -> tuple[int, int]:
    """(contype, conaffinity) of a kind: its own bit, and those of the kinds with which it collides (signed 32 bits)."""
    if meets.shape == (1, 1) and meets[0, 0]:
        return 1, 1
    affinity = sum(1 << int(other) for other in np.flatnonzero(meets[mask]))
    return _signed(1 << mask), _signed(affinity)


def _signed(value: int) -> int:
    return value - (1 << 32) if value >= 1 << 31 else value
