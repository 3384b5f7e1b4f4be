"""How many prims composing a scene would give, estimated from its layers before anything is composed.

A scene of a few lines can ask for more prims than any machine holds: a prim that references another twice, which
references another twice, and so on for forty steps. The estimate adds up, for every prim, its children and what its
arcs bring in: at most a few times too many.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

LEAST = 100_000
"""Prims that any scene may have."""
GROWTH = 20
"""Prims that a scene may have beyond that for each one that is written in its layers."""

_ARCS = ("references", "payload", "inheritPaths", "specializes")


Expressions = Mapping[tuple[str, str], Set[str]]
"""The paths that each variable expression comes to, by the layer that has it."""


def too_many_prims(root: Any, expressions: Expressions | None = None) -> int:
    """The number of prims that a root layer (`Sdf.Layer`) would compose if it is out of all proportion, else 0.

    Layers that are not open count nothing; prims that are instances of one prototype count once.
    """
    estimate = _Estimate(expressions or {})
    prims = estimate.of_stack(root, "/")
    return prims if prims > LEAST + GROWTH * estimate.written else 0


class _Estimate:
    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._known: dict[tuple[str, str], int] = {}
        self._stacks: dict[str, list[Any]] = {}
        self._prototypes: set[str] = set()

    @property
    def written(self) -> int:
        """How many prims of all layers were looked at."""
        return len(self._known)

    def of_stack(self, layer: Any, path: str) -> int:
        """The prims at and below a path of a layer and its sublayers."""
        key = (layer.identifier, path)
        # Iterative: each frame is [key, arcs and children still to add, sum so far].
        frames: list[tuple[tuple[str, str], Iterator[tuple[Any, str]], list[int]]] = []
        self._push(frames, key, layer, path)
        while frames:
            current, parts, total = frames[-1]
            part = next(parts, None)
            if part is None:
                frames.pop()
                self._known[current] = total[0]
                if frames:
                    frames[-1][2][0] += self._known[current]
                continue
            inner = (part[0].identifier, part[1])
            if inner in self._known:
                total[0] += self._known[inner]
            else:
                self._push(frames, inner, *part)
        return self._known[key]

    def _push(self, frames: list[Any], key: tuple[str, str], layer: Any, path: str) -> None:
        self._known[key] = 1  # what leads back to itself composes nothing more
        frames.append((key, self._parts(layer, path), [1]))

    def _parts(self, layer: Any, path: str) -> Iterator[tuple[Any, str]]:
        """The (layer, path) of every child of a prim and of everything its arcs name."""
        for one in self._stack(layer):
            spec = one.pseudoRoot if path == "/" else one.GetPrimAtPath(path)
            if spec is None:
                continue
            yield from ((layer, str(child.path)) for child in spec.nameChildren)
            for variant_set in spec.variantSets.values() if path != "/" else ():
                yield from ((layer, str(variant.primSpec.path)) for variant in variant_set.variants.values())
            for arc in _ARCS:
                if spec.HasInfo(arc) and not self._shared(spec, arc):
                    yield from self._named(layer, one, spec.GetInfo(arc))

    def _shared(self, spec: Any, arc: str) -> bool:
        """Whether this is another instance of a prototype that has been counted."""
        if not spec.HasInfo("instanceable") or not spec.instanceable:
            return False
        prototype = f"{arc} {spec.GetInfo(arc)}"
        known = prototype in self._prototypes
        self._prototypes.add(prototype)
        return known

    def _named(self, layer: Any, author: Any, edits: Any) -> Iterator[tuple[Any, str]]:
        for item in edits.GetAppliedItems():
            asset = getattr(item, "assetPath", "")
            path = getattr(item, "primPath", item)
            for target in self._open(author, asset) if asset else (layer,):
                wanted = str(path) or f"/{target.defaultPrim}"
                yield target, self._existing(target, wanted)

    def _open(self, author: Any, asset: str) -> list[Any]:
        """The open layers that an asset path in a layer names: one, or several if it is an expression, or none."""
        from graph.sim.usd import Sdf

        paths = self._expressions.get((author.identifier, asset))
        found = map(Sdf.Layer.Find, paths or (Sdf.ComputeAssetPathRelativeToLayer(author, asset),))
        return [layer for layer in found if layer is not None]

    def _existing(self, layer: Any, path: str) -> str:
        """The path, or its nearest parent that a layer says something of: what is below comes with that one's arcs."""
        while len(path) > 1 and not any(one.GetPrimAtPath(path) for one in self._stack(layer)):
            path = path.rpartition("/")[0] or "/"
        return path

    def _stack(self, layer: Any) -> list[Any]:
        """A layer and its sublayers, each once."""
        if layer.identifier not in self._stacks:
            found = {layer.identifier: layer}
            pending = [layer]
            while pending:
                one = pending.pop()
                for asset in one.subLayerPaths:
                    for below in self._open(one, asset):
                        if below.identifier not in found:
                            found[below.identifier] = below
                            pending.append(below)
            self._stacks[layer.identifier] = list(found.values())
        return self._stacks[layer.identifier]
