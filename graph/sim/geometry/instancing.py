"""Point instancers: the prims that they copy, and the places of the copies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.limits import allowed, most
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.attributes import array_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Usd, UsdGeom

Integers = NDArray[np.int64]
Complain = Callable[[str, str], None]
"""Takes the path of an instancer and what is wrong with it."""

_EVERYTHING = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)
"""Prototypes may be overs or classes, which are not drawn themselves."""


@dataclass(frozen=True, eq=False)
class Copies:
    """Copies of one gprim: their numbers (k,) and matrices (k, 4, 4), column vectors, to the instancer's own space.

    name: the gprim's path below the prototype's root, starting with a slash; empty for the root itself.
    """

    prim: Any
    name: str
    numbers: Integers
    matrices: Floats


def copies_of(prim: Any, complain: Complain, above: tuple[str, ...] = ()) -> list[Copies]:
    """The copies of a point instancer: all visible gprims, nested instancers included.

    The numbers are those of this instancer's points; nested instancers repeat them. Points with invalid numbers are
    left out and reported to `complain`.
    """
    path = str(prim.GetPath())
    if path in above:
        complain(path, "the instancer copies itself; that copy is left out")
        return []
    if not above and (count := expected_copies(prim)) > most("scene.copies"):
        complain(path, f"its {count:,} copies are too many and left out; {allowed('scene.copies')}")
        return []
    instancer = UsdGeom.PointInstancer(prim)
    prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
    which = array_of(instancer.GetProtoIndicesAttr(), np.int64)
    matrices = _matrices(instancer, which, lambda message: complain(path, message))
    if matrices is None:
        return []
    bad = (which < 0) | (which >= len(prototypes))
    shown = ~bad & _visible(instancer, len(which), lambda message: complain(path, message))
    finite = np.isfinite(matrices).all(axis=(1, 2))
    if bad.any() or not finite.all():
        complain(
            path,
            f"{int(bad.sum())} of its points name prototypes that do not exist and {int((~finite).sum())} are not "
            "finite; they are left out",
        )
    shown &= finite
    found = []
    for number, target in enumerate(prototypes):
        points = np.flatnonzero(shown & (which == number))
        root = prim.GetStage().GetPrimAtPath(target)
        if not root:
            complain(path, f"its prototype {target} does not exist; it is left out")
        elif len(points):
            found += _placed(root, points, matrices[points], complain, (*above, path))
    return found


def expected_copies(prim: Any) -> int:
    """An upper bound of the copies of gprims that an instancer makes, from its indices, before any is made."""
    known: dict[str, int] = {}

    def instancer_copies(instancer: Any) -> int:
        path = str(instancer.GetPath())
        if path not in known:
            known[path] = 0  # an instancer within itself makes no copies
            schema = UsdGeom.PointInstancer(instancer)
            which = array_of(schema.GetProtoIndicesAttr(), np.int64)
            targets = schema.GetPrototypesRel().GetForwardedTargets()
            points = np.bincount(which[(which >= 0) & (which < len(targets))], minlength=len(targets)).tolist()
            roots = (instancer.GetStage().GetPrimAtPath(target) for target in targets)
            known[path] = sum(count * below(root) for count, root in zip(points, roots, strict=True) if count and root)
        return known[path]

    def below(root: Any) -> int:
        total, walk = 0, iter(Usd.PrimRange(root, _EVERYTHING))
        for part in walk:
            if part.IsA(UsdGeom.PointInstancer):
                walk.PruneChildren()
                total += instancer_copies(part)
            else:
                total += bool(part.IsA(UsdGeom.Gprim))
        return total

    return instancer_copies(prim)


def _placed(root: Any, points: Integers, matrices: Floats, complain: Complain, above: tuple[str, ...]) -> list[Copies]:
    parts = _parts(root, complain, above)
    single = len({id(part) for part, *_ in parts}) == 1
    found = []
    for part, name, local in parts:
        placed = np.einsum("kij,mjl->kmil", matrices, local).reshape(-1, 4, 4)
        found.append(Copies(part, "" if single else name, np.repeat(points, len(local)), placed))
    return found


def _parts(root: Any, complain: Complain, above: tuple[str, ...]) -> list[tuple[Any, str, Floats]]:
    """The gprims of a prototype: prim, name, (m, 4, 4) matrices to the place of the prototype (its own included)."""
    found: list[tuple[Any, str, Floats]] = []
    start = str(root.GetPath())
    cache: dict[str, Floats] = {}
    walk = iter(Usd.PrimRange(root, _EVERYTHING))
    for part in walk:
        path = str(part.GetPath())
        above_it = np.eye(4) if path == start else cache[path.rpartition("/")[0]]
        local = above_it @ _local(part)
        cache[path] = local
        if hidden(part):
            walk.PruneChildren()
        elif part.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            name = path[len(start) :]
            inner = copies_of(part, complain, above)
            found.extend((each.prim, name + each.name, local @ each.matrices) for each in inner)
        elif castable(part):
            found.append((part, path[len(start) :], local[None]))
    return found


def hidden(prim: Any) -> bool:
    """Whether a prim is authored as invisible, which hides everything below it."""
    if not prim.IsA(UsdGeom.Imageable):
        return False
    visibility = UsdGeom.Imageable(prim).GetVisibilityAttr()
    return bool(visibility.HasAuthoredValue() and visibility.Get(EARLIEST) == UsdGeom.Tokens.invisible)


def castable(prim: Any) -> bool:
    """Whether a prim is a gprim for rendering: of purpose default or render."""
    return bool(prim.IsA(UsdGeom.Gprim)) and for_rendering(prim)


def for_rendering(prim: Any) -> bool:
    """Whether a prim's purpose is default or render, not guide or proxy."""
    return UsdGeom.Imageable(prim).ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def _local(prim: Any) -> Floats:
    if not prim.IsA(UsdGeom.Xformable):
        return np.eye(4)
    return transforms.from_usd(UsdGeom.Xformable(prim).GetLocalTransformation(EARLIEST))


