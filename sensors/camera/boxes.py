"""Bounding boxes of labelled prims: in the image, tight or loose, and in space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.geometry.surfaces import Mesh, Solid
from graph.sim.transforms import from_usd, transformed
from sensors.raycast.alone import cast_alone
from sensors.raycast.world import CastWorld, once_a_world

from .channels import AROUND, BOX, BOX_2D, BOX_3D, LABELLED, LOOSE, TIGHT
from .config import CameraConfig
from .entities import entities_of, lineage
from .view import View

if TYPE_CHECKING:
    pass


@dataclass(slots=True)
class _Prim:
    """A labelled prim: its number, its surfaces, whether one mesh without labelled parts is all of it."""

    number: int
    surfaces: tuple[int, ...]
    single: bool


@dataclass(slots=True)
class Outline:
    """Where a prim would be seen if it were alone: its box (x_min, y_min, x_max, y_max) and its pixels."""

    prim: _Prim
    box: tuple[int, int, int, int]
    pixels: int


def outlines(world: CastWorld, view: View, config: CameraConfig, poses: Any) -> list[Outline]:
    """The outlines of all labelled prims that are in the image, hidden or not."""
    found = []
    for prim in _prims(world):
        rays = _rays_at(world, prim, view, poses)
        if rays is not None and not len(rays):
            continue
        distance = cast_alone(world, prim.surfaces, view.bundle, rays, poses)
        depth = distance if view.rays.along is None or view.rays.wide else distance * _at(view.rays.along, rays)
        seen = np.flatnonzero((depth >= config.near) & (depth <= config.far) & np.isfinite(depth))
        if len(seen):
            pixels = seen if rays is None else rays[seen]
            rows, columns = np.divmod(pixels, config.lens.width)
            box = int(columns.min()), int(rows.min()), int(columns.max()), int(rows.max())
            found.append(Outline(prim, box, len(pixels)))
    return found


def _at(values: np.ndarray, rays: np.ndarray | None) -> np.ndarray:
    return values if rays is None else values[rays]


def _rays_at(world: CastWorld, prim: _Prim, view: View, state: Any) -> np.ndarray | None:
    """The rays that may meet a prim; None for all."""
    if view.bundle.offsets is not None:
        return None
    poses = world.body_poses(state)
    meshes = [number for number in prim.surfaces if isinstance(world.surfaces[number], Mesh)]
    if len(meshes) < len(prim.surfaces):  # an endless plane
        return None
    points = np.concatenate([world.vertices(number, poses, state) for number in meshes]) - view.bundle.origin
    low, high = points.min(axis=0), points.max(axis=0)
    centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    distance = float(np.linalg.norm(centre))
    half = np.pi if distance <= radius else np.arcsin(radius / distance) + 1e-4
    rays, _ = view.rays.grid().near(centre[None], np.array([half]))
    return np.sort(rays)


@once_a_world
def _prims(world: CastWorld) -> tuple[_Prim, ...]:
    entities = entities_of(world, LABELLED)
    found = []
    for number, path in entities.paths.items():
        surfaces = tuple(np.flatnonzero(entities.numbers[:-1] == number).tolist())
        nested = any(other != path and other.startswith(f"{path}/") for other in entities.paths.values())
        found.append(_Prim(number, surfaces, len(surfaces) == 1 and not nested and entities.layers[number] == 1))
    return tuple(found)


def visible_boxes(numbers: np.ndarray, width: int) -> dict[int, tuple[tuple[int, int, int, int], int]]:
    """Number of a prim -> its box and its pixels in an image (n,) of such numbers; those from 2 on."""
    pixels = np.flatnonzero(numbers >= 2)
    if not len(pixels):
        return {}
    which = numbers[pixels].astype(np.intp)
    rows, columns = np.divmod(pixels, width)
    most = int(which.max()) + 1
    low, high = np.full((2, most), np.iinfo(np.int64).max), np.full((2, most), -1)
    for axis, values in enumerate((columns, rows)):
        np.minimum.at(low[axis], which, values)
        np.maximum.at(high[axis], which, values)
    counts = np.bincount(which, minlength=most)
    return {
        number: ((*low[:, number].tolist(), *high[:, number].tolist()), int(counts[number]))
        for number in np.flatnonzero(counts).tolist()
    }


def boxes_of(
    world: CastWorld, view: View, config: CameraConfig, poses: Any, numbers: np.ndarray, wanted: frozenset[str]
) -> dict[str, np.ndarray]:
    """The box channels in demand. numbers: (n,) of the labelled prim in each pixel."""
    visible = visible_boxes(numbers, config.lens.width)
    there = outlines(world, view, config, poses) if wanted & {TIGHT, LOOSE, BOX, AROUND} else []
    ratio = {one.prim.number: _occlusion(one, visible) for one in there}
    found = {}
    if TIGHT in wanted:
        rows = [(number, *box, ratio.get(number, np.nan)) for number, (box, _) in visible.items()]
        found[TIGHT] = np.array(rows, BOX_2D)
    if LOOSE in wanted:
        rows = [(one.prim.number, *one.box, ratio[one.prim.number]) for one in there]
        found[LOOSE] = np.array(rows, BOX_2D)
    if BOX in wanted:
        found[BOX] = _boxes_3d(world, [one.prim for one in there], ratio, poses)
    if AROUND in wanted:
        found[AROUND] = _boxes_3d(world, [one for one in _prims(world) if one.surfaces], ratio, poses)
    return found


def _occlusion(one: Outline, visible: Mapping[int, tuple[Any, int]]) -> float:
    """The hidden share of a prim's own pixels; -1 unless it is a single mesh, as the original has it."""
    if not one.prim.single:
        return -1.0
    return 1.0 - visible.get(one.prim.number, (None, 0))[1] / one.pixels


