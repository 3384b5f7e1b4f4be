"""What stands for an address in a scene (`omniverse://...`, `/Isaac/...`): a mapped file or a stand-in."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any

from graph.base import asset_roots
from graph.base.plugins import ASSETS, names, required, shipped
from graph.base.records import dataclass

MOST_NAMED = 3
"""Most prims that a message names."""


@dataclass(frozen=True, slots=True)
class StandIn:
    """A layer of ours in the place of an asset that is not here; what: its content in words."""

    layer: Any
    what: str
    exact: bool = False
    """Whether nothing differs that sensors or physics notice: a built-in sensor configuration."""

    @classmethod
    def of(cls, stage: Any, what: str, *, exact: bool = False) -> StandIn:
        """The stand-in that a stage in memory describes. The layer outlives the stage."""
        from graph.sim.usd import Sdf

        root = stage.GetRootLayer()
        layer = Sdf.Layer.CreateAnonymous(root.GetDisplayName())
        layer.TransferContent(root)
        return cls(layer, what, exact)

    def note(self) -> tuple[str, str]:
        """Code and message of the warning that it takes the place of an asset."""
        return "asset-built-in" if self.exact else "asset-stand-in", f"it is not downloaded; in its place: {self.what}"


def may_be_elsewhere(asset: str) -> bool:
    """Whether an asset path may stand for another file: an address, an asset of Isaac Sim, or of a mapped prefix."""
    return asset_roots.is_address(asset) or "Isaac/" in asset or any(map(asset.startswith, asset_roots.present()))


def mapped(asset: str) -> Path | None:
    """The existing file that an asset path stands for by the asset roots, or None.

    Raises ValueError for a path that leads out of its asset root.
    """
    file = asset_roots.local_file(asset)
    return file if file is not None and file.is_file() else None


def stand_in(asset: str) -> StandIn | None:
    """The layer that takes the place of a known asset; None for other assets and for files that are here."""
    _, found, tail = f"/{asset}".rpartition("/Isaac/")
    return _stand_in(f"{found}{tail}") if found and not Path(asset).is_file() else None


@functools.cache
def _stand_in(tail: str) -> StandIn | None:
    return next(filter(None, (make(tail) for make in _makers(tail))), None)


def _makers(tail: str) -> Iterator[Callable[[str], StandIn | None]]:
    """Of our own that for the innermost folder with the asset, then those of other packages."""
    own = shipped(ASSETS)
    yield required(ASSETS, max((one for one in own if tail.startswith(f"/{one}/")), key=len), FunctionType, "stand-in")
    for name in names(ASSETS):
        if name not in own:
            yield required(ASSETS, name, FunctionType, "stand-in")


def looked_for(asset: str, folder: Path) -> str:
    """The place at which a missing asset is looked for: its file, or the option that gives an address one."""
    try:
        if file := asset_roots.local_file(asset):
            return str(file)
    except ValueError as error:  # it leads out of its asset root
        return str(error)
    if not asset_roots.names_asset(asset):
        return str(folder / asset)
    return f"--asset-root {_prefix(asset)}=DIR"


def _prefix(asset: str) -> str:
    """The part of an address that an asset root stands for, as a rule."""
    head, found, _ = asset.rpartition("/Isaac/")
    return (head or "/Isaac") if found else asset.rpartition("/")[0]


def not_here(asset: str) -> str:
    """The sentence about an asset that is missing; for an address also how to map it."""
    if not asset_roots.is_address(asset):
        return f"{asset} does not exist"
    name = asset.rpartition("/")[2]
    return f"{name} is not downloaded ({asset}; give its folder with --asset-root {_prefix(asset)}=DIR)"


def emptied(layer: Any, asset: str) -> str:
    """The prims of a layer that stay empty without an asset that they name; "" if it is a sublayer or a texture."""
    found: list[str] = []

    def visit(path: Any) -> None:
        spec = layer.GetPrimAtPath(path) if path.IsPrimPath() and len(found) < MOST_NAMED else None
        if spec is not None:
            arcs = (*spec.referenceList.GetAddedOrExplicitItems(), *spec.payloadList.GetAddedOrExplicitItems())
            found.extend([str(path)] if any(arc.assetPath == asset for arc in arcs) else [])

    layer.Traverse("/", visit)
    return f"so that {' and '.join(found)} {'stays' if len(found) == 1 else 'stay'} empty" if found else ""


def missing_above(stage: Any, path: str) -> str:
    """The asset that is missing at or above a prim path, as a sentence without a full stop; "" if all are here."""
    from graph.sim.usd import Ar, Sdf

    parent = Sdf.Path(path) if Sdf.Path.IsValidPathString(path) else Sdf.Path.emptyPath
    while parent.IsAbsolutePath() and parent != Sdf.Path.absoluteRootPath:  # a relative one has parents without end
        prim = stage.GetPrimAtPath(parent)
        for spec in prim.GetPrimStack() if prim else ():
            for listed in (spec.referenceList, spec.payloadList):
                for arc in listed.GetAddedOrExplicitItems():
                    asset = arc.assetPath
                    if asset and not Sdf.Layer.IsAnonymousLayerIdentifier(asset):
                        place = Sdf.ComputeAssetPathRelativeToLayer(spec.layer, asset)
                        if not Ar.GetResolver().Resolve(place):
                            return f"{parent} is empty because {not_here(asset)}"
        parent = parent.GetParentPath()
    return ""
