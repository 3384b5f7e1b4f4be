"""The faces of a mesh's arrays, and which of them are valid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from graph.base.limits import allowed, most
from graph.base.records import dataclass
from graph.sim.transforms import Floats

Integers = NDArray[np.int64]
Complain = Callable[[str], None]


@dataclass(frozen=True)
class Polygons:
    """Corners per face (at least 3), the points of all faces in order, and each face's number in the source."""

    counts: Integers
    corners: Integers
    source: Integers

    def only(self, keep: NDArray[np.bool_]) -> Polygons:
        """Some of the faces."""
        if keep.all():
            return self
        corners = self.corners[np.repeat(keep, self.counts)]
        return Polygons(self.counts[keep], corners, self.source[keep])


def usable_faces(points: Floats, counts: Integers, indices: Integers, complain: Complain) -> Polygons:
    """The faces except those with fewer than 3 corners, or with points that do not exist or are not finite.

    Each kind is reported to `complain` once, with a count.
    """
    counts = counts.astype(np.int64, copy=False)
    indices = indices.astype(np.int64, copy=False)
    counts, total = _fitting(counts, len(indices), complain)
    indices = indices[:total]
    large = counts > most("mesh.corners")
    if large.any():
        complain(f"{int(large.sum())} faces have too many corners and are left out; {allowed('mesh.corners')}")
    usable = counts >= 3
    if not usable.all():
        complain(f"{int((~usable).sum())} faces have fewer than 3 corners; they are left out")
    usable &= ~large
    missing = np.asarray((indices < 0) | (indices >= len(points)))
    bad = [(missing, "points that do not exist")]
    strange = np.asarray(~np.isfinite(points).all(axis=1))
    if strange.any():
        bad.append((strange[np.clip(indices, 0, len(points) - 1)] & ~missing, "points that are not finite"))
    for corners, what in bad:
        if corners.any():
            faces = np.zeros(len(counts), bool)
            faces[np.repeat(np.arange(len(counts)), counts)[corners]] = True
            usable &= ~faces
            complain(f"{int(faces.sum())} faces have {what}; they are left out")
    return Polygons(counts, indices, np.arange(len(counts))).only(usable)


def _fitting(counts: Integers, available: int, complain: Complain) -> tuple[Integers, int]:
    if (counts < 0).any():
        complain("faceVertexCounts holds negative numbers; those faces are left out")
        counts = np.maximum(counts, 0)
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    if total > available:
        fit = int(np.searchsorted(ends, available, side="right"))
        complain(
            f"faceVertexCounts asks for {total} indices, there are {available}; {len(counts) - fit} faces are left out"
        )
        counts = counts[:fit]
        total = int(ends[fit - 1]) if fit else 0
    elif total < available:
        complain(f"faceVertexCounts asks for {total} indices, there are {available}; those left over are ignored")
    return counts, total
