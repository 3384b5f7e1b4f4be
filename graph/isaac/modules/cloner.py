"""`isaacsim.core.cloner`: copies of a prim, side by side."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.results import array
from graph.sim.usd import Sdf

from .stage import usd_stage
from .usd import duplicate_prim
from .xforms import put

__all__ = ["Cloner", "GridCloner"]
IDENTITY = [1.0, 0.0, 0.0, 0.0]


class Cloner:
    def __init__(self, stage: Any = None) -> None:
        self._stage = stage or usd_stage()

    def define_base_env(self, base_env_path: str) -> None:
        self._stage.DefinePrim(base_env_path, "Xform")

    def generate_paths(self, root_path: str, num_paths: int) -> list[str]:
        return [f"{root_path}_{number}" for number in range(num_paths)]

    def disable_change_listener(self) -> None:
        """What follows the stage here costs little while prims are made."""

    enable_change_listener = disable_change_listener

    def clone(
        self,
        source_prim_path: str,
        prim_paths: list[str],
        positions: Any = None,
        orientations: Any = None,
        replicate_physics: bool = False,
        base_env_path: str | None = None,
        root_path: str | None = None,
        copy_from_source: bool = False,
        unregister_physics_replication: bool = False,
        enable_env_ids: bool = False,
        clone_in_fabric: bool = False,
    ) -> None:
        """Makes prims that inherit the source, or copies of it, at local places; physics reads each for itself.

        Raises TypeError or ValueError for a malformed or missing source, and for numbers that do not fit.
        """
        self.disable_change_listener()
        try:
            self._check(source_prim_path, len(prim_paths), positions=positions, orientations=orientations)
            places = np.zeros((len(prim_paths), 3)) if positions is None else array(positions, float)
            turns = [IDENTITY] * len(prim_paths) if orientations is None else array(orientations, float)
            for path, place, turn in zip(prim_paths, places, turns, strict=True):
                self._make(source_prim_path, str(path), copied=copy_from_source)
                if positions is not None or str(path) != source_prim_path:
                    put(self._stage.GetPrimAtPath(str(path)), translation=place, orientation=turn)
        finally:
            self.enable_change_listener()

    def _check(self, source: Any, count: int, **rows: Any) -> None:
        if not isinstance(source, str):
            raise TypeError(f"source_prim_path is the path of a prim, not {source!r}")
        if not Sdf.Path.IsValidPathString(source):
            raise ValueError(f"source_prim_path {source!r} is not a valid SdfPath")
        if not self._stage.GetPrimAtPath(source):
            raise ValueError(f"source_prim_path: there is no prim {source}")
        for name, given in rows.items():
            if given is not None and len(given) != count:
                raise ValueError(f"{name} has {len(given)} rows; there are {count} prim_paths")

    def _make(self, source: str, path: str, *, copied: bool) -> None:
        if path == source:
            return
        parent = Sdf.Path(path).GetParentPath()
        if not self._stage.GetPrimAtPath(parent):
            self._stage.DefinePrim(parent, "Xform")
        if copied:
            duplicate_prim(self._stage, source, path)
        elif not self._stage.GetPrimAtPath(path):
            kind = self._stage.GetPrimAtPath(source).GetTypeName()
            self._stage.DefinePrim(path, kind).GetInherits().AddInherit(source)

    @inert("isaacsim.core.cloner")
    def filter_collisions(self, *_: Any, **__: Any) -> None: ...


class GridCloner(Cloner):
    def __init__(self, spacing: float, num_per_row: int = -1, stage: Any = None) -> None:
        super().__init__(stage)
        self._spacing, self._per_row = spacing, num_per_row

    def get_clone_transforms(
        self, num_clones: int, position_offsets: Any = None, orientation_offsets: Any = None
    ) -> tuple[list[Any], list[Any]]:
        """Places of a grid about the origin, row after row, and quaternions w, x, y, z."""
        if not num_clones:
            return [], []
        columns = self._per_row if self._per_row > 0 else int(np.ceil(np.sqrt(num_clones)))
        rows = int(np.ceil(num_clones / columns))
        row, column = np.divmod(np.arange(num_clones), columns)
        places = np.zeros((num_clones, 3)) if position_offsets is None else array(position_offsets, float).copy()
        places[:, 0] += (0.5 * (rows - 1) - row) * self._spacing
        places[:, 1] += (column - 0.5 * (columns - 1)) * self._spacing
        turns = (
            [list(IDENTITY)] * num_clones if orientation_offsets is None else array(orientation_offsets, float).tolist()
        )
        return places.tolist(), turns

    def clone(  # type: ignore[override]
        self,
        source_prim_path: str,
        prim_paths: list[str],
        position_offsets: Any = None,
        orientation_offsets: Any = None,
        replicate_physics: bool = False,
        base_env_path: str | None = None,
        root_path: str | None = None,
        copy_from_source: bool = False,
        enable_env_ids: bool = False,
        clone_in_fabric: bool = False,
    ) -> list[Any]:
        places, turns = self.get_clone_transforms(len(prim_paths), position_offsets, orientation_offsets)
        super().clone(source_prim_path, prim_paths, places, turns, copy_from_source=copy_from_source)
        return places
