"""Edits of a stage between the request of a stop and the stop itself, which are those of a stopped world: they stay."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class LateEdits:
    """Notes what is edited on a stage from now on, at its edit target.

    `take` ends that and keeps the edits, `put_back` makes them again when the stage has been restored. Of a prim that
    was there before, only what was edited is written: its other values are the restored ones.
    """

    def __init__(self, stage: Any) -> None:
        from graph.sim.usd import Tf, Usd

        self._stage = stage
        self._paths: dict[Any, None] = {}
        self._kept: Any = None
        self._callback: Any = self._note  # USD holds it weakly
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._callback, stage)

    def _note(self, notice: Any, sender: Any) -> None:
        self._paths.update(dict.fromkeys((*notice.GetResyncedPaths(), *notice.GetChangedInfoOnlyPaths())))

    def take(self) -> None:
        """Ends the noting, and copies what was edited."""
        from graph.sim.usd import Sdf

        self._listener.Revoke()
        self._callback = None  # else this and its stage would wait for the garbage collector
        if self._paths:
            self._kept = Sdf.Layer.CreateAnonymous()
            self._kept.TransferContent(self._stage.GetEditTarget().GetLayer())

    @contextmanager
    def put_back(self) -> Iterator[None]:
        """Makes the edits at the end of a `with` block that restores the stage; prims that stay are never gone."""
        from graph.sim.usd import Sdf

        if not self._paths:
            yield
            return
        layer = self._stage.GetEditTarget().GetLayer()
        with Sdf.ChangeBlock():
            yield
            for path in sorted(self._paths):
                edited, there = self._kept.GetObjectAtPath(path), layer.GetObjectAtPath(path)
                if edited is None:
                    self._remove(there)
                elif there is None:
                    owner = path.GetPrimPath() if path.IsPropertyPath() else path.GetParentPath()
                    if owner != Sdf.Path.absoluteRootPath:
                        Sdf.CreatePrimInLayer(layer, owner)
                    Sdf.CopySpec(self._kept, path, layer, path)
                elif path.IsPropertyPath():
                    Sdf.CopySpec(self._kept, path, layer, path)
                else:
                    self._merge(edited, there)

    def _merge(self, edited: Any, there: Any) -> None:
        """The metadata of a prim, or of the layer, and what the prim has got below it."""
        from graph.sim.usd import Sdf

        for name in {*edited.ListInfoKeys(), *there.ListInfoKeys()}:
            if not edited.HasInfo(name):
                there.ClearInfo(name)
            elif not there.HasInfo(name) or there.GetInfo(name) != edited.GetInfo(name):
                there.SetInfo(name, edited.GetInfo(name))
        for child in _children(edited):
            if there.layer.GetObjectAtPath(child.path) is None:
                Sdf.CopySpec(edited.layer, child.path, there.layer, child.path)

    def _remove(self, there: Any) -> None:
        if there is None:
            return
        owner = there.layer.GetObjectAtPath(there.path.GetParentPath())
        if there.path.IsPropertyPath():
            owner.RemoveProperty(there)
        elif owner is not None:
            del owner.nameChildren[there.name]


def _children(spec: Any) -> Iterator[Any]:
    yield from spec.nameChildren
    if spec.path.IsPrimPath():
        yield from spec.properties
