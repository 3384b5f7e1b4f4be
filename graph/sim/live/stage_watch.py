"""Watches what is written to the stage while playing, and sorts it by its effect on the world."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable
from typing import Any

from graph.sim.state.prim_poses import PrimPoses
from graph.sim.usd import Sdf, Tf, Usd, UsdShade

from .roles import StageRoles, role_of

SHAPE = frozenset(
    (
        "size",
        "radius",
        "radiusTop",
        "radiusBottom",
        "height",
        "axis",
        "width",
        "length",
        "points",
        "faceVertexCounts",
        "faceVertexIndices",
        "holeIndices",
        "orientation",
        "subdivisionScheme",
        "widths",
        "curveVertexCounts",
        "knots",
        "order",
        "basis",
        "type",
        "wrap",
        "positions",
        "orientations",
        "orientationsf",
        "scales",
        "protoIndices",
        "prototypes",
        "invisibleIds",
    )
)
"""Attributes of surfaces that physics and rays read at play."""

LOOKS = ("visibility", "purpose", "material:binding", "semantics:", "semantic:", "primvars:", "normals")
"""Prefixes of properties that only rays read; they take effect in the next scan."""

PROTOTYPE = "/__Prototype"
"""Prefix of the paths that native instances share."""

_VALUES = frozenset(("default", "timeSamples", "targetPaths", "spline"))


class StageWatch:
    """Collects the edits of a stage from its creation until `close`.

    placed: called at once with the path of each prim whose transform was written, and whether its pose was (not only
    its scale, or the order of its ops). `structure` holds prims below which prims were added, removed or changed in
    kind, `shapes` the written attributes of surfaces, and `physics` those of dynamics; `looks` is whether rays may see
    something else, `others` the prims with any other written attribute: sensors read theirs again. What physics writes
    itself (`fabric.muted`) is not reported.
    """

    def __init__(self, stage: Any, fabric: PrimPoses, roles: StageRoles, placed: Callable[[str, bool], None]) -> None:
        self.stage, self.fabric, self.roles, self._placed = stage, fabric, roles, placed
        self.structure: dict[str, None] = {}
        self.shapes: dict[str, None] = {}
        self.physics: dict[str, None] = {}
        self.looks = False
        self.others: set[str] = set()
        self.resynced: set[str] = set()
        """Prims below which prims may have been added, removed or replaced, not yet told to sensors."""
        self.collecting = False
        """Whether transforms are collected in `transforms` until they are read."""
        self.transforms: dict[str, bool] = {}
        self.touched: set[str] = set()
        """Prims below which something was written since the last `clear`, handled or not."""
        self.edits = 0
        """Counts the notices of edits: what was read from the stage is as it was while this is."""
        self.failure: BaseException | None = None
        """An error that could not be raised where it occurred."""
        self._callback = _weak(self)
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._callback, stage)

    @property
    def pending(self) -> bool:
        """Whether there are edits to handle before the next update."""
        return bool(self.structure or self.shapes or self.physics or self.failure)

    def take_changed(self, paths: Iterable[str]) -> bool:
        """Whether any of these prims has other attributes, or is another or gone, since the last call."""
        above = tuple(f"{path.rstrip('/')}/" for path in self.resynced)
        changed = any(path in self.others or f"{path}/".startswith(above) for path in paths)
        self.others.clear()
        self.resynced.clear()
        return changed

    def clear(self) -> None:
        """Marks all edits as handled."""
        for found in (self.structure, self.shapes, self.physics, self.transforms, self.touched):
            found.clear()
        self.looks, self.failure = False, None

    def close(self) -> None:
        """Stops watching."""
        self._listener.Revoke()
        self._placed = _nobody

    def notice(self, notice: Any) -> None:
        """Handles one notice of USD."""
        if self.fabric.muted:
            return
        self.edits += 1
        moved: dict[str, bool] = {}
        for path in notice.GetResyncedPaths():
            if not path.IsPropertyPath():
                self.structure[path.pathString] = None
                self.resynced.add(path.pathString)
                self.touched.add(path.pathString)
            elif _VALUES.intersection(notice.GetChangedFields(path)) or not self.stage.GetObjectAtPath(path):
                self._property(path, moved)
        for path in notice.GetChangedInfoOnlyPaths():
            if path.IsPropertyPath() and _VALUES.intersection(notice.GetChangedFields(path)):
                self._property(path, moved)
        self.touched.update(moved)
        if self.collecting:
            for path, surely in moved.items():
                self.transforms[path] = surely or self.transforms.get(path, False)
            return
        for path, surely in moved.items():
            try:
                self._placed(path, surely)
            except Exception as error:  # an exception would be lost inside USD
                self.failure = self.failure or error

    def _property(self, path: Any, moved: dict[str, bool]) -> None:
        name, prim = path.name, path.GetPrimPath().pathString
        if prim.startswith(PROTOTYPE):
            if name.startswith("xformOp") or name in SHAPE:
                self.shapes[path.pathString] = None
        elif name.startswith("xformOp"):
            moved[prim] = moved.get(prim, False) or not name.startswith(("xformOp:scale", "xformOpOrder"))
        elif name in SHAPE and prim in self.roles.roles:
            self.shapes[path.pathString] = None
        elif name.startswith(LOOKS) or self._is_material(path):
            self.looks = True
        elif name.startswith(("physics:", "physx", "drive:", "limit:", "mjc:", "newton:")):
            if prim in self.roles.roles and self.stage.GetPrimAtPath(prim):
                self.physics[path.pathString] = None
        elif not self.stage.GetRelationshipAtPath(path):
            self.others.add(prim)

    def _is_material(self, path: Sdf.Path) -> bool:
        prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        return bool(prim and (prim.IsA(UsdShade.Material) or prim.IsA(UsdShade.NodeGraph) or prim.IsA(UsdShade.Shader)))


def describe(stage: Any, roles: StageRoles, structure: list[str]) -> tuple[list[str], set[str]]:
    """A description of the added, removed and changed prims below some prims, and all their paths."""
    words: list[str] = []
    paths: set[str] = set()
    for root in structure:
        new, gone, other = ([path for path in found if path not in paths] for found in roles.changed(root))
        paths.update(new, gone, other)
        words += [f"{path} ({role_of(stage.GetPrimAtPath(path)).strip()}) was added" for path in new]
        words += [f"{path} ({roles.roles[path].strip()}) was removed" for path in gone]
        words += [
            f"{path} was {roles.roles[path].strip()} and is {role_of(stage.GetPrimAtPath(path)).strip()}"
            for path in other
        ]
    return words, paths


def _nobody(path: str, surely: bool) -> None:
    """Ignores a transform."""


def _weak(watch: StageWatch) -> Callable[[Any, Any], None]:
    alive = weakref.ref(watch)

    def changed(notice: Any, sender: Any) -> None:
        found = alive()
        if found is not None:
            found.notice(notice)

    return changed
