"""Cameras of one kind that look together: one cast of all their rays, and to each its own view.

A ray's hit does not depend on the other rays, so each camera gets the bytes that it gets alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sensors.raycast.rays import RayBundle, RayMemory
from sensors.raycast.world import CastWorld, anchor_of

from .lens import ParallelLens
from .rays import CameraRays
from .view import View, shown

if TYPE_CHECKING:
    from graph.sim.renderer.schedule import Tick

    from .runtime import CameraRuntime

Moment = tuple[Any, ...]


class TileGroup:
    """Cameras that are due at the same ticks; the first one that renders casts the rays of all."""

    def __init__(self, members: Sequence[CameraRuntime]) -> None:
        self._members = list(members)
        for member in self._members:
            member.group = self
        self._rays: list[CameraRays] = []
        self._lens: Any = None
        self._table = np.empty((0, 6), np.float32)
        self._offsets = np.empty((0, 3), np.float32)
        self._memory = RayMemory()
        self._placed = b""
        self._moment: Moment = ()
        self._seen: dict[CameraRuntime, View] = {}

    def view(self, camera: CameraRuntime, world: CastWorld, tick: Tick, *, normals: bool, spots: bool) -> View | None:
        """What one of the cameras sees; None if it has to look alone."""
        if tick.poses is not None:
            return None
        moment = tick.time, world, normals, spots
        if camera not in self._seen or self._moment != moment:
            self._seen, self._moment = self._look(world, normals, spots), moment
        return self._seen.pop(camera, None)

    def _look(self, world: CastWorld, normals: bool, spots: bool) -> dict[CameraRuntime, View]:
        """What each camera sees; empty where they differ, or where a cast depends on who else casts."""
        first, count = self._members[0], len(self._members)
        if not (world.rays_go_everywhere and self._alike()):
            return {}
        poses = [member.pose() for member in self._members]
        places = np.stack([pose[:3, 3] for pose in poses])
        anchor = anchor_of(places[0])
        if (anchor_of(places) != anchor).any() or not world.shares_frame(places - anchor):
            return {}
        if self._lens != first.config.lens:
            self._lens = first.config.lens
            self._table, self._rays = CameraRays(self._lens).copies(count)
            self._placed = b""
        parts = [
            rays.bundle(pose, first.exclude, grid=bool(len(world.moving_surfaces)))
            for rays, pose in zip(self._rays, poses, strict=True)
        ]
        pixels = len(self._rays[0])
        placed = np.stack(poses).tobytes()
        if placed != self._placed:
            self._placed = placed
            self._memory.forget()
            self._offsets = np.repeat((places - anchor).astype(np.float32), pixels, axis=0)
        bundle = RayBundle(anchor, self._table, self._offsets, first.exclude, memory=self._memory, parts=parts)
        hits = world.cast(bundle, normals=normals, spots=spots)
        found = {}
        for number, (member, rays, part) in enumerate(zip(self._members, self._rays, parts, strict=True)):
            own = hits.some(slice(number * pixels, (number + 1) * pixels))
            found[member] = shown(world, rays, first.config, part, own, None)
        return found

    def _alike(self) -> bool:
        """Whether all have one lens, rate and shutter, and leave the same prims out."""
        first = self._members[0]
        if first.config.shutter is not None or isinstance(first.config.lens, ParallelLens):
            return False
        own = first.config, first.rate, first.exclude
        return all((one.config, one.rate, one.exclude) == own for one in self._members)