def _boxes_3d(world: CastWorld, prims: list[_Prim], ratio: Mapping[int, float], poses: Any) -> np.ndarray:
    """The boxes of prims; a prim of endless planes alone has no box."""
    rows = []
    paths = entities_of(world, LABELLED).paths
    surfaces = world.surfaces
    for one in prims:
        if not any(isinstance(surfaces[number], Mesh) for number in one.surfaces):
            continue
        frame = _frame(world, one, paths[one.number], poses)
        low, high = _extent(world, one, frame, poses)
        rows.append((one.number, *low, *high, frame.T, ratio.get(one.number, np.nan)))
    out = np.zeros(len(rows), BOX_3D)
    for place, row in enumerate(rows):
        out[place] = row
    return out


def _frame(world: CastWorld, one: _Prim, path: str, state: Any) -> np.ndarray:
    """(4, 4) float64, prim to world, stage units; of a copy, which is not a prim, that of its surfaces."""
    if "[" not in path:
        return np.asarray(world.scene.fabric.world_matrix(path, state), np.float64)
    number = one.surfaces[0] if one.surfaces else -1
    surface = world.surfaces[number]
    if not isinstance(surface, Mesh) or surface.frame is None:
        return np.eye(4)
    owner = next(prim for place, prim in lineage(world.scene.stage, surface) if place == path)
    found = surface.frame @ np.linalg.inv(_inside(owner, world.scene.stage.GetPrimAtPath(surface.source)))
    poses, body = world.body_poses(state), world.body_of[number]
    if body >= 0 and poses is not None:
        found = poses[body] @ found
    found[:3] /= world.scene.meters_per_unit
    return np.asarray(found)


def _inside(owner: Any, prim: Any) -> np.ndarray:
    """(4, 4), from the space of a prim to that of one above it."""
    from graph.sim.usd import UsdGeom

    cache = UsdGeom.XformCache()
    ways = [from_usd(cache.GetLocalToWorldTransform(each)) for each in (owner, prim)]
    return np.asarray(np.linalg.inv(ways[0]) @ ways[1])


def _extent(world: CastWorld, prim: _Prim, frame: np.ndarray, state: Any) -> tuple[np.ndarray, np.ndarray]:
    """The least and greatest coordinates of a prim's surfaces in its own axes; endless planes are left out."""
    meshes = [number for number in prim.surfaces if isinstance(world.surfaces[number], Mesh)]
    to_prim = np.linalg.inv(frame) @ np.diag([*(1 / world.scene.meters_per_unit,) * 3, 1.0])
    poses = world.body_poses(state)
    ends = [_ends(world, number, to_prim, poses, state) for number in meshes]
    return np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)


def _ends(
    world: CastWorld, number: int, to_prim: np.ndarray, poses: np.ndarray | None, state: Any
) -> tuple[np.ndarray, np.ndarray]:
    """The least and greatest coordinates of a surface after `to_prim` (4, 4) from the world [m]; exact for solids."""
    surface, body = world.surfaces[number], world.body_of[number]
    if isinstance(surface, Solid):
        return surface.form.placed(to_prim if body < 0 or poses is None else to_prim @ poses[body]).bounds()
    points = transformed(to_prim, world.vertices(number, poses, state))
    return points.min(axis=0), points.max(axis=0)
