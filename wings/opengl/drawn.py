"""The images of a camera as OpenGL draws them (`camera.backend=gl`).

Colours follow the formula of `sensors.camera.shading`, in steps of 1 / 255 of linear light. Lights with an extent shine
from their middle, skies with an image light everything alike, and what has a texture of opacity or differs from corner
to corner has one colour. What moves is as exact as float32 about the camera.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.camera.config import CameraConfig
from sensors.camera.lens import ParallelLens
from sensors.camera.lights import Light, Lighting
from sensors.camera.looks import Looks
from sensors.camera.paints import ByCorner, Paint, Textured
from sensors.camera.rays import CameraRays
from sensors.camera.smooth import Smooth
from sensors.camera.view import View
from sensors.raycast.rays import NO_SURFACE, NOTHING, Hits
from sensors.raycast.standing import excluded
from sensors.raycast.world import CastWorld

from .scene import ABSENT, DARK, FARTHEST_M, MOST_LAMPS, SHOWN, DrawnScene, Eye, Lamp, Shape

PLANE_M = 1e5
"""Half the side of the square that stands for an infinite plane."""
SHADOWS_M = 100.0
"""Things throw shadows within this distance of the camera at most; the finer, the nearer the farthest thing is."""
NEAREST_M = 1e-4
"""The nearest that is drawn by a camera that shows everything."""
AXES = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32).T


def reason_for_rays(world: CastWorld, config: CameraConfig) -> str:
    """Why OpenGL cannot draw what a camera sees; "" if it can."""
    if config.shutter is not None:
        return "it has a rolling shutter"
    if not (config.lens.is_pinhole or isinstance(config.lens, ParallelLens)):
        return "its lens bends straight lines"
    if world.soft:
        return "cloth or soft bodies are in the scene"
    return ""


class DrawnCamera:
    """What one camera sees of a world; smooth: of `smooth_surfaces`. pose: (4, 4) [m], where it begins."""

    def __init__(
        self,
        config: CameraConfig,
        world: CastWorld,
        looks: Looks,
        smooth: Mapping[int, Smooth],
        samples: int,
        pose: np.ndarray,
    ) -> None:
        self.world = world
        self._config, self._looks = config, looks
        kept = [number for number, one in enumerate(world.surfaces) if isinstance(one, Plane) or len(one.triangles)]
        self._numbers = np.array(kept, np.uint32)
        self._centres = np.zeros((len(kept), 3))
        shapes = []
        for row, number in enumerate(kept):
            surface = world.surfaces[number]
            if isinstance(surface, Mesh):
                self._centres[row] = surface.vertices.mean(axis=0)
            shapes.append(_shape(surface, self._centres[row], number, looks, smooth, config.exposure))
        radii = np.array([np.linalg.norm(shape.vertices, axis=1).max() for shape in shapes])
        away = np.linalg.norm(self._poses(pose, None)[:, :3, 3], axis=1) + radii
        reach = np.clip(away[radii < PLANE_M].max(initial=1.0), 1.0, SHADOWS_M)
        self._scene = DrawnScene(shapes, config.size, samples, float(reach))
        self._surface_of = np.append(np.arange(len(world.surfaces), dtype=np.int32), np.int32(NO_SURFACE))
        self._rays = CameraRays(config.lens)
        self._groups: tuple[frozenset[str], np.ndarray] | None = None

    @property
    def most_lights(self) -> int:
        """How many lights it shows."""
        return MOST_LAMPS

    def close(self) -> None:
        """Frees what the driver holds."""
        self._scene.close()

    def look(self, pose: np.ndarray, state: Any, exclude: frozenset[str]) -> View:
        """What the camera at `pose` (4, 4) float64 [m] sees in a state of the world; without normals."""
        self._place(pose, state, exclude)
        depth, shapes = self._scene.depth(self._eye(pose))
        number = np.full(depth.size, NOTHING)
        seen = np.flatnonzero(shapes >= 0)
        number[seen] = self._numbers[shapes.ravel()[seen]]
        reach = depth.ravel()
        distance = reach if self._rays.along is None else reach / self._rays.along
        hits = Hits(np.asarray(distance, np.float32), None, number, self._surface_of)
        return View(self._rays, self._rays.bundle(pose, exclude, grid=False), hits, reach)

    def radiance(self, view: View, pose: np.ndarray, lighting: Lighting) -> np.ndarray:
        """(n, 3) float32 [nit] of each pixel of the last look, linear."""
        exposure = np.float32(self._config.exposure)
        ambient = lighting.sky + sum(
            (sky.irradiance(AXES).mean(axis=1) / np.float32(np.pi) for sky in lighting.skies), 0
        )
        lamps = sorted(_lamps(lighting, float(exposure)), key=lambda lamp: -float(lamp.color.max()))
        drawn = self._scene.picture(self._eye(pose), lamps[:MOST_LAMPS], ambient * exposure)
        light = drawn.reshape(-1, 3) * np.float32(1 / 255 / max(float(exposure), 1e-30))
        nothing = np.flatnonzero(view.depth > FARTHEST_M)
        light[nothing] = lighting.sky
        directions = np.take(view.bundle.directions, nothing, axis=1)
        for sky in lighting.skies:
            light[nothing] += sky.radiance(directions)
        return light

    def _eye(self, pose: np.ndarray) -> Eye:
        lens, here = self._config.lens, pose.copy()
        here[:3, 3] = 0
        sides = (-lens.cx / lens.fx, (lens.width - lens.cx) / lens.fx)
        ends = ((lens.cy - lens.height) / lens.fy, lens.cy / lens.fy)
        near = max(self._config.near, NEAREST_M)
        return Eye(here, self._config.size, (*sides, *ends), near, self._config.far, isinstance(lens, ParallelLens))

    def _poses(self, pose: np.ndarray, state: Any) -> np.ndarray:
        """(n, 4, 4) [m], where the shapes are from the camera."""
        world = self.world
        bodies = world.body_poses(state)
        poses = np.tile(np.eye(4), (len(self._numbers), 1, 1))
        for row, number in enumerate(self._numbers.tolist()):
            surface, body = world.surfaces[number], int(world.body_of[number])
            if isinstance(surface, Plane):
                poses[row] = _facing(*world.plane(number, bodies), pose[:3, 3])
                continue
            if body >= 0 and bodies is not None:
                poses[row] = bodies[body]
            poses[row, :3, 3] += poses[row, :3, :3] @ self._centres[row] - pose[:3, 3]
        return poses

    def _place(self, pose: np.ndarray, state: Any, exclude: frozenset[str]) -> None:
        world = self.world
        if self._groups is None or self._groups[0] != exclude:
            paths = [str(world.surfaces[number].path) for number in self._numbers.tolist()]
            groups = np.where(self._looks.hidden[self._numbers], DARK, SHOWN)
            groups[[excluded(path, exclude) for path in paths]] = ABSENT
            self._groups = exclude, groups
        self._scene.place(self._poses(pose, state), self._groups[1])


def _facing(origin: np.ndarray, normal: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """(4, 4) of a frame in a plane below the eye, from which it is placed; its z is the normal."""
    out = np.eye(4)
    side = np.eye(3)[int(np.argmin(np.abs(normal)))]
    x = np.cross(side, normal)
    x /= np.linalg.norm(x)
    out[:3, :3] = np.stack([x, np.cross(normal, x), normal], axis=1)
    out[:3, 3] = normal * ((origin - eye) @ normal)
    return out


def _shape(
    surface: Any, centre: np.ndarray, number: int, looks: Looks, smooth: Mapping[int, Smooth], exposure: float
) -> Shape:
    if isinstance(surface, Plane):
        vertices = PLANE_M * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        triangles = np.array([[0, 1, 2], [0, 2, 3]])
        normals = np.tile([0.0, 0, 1], (2, 3, 1))
    else:
        vertices, triangles = surface.vertices - centre, surface.triangles.astype(np.int64)
        first, second, third = np.moveaxis(vertices[triangles], 1, 0)
        flat = _unit(np.cross(second - first, third - first))
        normals = np.repeat(flat[:, None], 3, axis=1)
        if number in smooth:
            normals = _unit(smooth[number].normals.values.astype(np.float64))
            normals *= np.where((normals * flat[:, None]).sum(axis=2, keepdims=True) < 0, -1.0, 1.0)
    paint = looks.bases.get(number)
    color = looks.base[number] if paint is None else _mean(paint)
    glow = float(looks.emitted[number].max()) * exposure / max(float(color.max()), 1e-3)
    if isinstance(paint, Textured):
        return Shape(vertices, triangles, normals, np.ones(3), glow, _pixels(paint), paint.places.values)
    return Shape(vertices, triangles, normals, np.clip(color, 0, 1), glow)


def _unit(vectors: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.nan_to_num(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)))


def _mean(paint: Paint) -> np.ndarray:
    return np.asarray(paint.values.mean(axis=(0, 1)) if isinstance(paint, ByCorner) else np.ones(3))


def _pixels(paint: Textured) -> np.ndarray:
    """(height, width, 3) uint8, linear."""
    texture = paint.texture
    height, width = texture.image.pixels.shape[1:]
    index = np.arange(height * width)
    planes = [texture.linear(index, each) * texture.scale[each] + texture.bias[each] for each in paint.channels]
    light = np.clip(np.stack(planes, axis=1), 0, 1)
    return np.asarray(np.round(light * 255), np.uint8).reshape(height, width, len(planes))


def _lamps(lighting: Lighting, exposure: float) -> Iterator[Lamp]:
    for light in lighting.lights:
        color = light.color * np.float32(exposure / np.pi)
        if light.far:
            yield Lamp(color, -light.place, shadows=light.shadows)
        elif light.carried:
            yield Lamp(color, np.array([0.0, 0, -1]), light.place, fades=False, shadows=False)
        else:
            yield _near(light, color * np.float32(len(light.patches)))


def _near(light: Light, color: np.ndarray) -> Lamp:
    """A flat light is a spot of a half sphere, with a cosine."""
    cutoff, focus = (90.0, 1.0) if light.flat else (180.0, 0.0)
    if light.cone is not None:
        edge, _, aside = light.cone
        cutoff, focus = min(cutoff, float(np.degrees(np.arccos(edge)))), focus + aside
    return Lamp(color, light.axis, light.place, cutoff=cutoff, focus=focus, shadows=light.shadows)