def _matrices(instancer: Any, which: Integers, complain: Callable[[str], None]) -> Floats | None:
    """(n, 4, 4) translate . rotate . scale of every point; None if the arrays differ in length."""
    count = len(which)
    positions = array_of(instancer.GetPositionsAttr(), np.float64, 3)
    scales = array_of(instancer.GetScalesAttr(), np.float64, 3)
    turns = _quaternions(instancer.GetOrientationsfAttr())
    if not len(turns):
        turns = _quaternions(instancer.GetOrientationsAttr())
    if len(positions) != count or len(scales) not in (0, count) or len(turns) not in (0, count):
        complain(
            f"it has {count} prototype indices, {len(positions)} positions, {len(turns)} orientations and "
            f"{len(scales)} scales, which do not fit together; rays do not see it"
        )
        return None
    out = np.zeros((count, 4, 4))
    out[:, :3, :3] = np.eye(3)
    with np.errstate(invalid="ignore"):  # `copies_of` reports points that are not finite
        if len(turns):
            length = np.linalg.norm(turns, axis=1, keepdims=True)
            unit = np.where(length == 0, [1, 0, 0, 0], turns) / np.where(length == 0, 1, length)
            out[:, :3, :3] = transforms.rotation_matrices(unit)
        if len(scales):
            out[:, :3, :3] *= scales[:, None, :]
    out[:, :3, 3] = positions
    out[:, 3, 3] = 1
    return out


def _visible(instancer: Any, count: int, complain: Callable[[str], None]) -> NDArray[np.bool_]:
    ids = array_of(instancer.GetIdsAttr(), np.int64)
    if len(ids) not in (0, count):
        complain(f"it has {len(ids)} ids for {count} points; its points are numbered instead")
        ids = ids[:0]
    if not len(ids):
        ids = np.arange(count)
    off = array_of(instancer.GetInvisibleIdsAttr(), np.int64).tolist()
    inactive = instancer.GetPrim().GetMetadata("inactiveIds")
    if inactive is not None:
        off += list(inactive.GetAppliedItems())
    return np.asarray(~np.isin(ids, off))


def _quaternions(attribute: Any) -> Floats:
    """(n, 4) w, x, y, z; USD's arrays hold x, y, z, w."""
    return transforms.from_xyzw(array_of(attribute, np.float64, 4))
