"""`scatter_2d` and `scatter_3d` of `omni.replicator.core`: prims at random places on surfaces and in volumes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graph.isaac.outcomes import Refusing
from graph.isaac.session import app
from graph.sim.geometry.inside import WOUND, winding_numbers
from graph.sim.geometry.shapes import surface_of
from graph.sim.usd import Usd, UsdGeom

from . import carb
from .replicator_draws import CORE, Draw
from .replicator_prims import RANDOM, prims_of
from .xforms import put

Limits = tuple[Sequence[float | None], Sequence[float | None]]
Unit = Callable[[], float]
ANYWHERE: Limits = ((None, None, None), (None, None, None))
_TRIES = 1000
_FLATNESS = 0.01
"""How far the triangles of a curved surface may lie off it, over its size."""


@dataclass
class _Room:
    """Where the origins of prims may be, and the boxes that theirs may not overlap."""

    limits: Limits
    boxes: list[np.ndarray] = field(default_factory=list)

    def has(self, point: np.ndarray) -> bool:
        """Whether a point is within the limits."""
        low, high = (
            np.array([else_ if one is None else one for one in given], float)
            for given, else_ in zip(self.limits, (-np.inf, np.inf), strict=True)
        )
        return bool(np.all(point >= low) and np.all(point <= high))

    def is_free(self, box: np.ndarray) -> bool:
        """Whether a box (2, 3) overlaps none."""
        return not any(np.all(box[0] < one[1]) and np.all(one[0] < box[1]) for one in self.boxes)


def scatter(
    prims: list[Any], places: Iterator[np.ndarray], limits: Limits, obstacles: list[Any], check_for_collisions: bool
) -> None:
    """Puts each prim at the next of random places that is within the limits, and where its box is free.

    obstacles: prims whose boxes count as taken; check_for_collisions: whether those of the scattered prims count too.
    A prim for which no place is found stays where it is, with a warning.
    """
    room = _Room(limits, [_box(one) for one in obstacles])
    for prim in prims:
        own = _box(prim) - _origin(prim)
        for _ in range(_TRIES):
            point = next(places)
            if room.has(point) and (not room.boxes or room.is_free(own + point)):
                put(prim, position=point)
                if check_for_collisions:
                    room.boxes.append(own + point)
                break
        else:
            carb.log_warn(f"{CORE}: no place was found for {prim.GetPath()} in {_TRIES} tries; it stays where it is")


def on_surfaces(surfaces: list[Any], offset: float, unit: Unit) -> Iterator[np.ndarray]:
    """Random points on prims, each part of their area as likely as any other, `offset` above it along its normal.

    Raises ValueError for prims without a surface.
    """
    found = [corners for prim in surfaces for corners in _triangles(prim)]
    if not found:
        raise ValueError(f"{CORE}: scatter_2d: surface_prims have no surface; give meshes or shapes")
    corners = np.concatenate(found)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    ends = np.cumsum(doubled)
    while True:
        which = min(int(np.searchsorted(ends, unit() * ends[-1], side="right")), len(ends) - 1)
        a, b = unit(), unit()
        a, b = (1 - a, 1 - b) if a + b > 1 else (a, b)
        first, second, third = corners[which]
        yield first + a * (second - first) + b * (third - first) + offset * normals[which] / doubled[which]


def in_volumes(volumes: list[Any], excluded: list[Any], limits: Limits, unit: Unit) -> Iterator[np.ndarray]:
    """Random points inside prims, or without them between the limits, and outside excluded prims.

    Raises ValueError without prims and limits.
    """
    boxes = np.array([_box(one) for one in volumes] if volumes else [limits], float)
    if not np.isfinite(boxes).all():
        raise ValueError(f"{CORE}: scatter_3d: give volume_prims, or min_samp and max_samp for all three axes")
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    for bound, given, nearer in ((low, limits[0], max), (high, limits[1], min)):
        bound[:] = [one if edge is None else nearer(one, edge) for one, edge in zip(bound, given, strict=True)]
    while True:
        points = low + np.array([[unit() for _ in range(3)] for _ in range(32)]) * (high - low)
        within = _inside(volumes, points) if volumes else np.ones(len(points), bool)
        good = points[within & ~_inside(excluded, points)]
        yield from good if len(good) else [np.full(3, np.inf)]


def _shapes(prim: Any) -> Iterator[Any]:
    return (one for one in Usd.PrimRange(prim) if one.IsA(UsdGeom.Gprim))


def _triangles(prim: Any) -> Iterator[np.ndarray]:
    """The triangles (n, 3, 3) of a prim and of what is below it, in the world, without those that have no area."""
    for shape in _shapes(prim):
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(shape), Usd.TimeCode.Default())
        size = float(np.ptp(np.array(extent, float), axis=0).max()) if extent else 1.0
        surface = surface_of(shape, _FLATNESS * size, lambda problem: None)
        if surface is not None:
            matrix = app().fabric.world_matrix(str(shape.GetPath()))
            corners = (np.asarray(surface.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3])[surface.triangles]
            area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
            yield corners[area > 0]


def _origin(prim: Any) -> np.ndarray:
    place: np.ndarray = app().fabric.world_matrix(str(prim.GetPath()))[:3, 3]
    return place


def _box(prim: Any) -> np.ndarray:
    """The lowest and the highest corner (2, 3) of a prim in the world; of one without a surface, its origin."""
    points = np.concatenate([one.reshape(-1, 3) for one in _triangles(prim)] or [_origin(prim)[None]])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _inside(volumes: list[Any], points: np.ndarray) -> np.ndarray:
    """Whether each point of the world is inside one of the prims."""
    found = np.zeros(len(points), bool)
    for shape in (one for prim in volumes for one in _shapes(prim)):
        matrix = np.linalg.inv(app().fabric.world_matrix(str(shape.GetPath())))
        found |= winding_numbers(shape, points @ matrix[:3, :3].T + matrix[:3, 3]) > WOUND
    return found


def units(seed: int | None = None) -> Unit:
    """Random numbers in [0, 1)."""
    return Draw(lambda stream: stream.unit(), seed).next


class FunctionalRandomizer(Refusing):
    """`functional.randomizer.scatter_2d(prims, surface_prims)`."""

    def scatter_2d(
        self,
        prims: Any,
        surface_prims: Any,
        no_collision_prims: Any = None,
        extents: Any = None,
        offset: float = 0.0,
        check_for_collisions: bool = False,
        rng: Any = None,
    ) -> None:
        places = on_surfaces(prims_of(surface_prims), offset, _numbers(rng))
        scatter(prims_of(prims), places, extents or ANYWHERE, prims_of(no_collision_prims or []), check_for_collisions)

    def scatter_3d(
        self,
        prims: Any,
        volume_prims: Any = None,
        no_collision_prims: Any = None,
        volume_excl_prims: Any = None,
        extents: Any = None,
        check_for_collisions: bool = False,
        prevent_vol_overlap: bool = True,
        viz_sampled_voxels: bool = False,
        resolution_scaling: float = 1.0,
        input_voxel_size: float = 0.0,
        rng: Any = None,
    ) -> None:
        limits = extents or ANYWHERE
        places = in_volumes(prims_of(volume_prims or []), prims_of(volume_excl_prims or []), limits, _numbers(rng))
        scatter(prims_of(prims), places, limits, prims_of(no_collision_prims or []), check_for_collisions)


def _numbers(rng: Any) -> Unit:
    """Those of a NumPy generator, or of a `ReplicatorRNG`."""
    generator = getattr(rng, "generator", rng)
    return units() if generator is None else lambda: float(generator.random())


functional_randomizer = FunctionalRandomizer(f"{CORE}.functional.randomizer", RANDOM)
