"""Opens another scene, or an empty stage, in an App that is there: the graphs of the scene run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError

from .open import build_parts
from .runner import graphs_of

if TYPE_CHECKING:
    from graph.sim.app import App


def open_scene(app: App, path: str | Path, allow: Sequence[str | Path] = ()) -> None:
    """Opens a USD file in the App; what is wrong with its graphs is a warning, and they are left out.

    Raises UserError if the file cannot be opened; then the App keeps its stage.
    """
    parts = build_parts(path, allow=[Path(path).expanduser().absolute().parent, *allow], skip_unknown=True)
    if parts.stage is None:
        raise UserError(parts.problems or f"{path} cannot be opened")
    own_content(parts.stage)
    app.take_stage(parts.stage)
    for warning in parts.warnings:
        app.warn(*warning)
    for problem in parts.problems:
        app.warn("graph-left-out", str(problem.mark or path), problem.message)
    if not parts.problems:
        graphs = graphs_of(app)
        for graph in parts.graphs:
            graphs.add(graph)


def own_content(stage: Any) -> None:
    """Copies the scene's root layer into the stage's own: its prims can be removed, its metadata set; the file stays.

    References keep their files: relative paths become absolute ones. What the stage's own layer has, repairs of the
    scene, stays stronger.
    """
    from graph.sim.usd import Sdf, UsdUtils

    root = stage.GetRootLayer()
    if not root.anonymous or not root.subLayerPaths:
        return
    scene = Sdf.Layer.Find(root.subLayerPaths[0])
    if scene is None or scene.anonymous:
        return
    copy, own = Sdf.Layer.CreateAnonymous(), Sdf.Layer.CreateAnonymous()
    copy.TransferContent(scene)
    UsdUtils.ModifyAssetPaths(copy, lambda address: scene.ComputeAbsolutePath(address) if address else address)
    own.TransferContent(root)
    for name in ("subLayers", "subLayerOffsets"):  # the scene's take their place
        own.pseudoRoot.ClearInfo(name)
    UsdUtils.StitchLayers(own, copy)
    root.TransferContent(own)
