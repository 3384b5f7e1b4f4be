"""The surfaces of a world on a device: standing triangles, solids, moving and deforming meshes, infinite planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import blake2b
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from graph.sim.devices import warp
from graph.sim.geometry.surfaces import Mesh, Plane, Solid
from sensors.raycast.forms import Forms

from .devices import refuse_beyond
from .items import FEW_ITEMS, MESH

BYTES_A_TRIANGLE = 120
"""Memory of a triangle with its share of the tree, rounded up (measured with 0.2 and 2.0 million)."""


_MESHES: WeakValueDictionary[tuple[str, bytes, bytes], Any] = WeakValueDictionary()
"""Meshes that do not deform, by device and content, as long as something uses them."""


class Geometry:
    """Surfaces on a device, for rays about one anchor.

    surfaces: of a world; bodies: (s,) their bodies' numbers, -1: none. anchor: (3,) float64 [m]; standing triangles
    are rounded to float32 about it. formulas: whether solids are met by their closed forms. soft: numbers of the meshes
    that deform. skip: surfaces that are left out; the standing ones among them take no memory.
    """

    def __init__(
        self,
        device: Any,
        surfaces: Sequence[Mesh | Plane],
        bodies: np.ndarray,
        anchor: np.ndarray,
        *,
        formulas: bool,
        soft: Sequence[int] = (),
        skip: frozenset[int] = frozenset(),
        worlds: int = 1,
    ) -> None:
        from . import kernels

        self.device, self.anchor, self.worlds, self._kernels = device, anchor, worlds, kernels
        self._kept_meshes: list[Any] = []  # Warp frees a mesh with its Python object
        numbered = [(number, one) for number, one in enumerate(surfaces) if isinstance(one, Mesh)]
        solids = [
            (n, one) for n, one in numbered if formulas and isinstance(one, Solid) and self._kept(n, bodies, skip)
        ]
        known = {number for number, _ in solids}
        meshes = [(n, one) for n, one in numbered if n not in known and n not in soft and len(one.triangles)]
        standing = [(n, one) for n, one in meshes if bodies[n] < 0 and n not in skip]
        moving = [(n, one) for n, one in meshes if bodies[n] >= 0]
        triangles = sum(len(one.triangles) for _, one in [*standing, *moving])
        refuse_beyond(device, triangles * BYTES_A_TRIANGLE, f"geometry of {triangles:,} triangles")
        self.ground = self._ground(standing, [(n, s) for n, s in enumerate(surfaces) if isinstance(s, Plane)], bodies)
        self._soft = {n: one for n, one in numbered if n in soft}
        self._soft_meshes: dict[int, Any] = {}
        self.items = self._items(solids, moving, bodies)
        self.count = len(solids) + len(moving)
        """Number of items: solids and moving meshes."""
        there = (bool(solids), bool(moving), bool(soft)) if device.is_cuda else (True, True, True)
        self.kinds = *there, self.count <= FEW_ITEMS
        """What the kernels are made for: solids, moving meshes, deforming ones, and few items. What is not there costs
        registers on a card only; on the processor fewer kernels are compiled.
        """
        self.placed = self._room()
        flags = np.zeros(max(len(surfaces), 1), np.uint8)
        flags[list(skip)] = 1
        self.skip = self._array(flags, np.uint8)
        self._bodies: Any = None
        self._met: dict[int, Any] = {}

    def _kept(self, number: int, bodies: np.ndarray, skip: frozenset[int]) -> bool:
        return bool(bodies[number] >= 0) or number not in skip

    def place(self, poses: np.ndarray | None) -> Any:
        """Places bodies at poses (w, b, 4, 4) float64 world [m]; returns them about the anchor, on the device."""
        wp = warp()
        if poses is None:
            poses = np.zeros((self.worlds, 0, 4, 4))
        about = np.array(poses)
        about[..., :3, 3] -= self.anchor
        if self._bodies is None or self._bodies.shape != about.shape[:2]:
            self._bodies = wp.zeros(about.shape[:2], dtype=wp.mat44d, device=self.device)
        self._bodies.assign(about)
        self.settle(self._bodies)
        return self._bodies

    def settle(self, bodies: Any) -> None:
        """Places the items by bodies (w, b) about the anchor that are on the device."""
        wp = warp()
        if self.count:
            wp.launch(
                self._kernels.place_items,
                dim=(self.worlds, self.count),
                inputs=[self.items, bodies, self.placed],
                device=self.device,
            )
            if self._tree is not None:
                self._tree.refit()

    def deform(self, points: Mapping[int, np.ndarray]) -> None:
        """Places the vertices (n, 3) float64 world [m] of deforming meshes, by their numbers."""
        wp = warp()
        for number, places in points.items():
            about = wp.array((places - self.anchor).astype(np.float32), dtype=wp.vec3, device=self.device)
            known = self._soft_meshes.get(number)
            if known is None:
                self._soft_meshes[number] = wp.Mesh(about, self._indices(self._soft[number].triangles))
            else:
                wp.copy(known.points, about)
                known.refit()
        found = sorted(self._soft_meshes)
        self.ground.soft = self._array([self._soft_meshes[number].id for number in found], np.uint64)
        self.ground.soft_surface = self._array(found, np.int32)

    def rays(self, ways: np.ndarray, origins: np.ndarray | None) -> Any:
        """Rays (n, 3) float32 of a frame; `frames` (w,) of the result take their poses."""
        wp, rays = warp(), self._kernels.Rays()
        rays.ways = self._array(ways, np.float32, wp.vec3)
        rays.origins = self._array(np.zeros((0, 3)) if origins is None else origins, np.float32, wp.vec3)
        rays.frames = wp.zeros(self.worlds, dtype=wp.mat44d, device=self.device)
        return rays

    def trace(self, rays: Any, due: Any, most: float) -> Any:
        """What rays of the worlds `due` meet of the standing triangles, (w, n) on the device; room of the next call
        with as many rays.
        """
        wp, shape = warp(), (self.worlds, len(rays.ways))
        met = self._met.get(shape[1])
        if met is None:
            met = self._met[shape[1]] = wp.zeros(shape, dtype=self._kernels.Rough, device=self.device)
        if self.ground.mesh:
            inputs = [self.ground.mesh, rays, due, most, met]
            wp.launch(self._kernels.trace, dim=(len(due), shape[1]), inputs=inputs, device=self.device)
        else:
            wp.launch(self._kernels.miss, dim=shape, inputs=[met], device=self.device)
        return met

    # -- what is uploaded --------------------------------------------------------------------------------------------

    def _array(self, values: Any, dtype: Any, kind: Any = None) -> Any:
        wp = warp()
        array = np.ascontiguousarray(values, dtype)
        return wp.array(array, dtype=kind or wp.dtype_from_numpy(dtype), device=self.device)

    def _indices(self, triangles: np.ndarray) -> Any:
        return self._array(np.ascontiguousarray(triangles).reshape(-1), np.int32)

    def _mesh(self, points: np.ndarray, triangles: np.ndarray) -> Any:
        """A mesh of vertices (n, 3) and triangles (t, 3); equal ones share their memory, for all sensors."""
        wp = warp()
        about, corners = np.ascontiguousarray(points, np.float32), np.ascontiguousarray(triangles, np.int32)
        key = self.device.alias, blake2b(about.data).digest(), blake2b(corners.data).digest()
        made = _MESHES.get(key)
        if made is None:
            made = wp.Mesh(wp.array(about, dtype=wp.vec3, device=self.device), self._indices(corners))
            _MESHES[key] = made
        self._kept_meshes.append(made)
        return made

    def _ground(self, standing: Sequence[tuple[int, Mesh]], planes: Sequence[tuple[int, Plane]], bodies: Any) -> Any:
        wp, ground = warp(), self._kernels.Ground()
        if standing:
            starts = np.cumsum([0, *(len(one.vertices) for _, one in standing)])
            points = np.concatenate([one.vertices - self.anchor for _, one in standing])
            triangles = np.concatenate(
                [np.asarray(one.triangles, np.int64) + at for (_, one), at in zip(standing, starts, strict=False)]
            )
            ground.mesh = self._mesh(points, triangles).id
        counts = [len(one.triangles) for _, one in standing]
        ground.surface = self._array(np.repeat([number for number, _ in standing], counts), np.int32)
        ground.soft, ground.soft_surface = self._array([], np.uint64), self._array([], np.int32)
        ground.plane_surface = self._array([number for number, _ in planes], np.int32)
        owners = [int(bodies[number]) for number, _ in planes]
        shifts = [self.anchor if owner < 0 else np.zeros(3) for owner in owners]
        places = [np.asarray(one.origin) - shift for (_, one), shift in zip(planes, shifts, strict=True)]
        ground.plane_body = self._array(owners, np.int32)
        ground.plane_point = self._array(np.reshape(places, (-1, 3)), np.float64, wp.vec3d)
        ground.plane_normal = self._array(np.reshape([one.normal for _, one in planes], (-1, 3)), np.float64, wp.vec3d)
        return ground

    def _items(self, solids: Sequence[tuple[int, Solid]], moving: Sequence[tuple[int, Mesh]], bodies: Any) -> Any:
        wp, items = warp(), self._kernels.Items()
        forms = Forms([one.form for _, one in solids]) if solids else None
        numbers = [number for number, _ in [*solids, *moving]]
        owners = np.array([bodies[number] for number in numbers], np.int32).reshape(-1)
        boxes = np.array([(one.vertices.min(axis=0), one.vertices.max(axis=0)) for _, one in moving]).reshape(-1, 2, 3)
        centres = boxes.mean(axis=1)
        away = [one.vertices - at for (_, one), at in zip(moving, centres, strict=True)]
        radii = [float(np.sqrt((each**2).sum(axis=1).max())) for each in away]
        meshes = [self._mesh(each, one.triangles).id for each, (_, one) in zip(away, moving, strict=True)]
        inverse, middle = np.tile(np.eye(3), (len(moving), 1, 1)), centres
        kinds, sizes = np.full(len(moving), MESH), np.zeros((len(moving), 2))
        if forms is not None:
            inverse, kinds = np.concatenate([forms.inverse, inverse]), np.concatenate([forms.kinds, kinds])
            sizes, boxes = np.concatenate([forms.sizes, sizes]), np.concatenate([forms.boxes, boxes])
            centres, middle = np.concatenate([forms.centre, centres]), boxes.mean(axis=1)
        still = (owners < 0)[:, None]
        items.kind, items.surface, items.body = (self._array(x, np.int32) for x in (kinds, numbers, owners))
        items.low, items.high = self._array(sizes[:, 0], np.float64), self._array(sizes[:, 1], np.float64)
        items.inverse = self._array(inverse, np.float64, wp.mat33d)
        items.centre = self._array(centres - still * self.anchor, np.float64, wp.vec3d)
        items.middle = self._array(middle - still * self.anchor, np.float64, wp.vec3d)
        items.box = self._array((boxes[:, 1] - boxes[:, 0]) / 2, np.float64, wp.vec3d)
        items.radius = self._array([0.0] * len(solids) + radii, np.float64)
        items.mesh = self._array([0] * len(solids) + meshes, np.uint64)
        return items

    def _room(self) -> Any:
        wp, placed = warp(), self._kernels.Placed()
        shape = self.worlds, self.count
        placed.turn = wp.zeros(shape, dtype=wp.mat33d, device=self.device)
        placed.centre = wp.zeros(shape, dtype=wp.vec3d, device=self.device)
        few = self.count <= FEW_ITEMS
        placed.ball = wp.zeros(shape if few else (0, 0), dtype=wp.vec4, device=self.device)
        number = 0 if few else self.worlds * self.count
        placed.lower = wp.zeros(number, dtype=wp.vec3, device=self.device)
        placed.upper = wp.zeros(number, dtype=wp.vec3, device=self.device)
        self._tree: Any = None
        if number:
            groups = self._array(np.repeat(np.arange(self.worlds), self.count), np.int32)
            self._tree = wp.Bvh(placed.lower, placed.upper, groups=groups)
            placed.tree = self._tree.id
        return placed
