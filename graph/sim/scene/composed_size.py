"""Counts the prims that composing a scene gives, from its layers, before anything is composed.

A scene of a few lines can ask for more prims than any machine holds: a prim that references another twice, which
references another twice, and so on for forty steps. A composed prim follows from its sites, the places in layer stacks
that describe it: arcs add sites, and the children of all sites merge by name. So the count below equal sites is equal,
and is computed once. Prims below instances count each time, because a traversal of the scene meets them each time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from typing import Any

from graph.base.limits import most

_ARCS = ("references", "payload", "inheritPaths", "specializes")
_DEEPEST = 500
"""Most nested prims; deeper nesting refers back to itself."""

Expressions = Mapping[tuple[str, str], Set[str]]
"""The paths that each variable expression evaluates to, by the layer that contains it."""

Site = tuple[str, str]
"""The identifier of the root layer of a stack, and a path in it."""


def too_many_prims(root: Any, expressions: Expressions | None = None) -> int:
    """The number of prims that a root layer (`Sdf.Layer`) would compose if it exceeds the limit usd.prims, else 0.

    Layers that are not open count as empty. In a variant set only the selected variant counts, or all of them without a
    selection, because another layer may select any.
    """
    count = _Count(expressions or {})
    count.stack(root)
    counted = count.below(((root.identifier, "/"),))
    return counted if counted > most("usd.prims") else 0


class _Count:
    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._known: dict[tuple[Site, ...], int] = {}
        self._stacks: dict[str, list[Any]] = {}
        self._layers: dict[str, Any] = {}
        self._reached: dict[Site, dict[Site, None]] = {}
        self._arcs_followed = 0

    def below(self, sites: tuple[Site, ...]) -> int:
        """The number of prims of the prim with these sites, itself included."""
        # Iterative: each frame is [sites, children still to add, sum so far].
        frames: list[tuple[tuple[Site, ...], Iterator[tuple[Site, ...]], list[int]]] = []
        limit = most("usd.prims")
        self._push(frames, sites)
        while frames:
            current, children, total = frames[-1]
            child = next(children, None)
            if child is None:
                frames.pop()
                self._known[current] = total[0]
                if frames:
                    frames[-1][2][0] += total[0]
            elif child in self._known:
                total[0] += self._known[child]
            elif len(frames) < _DEEPEST:
                self._push(frames, child)
            if total[0] > limit:  # a lower bound of the number
                return total[0]
        return self._known[sites]

    def _push(self, frames: list[Any], sites: tuple[Site, ...]) -> None:
        self._known[sites] = 1  # a reference back to itself composes nothing more
        frames.append((sites, self._children(sites), [1]))

    def _children(self, sites: tuple[Site, ...]) -> Iterator[tuple[Site, ...]]:
        """The sites of each child, once for each name."""
        by_name: dict[str, dict[Site, None]] = {}
        for identifier, path in self._with_arcs(sites):
            between = "" if path.endswith(("/", "}")) else "/"  # at the root, in a variant, or below a prim
            for spec in self._specs(identifier, path):
                names = spec.nameChildren.keys()  # the children themselves cost more
                for name in names:
                    by_name.setdefault(name, {})[identifier, f"{path}{between}{name}"] = None
        for found in by_name.values():
            yield tuple(found)

    def _with_arcs(self, sites: tuple[Site, ...]) -> Iterator[Site]:
        """The sites of a prim and those that its arcs and variants add, each once."""
        found = dict.fromkeys(sites)
        pending = list(sites)
        while pending:
            site = pending.pop()
            yield site
            for more in self._added_by(*site):
                if more not in found:
                    found[more] = None
                    pending.append(more)

    def _added_by(self, identifier: str, path: str) -> Iterator[Site]:
        if path == "/":
            return
        specs = [(spec, spec.ListInfoKeys()) for spec in self._specs(identifier, path)]
        selected: dict[str, str] = {}
        for spec, keys in specs:
            if "variantSelection" in keys:
                for name, choice in spec.variantSelections.items():
                    selected.setdefault(name, choice)
        for spec, keys in specs:
            for name, variants in spec.variantSets.items() if "variantSetNames" in keys else ():
                for choice, variant in variants.variants.items():
                    if selected.get(name, choice) == choice:
                        yield identifier, str(variant.primSpec.path)
            for arc in _ARCS:
                if arc in keys:
                    yield from self._named(identifier, spec.layer, spec.GetInfo(arc))

    def _named(self, identifier: str, author: Any, edits: Any) -> Iterator[Site]:
        for item in edits.GetAppliedItems():
            asset = getattr(item, "assetPath", "")
            path = str(getattr(item, "primPath", item))
            for target in self._open(author, asset) if asset else (self._layers[identifier],):
                self.stack(target)
                wanted = path or (f"/{target.defaultPrim}" if target.defaultPrim else "")
                if wanted:
                    yield from self._existing(target.identifier, wanted)

    def _existing(self, identifier: str, path: str) -> Iterable[Site]:
        """The site, and the sites that arcs of its ancestors add; a reference back to itself adds none."""
        site = identifier, path
        if site not in self._reached:
            self._reached[site] = found = {site: None}
            rest, above = "", path
            while above.count("/") > 1 and "{" not in above and self._arcs_followed < _DEEPEST // 5:
                above, _, name = above.rpartition("/")
                rest = f"/{name}{rest}"
                self._arcs_followed += 1
                found.update((((other, f"{there}{rest}"), None)) for other, there in self._added_by(identifier, above))
                self._arcs_followed -= 1
        return tuple(self._reached[site])

    def _specs(self, identifier: str, path: str) -> list[Any]:
        found = (one.pseudoRoot if path == "/" else one.GetPrimAtPath(path) for one in self._stacks[identifier])
        return [spec for spec in found if spec is not None]

    def _open(self, author: Any, asset: str) -> list[Any]:
        """The open layers that an asset path in a layer names: none, one, or several for an expression."""
        from graph.sim.usd import Sdf

        paths = self._expressions.get((author.identifier, asset))
        found = map(Sdf.Layer.Find, paths or (Sdf.ComputeAssetPathRelativeToLayer(author, asset),))
        return [layer for layer in found if layer is not None]

    def stack(self, layer: Any) -> None:
        """Adds a layer and its sublayers, each once."""
        if layer.identifier in self._stacks:
            return
        self._layers[layer.identifier] = layer
        found = {layer.identifier: layer}
        pending = [layer]
        while pending:
            one = pending.pop(0)
            for asset in one.subLayerPaths:
                for below in self._open(one, asset):
                    if below.identifier not in found:
                        found[below.identifier] = below
                        pending.append(below)
        self._stacks[layer.identifier] = list(found.values())
