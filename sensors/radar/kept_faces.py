"""The faces of meshes that this process met last, by their content: the next App with the same meshes takes them."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from graph.sim.geometry.surfaces import Mesh

from .faces import Faces, faces_of

MOST_TOGETHER = 50_000
"""Triangles of meshes that are worked out together: their numbers stay in the cache."""

MOST_KEPT = 500_000
"""Triangles whose faces are kept for the next App with the same meshes."""


class _FacesByContent:
    """The faces of meshes that this process met last, by their content."""

    def __init__(self) -> None:
        self._found: OrderedDict[bytes, Faces] = OrderedDict()
        self._kept = 0

    def of(self, meshes: Sequence[Mesh]) -> list[Faces]:
        """As `faces_of`."""
        keys = [mesh.unique_key for mesh in meshes]
        found = {key: self._found.pop(key) for key in set(keys) & self._found.keys()}
        missing = {key: mesh for key, mesh in zip(keys, meshes, strict=True) if key not in found}
        for some in _batches(missing):
            shapes = [(np.asarray(one.vertices, np.float64), one.triangles.astype(np.int64)) for one in some.values()]
            found.update(zip(some, faces_of(shapes), strict=True))
        self._kept += sum(len(mesh.triangles) for mesh in missing.values())
        self._found.update((key, found[key]) for key in keys)
        while self._kept > MOST_KEPT and self._found:
            self._kept -= len(self._found.popitem(last=False)[1].of_triangle)
        return [found[key] for key in keys]


def _batches(meshes: Mapping[bytes, Mesh]) -> Iterator[dict[bytes, Mesh]]:
    """Meshes by their keys, as many at a time as have `MOST_TOGETHER` triangles, or one."""
    some: dict[bytes, Mesh] = {}
    count = 0
    for key, mesh in meshes.items():
        if some and count + len(mesh.triangles) > MOST_TOGETHER:
            yield some
            some, count = {}, 0
        some[key] = mesh
        count += len(mesh.triangles)
    if some:
        yield some


FACES_BY_CONTENT = _FacesByContent()
