"""What the lights of a stage leave dark, as far as their prims say; reading it loads nothing that makes pictures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .channels import LIT

if TYPE_CHECKING:
    from pxr import Usd

MODELLED = ("DistantLight", "SphereLight", "RectLight", "DiskLight", "CylinderLight")
"""The types of lights that shine here, beside domes."""
COLOURS = LIT | {"LdrColor", "rgba"}
"""The annotators that need light."""
NO_LIGHT = "no light shines: pictures are black; add a DistantLight or a DomeLight"


def not_modelled(kind: str) -> str:
    """What to know of a light of a type that does not shine here."""
    return f"a {kind} gives no light here; use a distant, dome, sphere or area light"


def darkness(stage: Usd.Stage, cameras: list[str]) -> Iterator[tuple[str, str, str]]:
    """Code, place and message of what is dark to cameras whose colours are used, before any picture."""
    from graph.sim.usd import Usd

    kinds = {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        kind = str(prim.GetTypeName())
        if kind.endswith("Light") or kind.startswith("DomeLight"):
            kinds[prim] = kind
    shines = False
    for prim, kind in kinds.items():
        if not _visible(prim):
            continue
        if kind in MODELLED or (kind.startswith("DomeLight") and _dome_shines(prim)):
            shines = True
        elif not kind.startswith("DomeLight"):
            yield "light-not-modelled", str(prim.GetPath()), not_modelled(kind)
    if not shines:
        for path in cameras:
            yield "no-light", path, NO_LIGHT


def _visible(prim: Usd.Prim) -> bool:
    from graph.sim.usd import UsdGeom

    imageable = UsdGeom.Imageable(prim)
    return not imageable or imageable.ComputeVisibility() != UsdGeom.Tokens.invisible


def _dome_shines(prim: Usd.Prim) -> bool:
    """Whether a dome without an image has an intensity; one with an image may shine, and so does a headlight."""
    values = {name: prim.GetAttribute(name) for name in ("inputs:intensity", "inputs:texture:file", "mjc:headlight")}
    given = {name: attribute.Get() for name, attribute in values.items() if attribute}
    image = given.get("inputs:texture:file")
    return given.get("inputs:intensity", 1.0) != 0 or bool(image and image.path) or bool(given.get("mjc:headlight"))
