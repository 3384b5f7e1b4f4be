"""A cast world whose rays are cast on a device; results are NumPy arrays, as those of `raycast.world`."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from graph.sim.devices import warp
from graph.sim.geometry.surfaces import Mesh
from sensors.raycast.rays import NO_SURFACE, NOTHING, Hits, RayBundle
from sensors.raycast.standing import excluded
from sensors.raycast.world import CastWorld, anchor_of, soft_prim

from .devices import device_of, refuse_beyond
from .geometry import Geometry

BYTES_A_RAY = 48
"""Ways, offsets, distance, surface and normal of a ray on the device."""


class DeviceWorld(CastWorld):
    """`CastWorld` on a device (`devices.device_of`). Places on triangles (`spots`) are found on the processor.

    Ranges are within 1e-5 m of the processor's, ids the same but at edges; the same rays give the same bytes again.
    """

    @classmethod
    def on(cls, name: str, *args: Any, **options: Any) -> DeviceWorld:
        """The world on a device by its name; other arguments as for `CastWorld`. Raises UserError without it."""
        device = device_of(name)
        world = cls(*args, **options)
        world.device = device
        return world

    @cached_property
    def facets(self) -> DeviceWorld:
        """See `CastWorld.facets`."""
        found = super().facets
        if found is self:
            return self
        world = DeviceWorld.__new__(DeviceWorld)
        world.__dict__ = {**found.__dict__, "device": self.device}
        return world

    def geometry(self, anchor: np.ndarray, exclude: frozenset[str]) -> Geometry:
        """The surfaces on the device, about an anchor (3,) float64 [m], without those that are excluded."""
        key = anchor.tobytes(), exclude
        if key not in self._geometries:
            skip = frozenset(n for n, one in enumerate(self.surfaces) if excluded(str(one.path), exclude))
            soft = [n for n, one in enumerate(self.surfaces) if isinstance(one, Mesh) and soft_prim(one, self.soft)]
            self._geometries[key] = Geometry(
                self.device, self.surfaces, self.body_of, anchor, formulas=self._formulas, soft=soft, skip=skip
            )
        return self._geometries[key]

    @cached_property
    def _geometries(self) -> dict[tuple[bytes, frozenset[str]], Geometry]:
        return {}

    @cached_property
    def _first(self) -> Any:
        wp = warp()
        return wp.zeros(1, dtype=wp.int32, device=self.device)

    @cached_property
    def _surface_of(self) -> np.ndarray:
        return np.array([*range(len(self.surfaces)), NO_SURFACE], np.int32)

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, spots: bool = False) -> Hits:
        """See `CastWorld.cast`."""
        if spots:
            return super().cast(rays, poses, normals=normals, spots=spots)
        count = len(rays.table)
        refuse_beyond(self.device, count * BYTES_A_RAY, f"a cast of {count:,} rays")
        distance, surface = np.empty(count, np.float32), np.empty(count, np.int32)
        normal = np.empty((count, 3), np.float32) if normals else None
        states = poses if rays.spans else (poses,)
        for (rows, bundle), state in zip(rays.by_state(), states, strict=True):
            for first, part in bundle.each():
                where = slice(rows.start + first, rows.start + first + len(part.table))
                found = self._cast(part, state, normals=normals)
                distance[where], surface[where] = found[0].numpy(), found[1].numpy()
                if normal is not None:
                    normal[where] = found[2].numpy()
        number = np.where(surface == NO_SURFACE, NOTHING, surface.astype(np.uint32))
        return Hits(distance, normal, number, self._surface_of)

    def placed(self, geometry: Geometry, state: Any) -> Any:
        """Brings a geometry of this world to a state (None: now); its bodies about the anchor, on the device."""
        bodies = self.body_poses(state)
        self.deform(geometry, state)
        return geometry.place(None if bodies is None else bodies[None])

    def deform(self, geometry: Geometry, state: Any) -> None:
        """Brings the deforming meshes of a geometry of this world to a state."""
        if self.soft:
            geometry.deform({n: self.vertices(n, None, state) for n, soft in enumerate(self.deforming) if soft})

    def write_bodies(self, out: np.ndarray, anchor: np.ndarray, state: Any) -> None:
        """Writes the poses (b, 4, 4) float64 [m] of the bodies in a state, about an anchor (3,) [m]."""
        bodies = self.body_poses(state)
        if bodies is not None:
            out[:] = bodies
            out[:, :3, 3] -= anchor

    def _cast(self, rays: RayBundle, state: Any, *, normals: bool) -> tuple[Any, Any, Any]:
        from . import kernels

        wp, device, count = warp(), self.device, len(rays.table)
        geometry = self.geometry(anchor_of(rays.origin), rays.exclude)
        placed = self.placed(geometry, state)
        bundle = geometry.rays(rays.table[:, 3:6], rays.offsets)
        frame = np.eye(4)
        frame[:3, 3] = rays.origin - geometry.anchor
        bundle.frames.assign(frame[None])
        met = geometry.trace(bundle, self._first, 1e30)
        distances = wp.empty(count, dtype=wp.float32, device=device)
        surfaces = wp.empty(count, dtype=wp.int32, device=device)
        into = wp.empty(count if normals else 0, dtype=wp.vec3, device=device)
        wp.launch(
            kernels.cast_of(*geometry.kinds),
            dim=count,
            inputs=[geometry.ground, geometry.items, geometry.placed, placed, geometry.skip, bundle, met],
            outputs=[distances, surfaces, into],
            device=device,
        )
        return distances, surfaces, into
