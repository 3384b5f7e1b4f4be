"""The prims that physics and sensors have read at play, with their roles and poses, to find what an edit changes."""

from __future__ import annotations

import copy
from bisect import bisect_left
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.scene.scan import GRIPPER
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Tf, Usd, UsdGeom, UsdPhysics

RESCALED = 1e-9
"""Least relative change of a prim's size that counts as a change."""


class StageRoles:
    """Path -> role of every prim that has one, and the poses of all prims: a copy of one moment.

    A role is the type of a surface, joint, gripper or physics scene, with the physics schemas applied to the prim.
    """

    def __init__(self, stage: Any) -> None:
        self._stage = stage
        self.roles: dict[str, str] = {}
        self._places: dict[str, Any] = {}
        self._read(stage.Traverse(Usd.TraverseInstanceProxies()))

    def renew(self, touched: Iterable[str]) -> StageRoles:
        """The present roles, if only the prims at and below some paths may have changed since these were read."""
        stage, changed = self._stage, sorted(touched)
        if any(path == "/" or path.startswith("/__Prototype") for path in changed):  # shared by all its instances
            return StageRoles(stage)
        roots: list[str] = []
        for path in changed:
            if not roots or not path.startswith(f"{roots[-1]}/"):
                roots.append(path)
        out = copy.copy(self)
        below = tuple(f"{root}/" for root in roots)
        gone = frozenset(roots)
        out.roles = {path: role for path, role in self.roles.items() if path not in gone and not path.startswith(below)}
        out._places = {path: at for path, at in self._places.items() if path not in gone and not path.startswith(below)}
        for root in roots:
            prim = stage.GetPrimAtPath(root)
            if prim and _seen(prim):
                out._read(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
        return out

    def _read(self, prims: Iterable[Any]) -> None:
        place = UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform
        for prim in prims:
            path = prim.GetPath().pathString
            self._places[path] = place(prim)
            role = role_of(prim)
            if role:
                self.roles[path] = role
        self._sorted = sorted(self.roles)

    @property
    def paths(self) -> frozenset[str]:
        """The paths of all recorded prims, with a role or without."""
        return frozenset(self._places)

    def pose(self, path: str, meters_per_unit: float) -> Floats:
        """(4, 4) rigid pose that a prim had [m]."""
        out = transforms.rigid_part(transforms.from_usd(self._places[path]))
        out[:3, 3] *= meters_per_unit
        return out

    def under(self, path: str) -> list[str]:
        """Paths with a role, at and below a path."""
        if path == "/":
            return self._sorted
        first, end = bisect_left(self._sorted, f"{path}/"), bisect_left(self._sorted, f"{path}0")
        return [path] * (path in self.roles) + self._sorted[first:end]

    def changed(self, path: str) -> tuple[list[str], list[str], list[str]]:
        """The present state at and below a path: prims with a role that are new, removed, or have another role."""
        now = {}
        prim = self._stage.GetPrimAtPath(path)
        if prim and _seen(prim):
            for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
                role = role_of(each)
                if role:
                    now[each.GetPath().pathString] = role
        before = self.under(path)
        return (
            [each for each in now if each not in self.roles],
            [each for each in before if each not in now],
            [each for each in before if each in now and now[each] != self.roles[each]],
        )

    def finite(self, path: str) -> bool:
        """Whether the transform of a prim in the world consists of finite numbers."""
        matrix = UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(self._stage.GetPrimAtPath(path))
        return bool(np.isfinite(transforms.from_usd(matrix)).all())

    def rescaled(self, path: str) -> bool:
        """Whether a prim has another scale or shear in the world than before, in whatever pose."""
        before, prim = self._places.get(path), self._stage.GetPrimAtPath(path)
        if before is None or not prim:
            return False
        old = transforms.from_usd(before)[:3, :3]
        new = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))[:3, :3]
        if not self.finite(path):
            return True
        # The Gram matrix of the axes contains their lengths and angles, but not the rotation.
        gram = old.T @ old
        return bool(
            np.abs(new.T @ new - gram).max() > 2 * RESCALED * np.abs(gram).max()
            or (np.linalg.det(new) < 0) != (np.linalg.det(old) < 0)
        )


def role_of(prim: Any) -> str:
    """The role of a prim for physics or rays; "" if they ignore it."""
    name = prim.GetTypeName()
    kind = name if name and _has_role(str(name)) else ""
    applied = [schema for schema in prim.GetAppliedSchemas() if schema.startswith("Physics")]
    return f"{kind} {' '.join(applied)}" if kind or applied else ""


@lru_cache(maxsize=1024)
def _has_role(name: str) -> bool:
    if name == GRIPPER:
        return True
    kind = Usd.SchemaRegistry.GetTypeFromName(name)
    bases = (UsdGeom.Gprim, UsdGeom.PointInstancer, UsdPhysics.Joint, UsdPhysics.Scene)
    return bool(kind) and any(kind.IsA(Tf.Type(base)) for base in bases)


def _seen(prim: Any) -> bool:
    """Whether a traversal of the stage reaches the prim."""
    there = prim.IsActive() and prim.IsLoaded() and prim.IsDefined() and not prim.IsAbstract()
    return bool(there or prim.IsPseudoRoot())
