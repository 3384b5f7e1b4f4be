"""The files that composing one layer opens, by their asset paths."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from typing import Any

from graph.base import limits
from graph.base.errors import UserError
from graph.base.records import dataclass

_NAMING = ("references", "payload")
_ARCS = (*_NAMING, "inheritPaths", "specializes")


@dataclass(frozen=True, slots=True)
class LayerContents:
    """The layers that composing a layer opens: asset paths as written, by whether they are sublayers (one may be
    both).
    """

    sublayers: Iterable[str] = ()
    others: Iterable[str] = ()
    arcs: bool = False
    """Whether any of its prims has a composition arc."""
    clips: Container[str] = ()
    """The asset paths that value clips name."""


def contents_of(layer: Any, composes: bool = True) -> LayerContents:
    """What composing the layer opens: sublayers, references, payloads (in variants too) and value clips.

    composes: whether it may open anything. Raises OverLimit beyond the limit usd.specs, and UserError for a damaged
    layer that names prims of which it says nothing: composing them ends the process.
    """
    sublayers = dict.fromkeys(layer.subLayerPaths)
    others: dict[str, None] = {}
    get, arcs = layer.GetPrimAtPath, False
    clips: set[str] = set()
    left = limits.most("usd.specs")

    def visit(path: Any) -> None:
        nonlocal arcs, left
        left -= 1
        if left < 0:
            said = f"{layer.identifier} has too many prims and properties"
            raise limits.OverLimit(f"{said}; {limits.allowed('usd.specs')}")
        if not composes:
            return
        if path.IsPrimPath() or path.IsPrimVariantSelectionPath():
            spec = get(path)
            if spec is None:
                if path.IsPrimPath():
                    raise UserError(f"{layer.identifier} names the prim {path} and says nothing of it; repair the file")
                return
            if spec.HasInfo("clips"):
                clips.update(_clip_assets(spec.GetInfo("clips")))
            arcs = arcs or any(map(spec.HasInfo, _ARCS))
            for arc in _NAMING if sublayers else ():
                if spec.HasInfo(arc):
                    others.update(dict.fromkeys(item.assetPath for item in spec.GetInfo(arc).GetAppliedItems()))

    layer.Traverse("/", visit)
    if not composes:
        return LayerContents()
    assets = dict.fromkeys(asset for asset in layer.GetCompositionAssetDependencies() if asset not in sublayers)
    others = {**assets, **others, **dict.fromkeys(sorted(clips))}
    return LayerContents(sublayers, others, arcs, clips)


def _clip_assets(value: Any) -> Iterator[str]:
    """Every asset path in a prim's `clips`; a template (`clip.###.usd`) gives the files that match it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from (inner,) if key == "templateAssetPath" and isinstance(inner, str) else _clip_assets(inner)
    elif hasattr(value, "path"):
        yield value.path
    elif not isinstance(value, (str, bytes, int, float)) and hasattr(value, "__iter__"):
        for inner in value:
            yield from _clip_assets(inner)
