"""Whether a render product shows the kind of sensor that a node publishes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.node import NodeAtLoad

if TYPE_CHECKING:
    from pxr import Usd

LEGACY_KIND = "cameraSensorType"
"""Attribute of the Camera prims that stood for lidars and radars up to Isaac Sim 4."""
LEGACY_KINDS = {"lidar": "OmniLidar", "radar": "OmniRadar"}
"""Its values -> the prim type that such sensors have since."""


def misfit(prim: Usd.Prim, path: str, needed: str) -> str | None:
    """Why the prim at a path is not a sensor of the prim type `needed`, as one line; None if it is one."""
    if not prim:
        return f"there is no prim {path or 'behind the render product'}; it must be of type {needed}"
    legacy = LEGACY_KINDS.get(str(prim.GetAttribute(LEGACY_KIND).Get() or "").lower())
    if legacy and prim.GetTypeName() == "Camera":
        return f"{path} is a Camera that stands for a sensor, as up to Isaac Sim 4 ({LEGACY_KIND}); make it an {legacy}"
    if prim.GetTypeName() != needed:
        return f"{path} is of type {prim.GetTypeName() or 'none'}; it must be of type {needed}"
    return None


def check_fit(node: NodeAtLoad, needed: str) -> Iterator[tuple[str, str]]:
    """What `misfit` says of the sensors behind a node's render product, before anything runs."""
    from graph.sim.scene.prim_paths import prim_at

    for path in node.sensors:
        prim = prim_at(node.stage, path)
        if prim and (problem := misfit(prim, path, needed)):
            yield "", f"nothing would be published: {problem}"
