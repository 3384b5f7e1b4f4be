"""The faces of meshes that this process met last, by their content: the next App with the same meshes takes them."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from .faces import Faces, Shape, faces_of

MOST_TOGETHER = 50_000
"""Triangles of meshes that are worked out together: their numbers stay in the cache."""

MOST_KEPT = 500_000
"""Triangles whose faces are kept for the next App with the same meshes."""


class _FacesByContent:
    """The faces of meshes that this process met last, by their content."""

    def __init__(self) -> None:
        self._found: OrderedDict[bytes, Faces] = OrderedDict()
        self._kept = 0

    def of(self, meshes: Sequence[Shape]) -> list[Faces]:
        """As `faces_of`."""
        keys = [_digest(*mesh) for mesh in meshes]
        found = {key: self._found.pop(key) for key in set(keys) & self._found.keys()}
        missing = {key: mesh for key, mesh in zip(keys, meshes, strict=True) if key not in found}
        for some in _batches(missing):
            found.update(zip(some, faces_of([missing[key] for key in some]), strict=True))
        self._kept += sum(len(triangles) for _, triangles in missing.values())
        self._found.update((key, found[key]) for key in keys)
        while self._kept > MOST_KEPT and self._found:
            self._kept -= len(self._found.popitem(last=False)[1].of_triangle)
        return [found[key] for key in keys]


def _digest(vertices: np.ndarray, triangles: np.ndarray) -> bytes:
    digest = hashlib.blake2b(np.ascontiguousarray(vertices).data, digest_size=32)
    digest.update(np.ascontiguousarray(triangles).data)
    return digest.digest()


def _batches(meshes: Mapping[bytes, Shape]) -> Iterator[list[bytes]]:
    """The keys of meshes, as many at a time as have `MOST_TOGETHER` triangles, or one."""
    some: list[bytes] = []
    count = 0
    for key, (_, triangles) in meshes.items():
        if some and count + len(triangles) > MOST_TOGETHER:
            yield some
            some, count = [], 0
        some.append(key)
        count += len(triangles)
    if some:
        yield some


FACES_BY_CONTENT = _FacesByContent()
