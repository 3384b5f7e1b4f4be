"""Saving an opened file: its content is in a layer of memory, and `Save` of that writes the file, as in Kit.

Stages of scripts have a copy of the file that they open (`graph.session.restage`), so that nothing reaches it by
mistake. A script that calls `stage.GetRootLayer().Save()` or `stage.Save()` asks for it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

_ORIGINAL: list[tuple[Any, Any]] = []
"""The classes whose `Save` is ours now, and their own."""
_FILES: dict[str, tuple[Any, Path]] = {}
"""By identifier of a root layer in memory, its stage and the file that it came from."""


def opened(stage: Any, file: str | Path) -> None:
    """Declares a stage as that of a file: `Save` of its layers writes it until `end`."""
    from graph.sim.usd import Sdf, Usd

    if not _ORIGINAL:
        _ORIGINAL.extend((kind, kind.Save) for kind in (Sdf.Layer, Usd.Stage))
        Sdf.Layer.Save, Usd.Stage.Save = _save_layer, _save_stage
    _FILES[stage.GetRootLayer().identifier] = stage, Path(file).expanduser().absolute()


def end() -> None:
    """Gives USD's classes their own `Save` again; forgets the files."""
    while _ORIGINAL:
        kind, own = _ORIGINAL.pop()
        kind.Save = own
    _FILES.clear()


def _save_layer(layer: Any, force: bool = False) -> bool:
    if layer.identifier in _FILES:
        write(*_FILES[layer.identifier])
        return True
    return bool(_ORIGINAL[0][1](layer, force))


def _save_stage(stage: Any) -> None:
    root = stage.GetRootLayer()
    if root.identifier not in _FILES:
        _ORIGINAL[1][1](stage)
        return
    write(*_FILES[root.identifier])
    for layer in stage.GetUsedLayers():
        if layer.dirty and not layer.anonymous:
            _ORIGINAL[0][1](layer, False)


def write(stage: Any, file: Path) -> None:
    """Writes the root layer of a stage. References stay, relative where they can be.

    A stage that refers to stand-ins is written flattened. Raises OSError, and UserError for a link in the file's place.
    """
    from graph.base.outputs import check_no_link
    from graph.sim.usd import Sdf, UsdUtils

    file = file.absolute()
    own = Sdf.Layer.CreateAnonymous(file.name)
    own.TransferContent(stage.GetRootLayer())
    stand_ins: list[str] = []

    def relative(address: str) -> str:
        if address.startswith("anon:"):
            stand_ins.append(address)
        path = Path(address)
        return f"./{path.relative_to(file.parent)}" if path.is_relative_to(file.parent) else address

    UsdUtils.ModifyAssetPaths(own, relative)
    check_no_link(file)
    if not (stage.Flatten() if stand_ins else own).Export(str(file)):
        raise OSError(f"{file}: USD cannot write this file")
