"""The light in each pixel of a frame: one look through its middle, or several beside it that are averaged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sensors.raycast.shadows import Shadows
from sensors.raycast.world import CastWorld

from .config import CameraConfig
from .cutouts import see_through
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

if TYPE_CHECKING:
    pass


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
        if "camera light images" not in world.cache:
            world.cache["camera light images"] = LightImages(_files(world))
        lighting = read_lighting(
            _light_inputs(world),
            world.cache["camera light images"],
            lambda path: scene.fabric.world_matrix(path, state),
            scene.meters_per_unit,
            pose[:3, 3],
            scene.warn,
        )
        if lighting.dark and not self._darkness_told:
            self._darkness_told = True
            scene.warn("no-light", self._path, NO_LIGHT)
        return lighting


def looks_of(world: CastWorld) -> Looks:
    """The looks of all surfaces of a cast world."""
    found: Looks | None = world.cache.get("camera looks")
    scene = world.scene
    if found is None:
        found = world.cache["camera looks"] = read_looks(scene.stage, world.surfaces, _files(world), scene.warn)
    return found


def has_projector(world: CastWorld) -> bool:
    """Whether a light of the scene throws a pattern."""
    return any(prim.HasAttribute("isProjector") and prim.GetAttribute("isProjector").Get() for prim in _lights(world))


def light_places(world: CastWorld, state: Any) -> np.ndarray:
    """The world matrices of the lights in a state, (n, 4, 4) float64 [stage units]."""
    paths = world.cache.get("camera light paths")
    if paths is None:
        paths = world.cache["camera light paths"] = tuple(str(prim.GetPath()) for prim in _lights(world))
    return np.asarray(world.scene.fabric.world_matrices(paths, state))


def _lights(world: CastWorld) -> list[Any]:
    found: list[Any] | None = world.cache.get("camera lights")
    if found is None:
        found = world.cache["camera lights"] = light_prims(world.scene.stage)
    return found


def _light_inputs(world: CastWorld) -> list[LightInputs]:
    """What the stage says of each light; read again after an edit, and every time where edits are not watched."""
    live = world.scene.live
    edits = None if live is None else live.watch.edits
    known: tuple[int | None, list[LightInputs]] | None = world.cache.get("camera light inputs")
    if known is None or edits is None or known[0] != edits:
        known = world.cache["camera light inputs"] = edits, [LightInputs(prim) for prim in _lights(world)]
    return known[1]


def _files(world: CastWorld) -> ImageFiles:
    """The image files of the scene; surfaces and skies share their limit."""
    found: ImageFiles = world.cache.setdefault("camera images", ImageFiles(world.scene.folders))
    return found
