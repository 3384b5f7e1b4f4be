"""The light in each pixel of a frame: one look through its middle, or several beside it that are averaged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sensors.raycast.rays import NOTHING, Hits, RayBundle, Spots
from sensors.raycast.shadows import Shadows
from sensors.raycast.world import CastWorld, once_a_world

from .config import CameraConfig
from .darkness import NO_LIGHT
from .image_files import ImageFiles
from .light_images import LightImages
from .lights import Lighting, LightInputs, light_prims, read_lighting
from .line_exposure import LineExposure
from .looks import Looks, read_looks
from .rays import CameraRays
from .shading import radiance
from .smooth import Smooth, smooth_surfaces, smoothen
from .view import View, look

MOST_LAYERS = 32
"""Most transparent places that a ray passes."""


def see_through(world: CastWorld, view: View, looks: Looks, far: float, state: Any) -> View:
    """The view with what lies behind transparent places; the same view without any.

    far: distance from the image plane [m] that is shown. Of a rolling shutter, what lies behind is as in `state`.
    """
    rows = np.flatnonzero(np.isfinite(view.hits.distance))
    rows = rows[looks.unseen(view.hits, rows)]
    if not len(rows):
        return view
    view.facing_normals()
    hits = _copied(view.hits)
    for _ in range(MOST_LAYERS):
        start = hits.distance[rows]
        start += np.float32(2e-4) + np.float32(2e-6) * start
        beyond = view.rays.further(rows, view.bundle, start)
        behind = world.cast(beyond, state, normals=True, spots=hits.spots is not None)
        _face(behind, beyond)
        _put(hits, rows, behind, behind.distance + start)
        rows = rows[np.isfinite(behind.distance)]
        rows = rows[looks.unseen(hits, rows)]
        if not len(rows):
            break
    hits.distance[rows], hits.number[rows] = np.inf, NOTHING
    along = view.rays.along
    depth = hits.distance if along is None else hits.distance * along
    outside = depth > far
    hits.distance[outside], hits.number[outside] = np.inf, NOTHING
    return View(view.rays, view.bundle, hits, depth, faced=True)


def _copied(hits: Hits) -> Hits:
    spots = None if hits.spots is None else Spots(hits.spots.triangle.copy(), hits.spots.uv.copy())
    assert hits.normals is not None
    return Hits(hits.distance.copy(), hits.normals.copy(), hits.number.copy(), hits.surface_of, spots)


def _face(hits: Hits, rays: RayBundle) -> None:
    """Turns normals towards where the rays come from."""
    assert hits.normals is not None
    away = (hits.normals * rays.table[:, 3:6]).sum(axis=1) > 0
    hits.normals[away] *= np.float32(-1)


def _put(hits: Hits, rows: np.ndarray, found: Hits, distance: np.ndarray) -> None:
    hits.distance[rows], hits.number[rows] = distance, found.number
    if hits.normals is not None and found.normals is not None:
        hits.normals[rows] = found.normals
    if hits.spots is not None and found.spots is not None:
        hits.spots.triangle[rows], hits.spots.uv[rows] = found.spots.triangle, found.spots.uv


def sample_places(count: int) -> list[tuple[float, float]]:
    """Where in a pixel `count` rays go, from its middle [px]: Halton's sequence of the bases 2 and 3 (Halton, 1960)."""
    return [(0.0, 0.0)] if count == 1 else [(_halton(n, 2) - 0.5, _halton(n, 3) - 0.5) for n in range(1, count + 1)]


def _halton(number: int, base: int) -> float:
    found, share = 0.0, 1.0
    while number:
        share /= base
        number, digit = divmod(number, base)
        found += digit * share
    return found


