"""The images of a camera: what its rays meet, or OpenGL draws, as arrays of the requested channels."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.plugins import BACKENDS, required
from graph.base.records import dataclass
from graph.sim.devices import plugin_of
from graph.sim.options import RAYS
from graph.sim.renderer.schedule import Tick
from graph.sim.settings import CAMERA_TONE, TONE_ACES
from sensors.raycast.shadows import Shadows
from sensors.raycast.shared import cast_world
from sensors.runtime import Measurement

from .boxes import boxes_of
from .channels import AROUND, BOX, CROSS, HDR, INSTANCE, LABELLED, LIT, LOOSE, RGB, SEMANTIC, TIGHT
from .correspondence import INVALID, Instant, Reference, correspondence, motion_vectors, reference_of
from .entities import PixelNumbers, entities_of
from .line_exposure import LineExposure
from .picture import Pictures, has_projector, light_places, looks_of
from .rays import CameraRays
from .shading import aces_curve, srgb
from .smooth import smooth_surfaces, smoothen
from .view import View, look

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView
    from sensors.raycast.world import CastWorld

    from .runtime import CameraRuntime

NUMBERED = (INSTANCE, LABELLED, SEMANTIC)
DRAWN = frozenset(
    {RGB, INSTANCE, LABELLED, SEMANTIC, "distance_to_camera", "distance_to_image_plane", "points", "motion_vectors"}
)
"""The channels that OpenGL draws with `camera.backend=gl`; the others are cast."""
MOST_HALF = 65504.0
"""The largest number of float16."""
BOXES = frozenset({TIGHT, LOOSE, BOX, AROUND})
Images = list[tuple[str, np.ndarray]]
"""Channels, each with a row for every pixel, or for every box."""
Key = tuple[Any, ...]


@dataclass(slots=True)
class _Kept:
    """The images of a tick, which are those of the next while the key stays. light: of colours with noise [nit]."""

    key: Key | None
    arrays: dict[str, np.ndarray]
    light: np.ndarray | None


@dataclass(slots=True)
class _Shot:
    """What an image shows: the world at a tick from a pose (4, 4) float64 [m], or from one for each line, in the
    requested channels.
    """

    camera: CameraRuntime
    tick: Tick
    world: CastWorld
    pose: np.ndarray
    wanted: frozenset[str]
    lines: LineExposure | None


class Imager:
    """Makes the images of one camera as it is configured now; it keeps the rays of its lens and what it drew with."""

    def __init__(self, camera: CameraRuntime) -> None:
        self._path, self._exclude = camera.path, camera.exclude
        self._config, self._history = camera.config, camera.history
        self._numbers = PixelNumbers()
        self._rays: CameraRays | None = None
        self._pictures: Pictures | None = None
        self._drawn: Any = None
        self._device: Any = None
        self._before: Instant | None = None
        self._kept: _Kept | None = None
        self._between: tuple[CastWorld, frozenset[str], Shadows] | None = None

    def reset(self) -> None:
        """Forgets where everything was."""
        self._put_away()
        self._before = self._kept = None

    def measure(self, camera: CameraRuntime, tick: Tick, number: int) -> Measurement:
        """The image of a tick, the frame `number`. Its arrays are read-only: frames of what stands share them."""
        wanted, pose = camera.channels(), camera.pose(tick.poses)
        arrays: dict[str, np.ndarray] = {}
        if wanted:
            shot = _Shot(camera, tick, cast_world(tick.scene), pose, wanted, self._lines(tick))
            arrays = self._arrays(shot, number)
        width, height = self._config.size
        return Measurement(arrays, width * height, None if self._history is not None else (pose, pose))

    def _arrays(self, shot: _Shot, number: int) -> dict[str, np.ndarray]:
        key = self._standing(shot)
        shown = self._kept
        if shown is None or key is None or shown.key != key:
            shown = self._made(shot, key)
            self._kept = None if key is None else shown
        if shown.light is None:
            return dict(shown.arrays)
        return {**shown.arrays, RGB: self._locked(RGB, self._picture(shot, shown.light, number))}

    def _made(self, shot: _Shot, key: Key | None) -> _Kept:
        """The images of a tick, drawn or cast; without the colours that have noise, but with their light."""
        wanted = shot.wanted
        images: Images = []
        light, by_rays, cast = None, None, wanted
        noisy = shot.tick.scene.fidelity.camera_noise
        if wanted & DRAWN and self._draws(shot):
            images, light = self._draw(shot, wanted & DRAWN)
            cast = wanted - DRAWN
        colours = cast & LIT
        if colours and (shaded := self._shaded(shot, light=noisy or HDR in colours)) is not None:
            cast = cast - LIT
            if shaded.dtype == np.uint8:
                images.append((RGB, shaded))
            else:
                by_rays = shaded
        if cast:
            found, seen = self._cast(shot, cast)
            images += found
            by_rays = by_rays if seen is None else seen
        if by_rays is not None:
            light = by_rays if RGB in colours else light
            if HDR in colours:
                images.append((HDR, np.clip(by_rays, 0, MOST_HALF).astype(np.float16)))
        if light is not None and RGB in wanted and not noisy:
            images.append((RGB, self._picture(shot, light)))
        arrays = {name: self._locked(name, array) for name, array in images}
        return _Kept(key, arrays, light if noisy and RGB in wanted else None)

    def _locked(self, name: str, array: np.ndarray) -> np.ndarray:
        """An array of a frame, which nobody may write; images by rows."""
        width, height = self._config.size
        shaped = array if name in BOXES else array.reshape(height, width, *array.shape[1:])
        shaped.setflags(write=False)
        return shaped

    def _standing(self, shot: _Shot) -> Key | None:
        """What decides what the images show: equal where nothing changed; None where it is not known."""
        scene, poses = shot.tick.scene, shot.tick.poses
        world, wanted, lines = shot.world, shot.wanted, shot.lines
        if world.soft or scene.live is None:
            return None
        if lines is not None and not lines.rests(world):
            return None
        bodies = world.body_poses(poses)
        settings = scene.fidelity.camera_backend, scene.fidelity.camera_noise, scene.settings.get(CAMERA_TONE)
        places = [shot.pose if lines is None else lines.poses(), *([] if bodies is None else [bodies])]
        if wanted & LIT:
            places.append(light_places(world, poses))
        if CROSS in wanted and (other := self._other(scene)) is not None:
            places.append(other.pose(poses))
        before = self._before
        moves = "motion_vectors" in wanted and before is not None and before.world is world
        if moves and before is not None:
            places += [before.pose, *([] if before.bodies is None else [before.bodies])]
        return world, scene.live.watch.edits, wanted, moves, settings, [place.tobytes() for place in places]

    def _lines(self, tick: Tick) -> LineExposure | None:
        shutter = self._config.shutter
        if shutter is None or self._history is None:
            return None
        return LineExposure(shutter, self._config.size, self._history, self._path, tick.time)

    def _colours(self, camera: CameraRuntime) -> Pictures:
        if self._pictures is None:
            self._pictures = Pictures(self._path, self._config, self._exclude, camera.samples())
        return self._pictures

    def _draws(self, shot: _Shot) -> bool:
        """Whether OpenGL draws; if it should and cannot, a warning says why."""
        scene, world = shot.tick.scene, shot.world
        if scene.fidelity.camera_backend == RAYS:
            return False
        reason: str = _drawing(scene).reason_for_rays(world, self._config)
        if not reason and has_projector(world):
            reason = "its scene has a projector"
        if reason:
            said = f"{reason}, which OpenGL does not show: its images are cast by rays"
            scene.warn("camera-by-rays", self._path, said)
        return not reason

    def _put_away(self) -> None:
        if self._drawn is not None:
            self._drawn.close()
        self._drawn = None

    def _draw(self, shot: _Shot, wanted: frozenset[str]) -> tuple[Images, np.ndarray | None]:
        """Channels in demand as OpenGL draws them, and the light [nit] of each pixel if colours are among them."""
        scene, world, pose, poses = shot.tick.scene, shot.world, shot.pose, shot.tick.poses
        if self._drawn is None or self._drawn.world is not world:
            self._put_away()
            looks, smooth = looks_of(world), smooth_surfaces(world)
            made, samples = _drawing(scene).DrawnCamera, scene.fidelity.camera_samples
            self._drawn = made(self._config, world, looks, smooth, samples, pose)
        drawn = self._drawn
        view = drawn.look(pose, poses, self._exclude)
        images, light = self._images(view, shot, wanted), None
        if RGB in wanted:
            lighting = self._colours(shot.camera).lighting(world, pose, poses)
            if (count := len(lighting.lights)) > drawn.most_lights:
                said = f"OpenGL shows the {drawn.most_lights} brightest of its {count} lights"
                scene.warn("lights-left-out", self._path, f"{said}; camera.backend=rays shows all")
            light = drawn.radiance(view, pose, lighting)
        return images, light

    def _shaded(self, shot: _Shot, *, light: bool) -> np.ndarray | None:
        """The colours (n, 3) of each pixel as the scene's device shades them: uint8, or float32 [nit] of `light`; None
        where it cannot.
        """
        scene, world, poses = shot.tick.scene, shot.world, shot.tick.poses
        colours = self._colours(shot.camera)
        if world.device is None or shot.lines is not None or shot.camera.group or colours.samples > 1:
            return None
        if smooth_surfaces(world):
            return None
        if self._device is None or self._device.world is not world:
            self._device = plugin_of(scene.fidelity.device).DeviceCamera(
                world, self._config, self._exclude, looks_of(world)
            )
        lighting = colours.lighting(world, shot.pose, poses)
        if not self._device.fits(lighting):
            return None
        aces = scene.settings.get(CAMERA_TONE) == TONE_ACES
        shaded: np.ndarray | None = self._device.shade(shot.pose, poses, lighting, light=light, aces=aces)
        return shaded

    def _cast(self, shot: _Shot, wanted: frozenset[str]) -> tuple[Images, np.ndarray | None]:
        """Channels in demand by rays from a pose, and the light [nit] of each pixel if colours are among them."""
        world, poses = shot.world, shot.tick.poses
        lit = bool(wanted & LIT) and self._colours(shot.camera).samples == 1
        normals = lit or "normals" in wanted
        shapes = smooth_surfaces(world) if normals else {}
        spots = bool(shapes) or (lit and looks_of(world).vary)
        view = self._look(shot, normals=normals, spots=spots)
        smoothen(view, shapes, world, poses)
        images, light = self._images(view, shot, wanted), None
        if wanted & LIT:
            light = self._colours(shot.camera).radiance(view, shot.pose, poses, world, shot.lines)
        if wanted & BOXES:
            labelled = dict(images).get(LABELLED)
            numbers = self._numbered(view, world, LABELLED) if labelled is None else labelled
            images += boxes_of(world, view, self._config, poses, numbers, wanted).items()
        return images, light

    def _look(self, shot: _Shot, *, normals: bool, spots: bool) -> View:
        """What is seen from a pose: with the cameras of the group if it can be."""
        world, tick, group = shot.world, shot.tick, shot.camera.group
        together = group and group.view(shot.camera, world, tick, normals=normals, spots=spots)
        if together:
            return together
        if self._rays is None:
            self._rays = CameraRays(self._config.lens)
            if self._rays.dark is not None and len(self._rays.dark) == len(self._rays):
                said = "its lens gives no pixel a direction: it sees nothing"
                tick.scene.warn("lens-without-rays", self._path, said)
        rays, config, hidden = self._rays, self._config, self._exclude
        return look(world, rays, config, shot.pose, tick.poses, hidden, normals=normals, spots=spots, lines=shot.lines)

    def _images(self, view: View, shot: _Shot, wanted: frozenset[str]) -> Images:
        """Channels in demand, each with a row for every pixel."""
        hits = view.hits
        found: Images = []
        if "distance_to_camera" in wanted:
            found.append(("distance_to_camera", hits.distance))
        if "distance_to_image_plane" in wanted:
            found.append(("distance_to_image_plane", view.depth))
        if "normals" in wanted:
            found.append(("normals", view.facing_normals()))
        if "points" in wanted:
            found.append(("points", view.points()))
        if "motion_vectors" in wanted:
            found.append(("motion_vectors", self._motion(view, shot)))
        if CROSS in wanted:
            found.append((CROSS, self._correspondence(view, shot)))
        return found + [(name, self._numbered(view, shot.world, name)) for name in NUMBERED if name in wanted]

    def _numbered(self, view: View, world: CastWorld, name: str) -> np.ndarray:
        hits = view.hits
        return self._numbers.of(entities_of(world, name).numbers, name, hits.surface_of, hits.number)

    def _picture(self, shot: _Shot, light: np.ndarray, number: int = 0) -> np.ndarray:
        """(n, 3) uint8, sRGB, of light (n, 3) [nit]; with the noise of the frame `number`, if there is noise."""
        signal = light * np.float32(self._config.exposure)
        scene = shot.tick.scene
        if scene.fidelity.camera_noise:
            signal = self._config.noise.applied(signal, scene.seed, self._path, number)
        aces = scene.settings.get(CAMERA_TONE) == TONE_ACES
        return srgb(aces_curve(signal) if aces else signal)

    def _other(self, scene: WorldView) -> CameraRuntime | None:
        """The camera whose image is compared; without one None, and a warning."""
        try:
            return reference_of(scene, self._path)
        except UserError as problem:
            what = str(problem).removeprefix(f"{self._path}: ")
            scene.warn("no-second-camera", self._path, f"{what}; its offsets are -1")
            return None

    def _correspondence(self, view: View, shot: _Shot) -> np.ndarray:
        other = self._other(shot.tick.scene)
        if other is None:
            return np.full((len(view.depth), 4), INVALID, np.float32)
        world, exclude, poses = shot.world, self._exclude | other.exclude, shot.tick.poses
        if self._between is None or self._between[0] is not world or self._between[1] != exclude:
            self._between = world, exclude, Shadows(world, exclude)
        reference = Reference(other.config.lens, other.pose(poses))
        return correspondence(view, self._config.lens, reference, self._between[2], poses)

    def _motion(self, view: View, shot: _Shot) -> np.ndarray:
        bodies = shot.world.body_poses(shot.tick.poses)
        now = Instant(shot.world, shot.pose, None if bodies is None else bodies.copy())
        before = self._before
        self._before = now
        return motion_vectors(self._config.lens, view, before, now)


def _drawing(scene: WorldView) -> ModuleType:
    """The plug-in that draws images: `DrawnCamera`, and `reason_for_rays` for what it cannot draw."""
    return required(BACKENDS, scene.fidelity.camera_backend, ModuleType, "camera backend")