class Pictures:
    """Makes the pictures of one camera; `config` and `exclude` as of its runtime."""

    def __init__(self, path: str, config: CameraConfig, exclude: frozenset[str], samples: int) -> None:
        self._path, self._config, self._exclude = path, config, exclude
        self._places = sample_places(samples)
        self._rays: list[CameraRays] = []
        self._shadows: Shadows | None = None
        self._darkness_told = False

    @property
    def samples(self) -> int:
        """How many rays each pixel has."""
        return len(self._places)

    def radiance(
        self, view: View, pose: np.ndarray, state: Any, world: CastWorld, lines: LineExposure | None = None
    ) -> np.ndarray:
        """(n, 3) float32 [nit] of each pixel, linear. view: through the middles, with normals if that is all, and spots
        where these count.
        """
        looks, lighting = looks_of(world), self.lighting(world, pose, state)
        shapes = smooth_surfaces(world)
        if self._shadows is None or self._shadows.world is not world:
            self._shadows = Shadows(world, self._exclude | looks.clear)
        if self.samples == 1:
            return self._radiance(view, shapes, looks, lighting, state)
        if not self._rays:
            self._rays = [CameraRays(self._config.lens, place) for place in self._places]
        total = np.zeros((len(view.depth), 3), np.float32)
        for rays in self._rays:
            spots = looks.vary or bool(shapes)
            seen = look(world, rays, self._config, pose, state, self._exclude, normals=True, spots=spots, lines=lines)
            smoothen(seen, shapes, world, state)
            total += self._radiance(seen, shapes, looks, lighting, state)
        return np.asarray(total / np.float32(self.samples))

    def _radiance(
        self, view: View, shapes: Mapping[int, Smooth], looks: Looks, lighting: Lighting, state: Any
    ) -> np.ndarray:
        assert self._shadows is not None
        if looks.cut and (seen := see_through(self._shadows.world, view, looks, self._config.far, state)) is not view:
            view = seen
            smoothen(view, shapes, self._shadows.world, state)
        return radiance(view, looks, lighting, self._shadows, state)

    def lighting(self, world: CastWorld, pose: np.ndarray, state: Any) -> Lighting:
        """The lights as they are in a state, as seen from a camera at `pose` (4, 4) float64 [m]."""
        scene = world.scene
        lighting = read_lighting(
            _light_inputs(world),
            _light_images(world),
            lambda path: scene.fabric.world_matrix(path, state),
            scene.meters_per_unit,
            pose[:3, 3],
            scene.warn,
        )
        if lighting.dark and not self._darkness_told:
            self._darkness_told = True
            scene.warn("no-light", self._path, NO_LIGHT)
        return lighting


@once_a_world
def looks_of(world: CastWorld) -> Looks:
    """The looks of all surfaces of a cast world."""
    return read_looks(world.scene.stage, world.surfaces, _files(world), world.scene.warn)


def has_projector(world: CastWorld) -> bool:
    """Whether a light of the scene throws a pattern."""
    return any(prim.HasAttribute("isProjector") and prim.GetAttribute("isProjector").Get() for prim in _lights(world))


def light_places(world: CastWorld, state: Any) -> np.ndarray:
    """The world matrices of the lights in a state, (n, 4, 4) float64 [stage units]."""
    return np.asarray(world.scene.fabric.world_matrices(_light_paths(world), state))


@once_a_world
def _light_paths(world: CastWorld) -> tuple[str, ...]:
    return tuple(str(prim.GetPath()) for prim in _lights(world))


@once_a_world
def _lights(world: CastWorld) -> list[Any]:
    return light_prims(world.scene.stage)


@once_a_world
def _light_images(world: CastWorld) -> LightImages:
    return LightImages(_files(world))


def _light_inputs(world: CastWorld) -> list[LightInputs]:
    """What the stage says of each light; read again after an edit, and every time where edits are not watched."""
    live = world.scene.live
    edits = None if live is None else live.watch.edits
    known: tuple[int | None, list[LightInputs]] | None = world.cache.get("camera light inputs")
    if known is None or edits is None or known[0] != edits:
        known = world.cache["camera light inputs"] = edits, [LightInputs(prim) for prim in _lights(world)]
    return known[1]


@once_a_world
def _files(world: CastWorld) -> ImageFiles:
    """The image files of the scene; surfaces and skies share their limit."""
    return ImageFiles(world.scene.folders)
