"""The images of a camera: what its rays meet, or OpenGL draws, as arrays of the requested channels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.sim.renderer.schedule import Tick
from graph.sim.settings import CAMERA_TONE, TONE_ACES
from sensors.raycast.shadows import Shadows
from sensors.raycast.shared import cast_world
from sensors.runtime import Measurement, Model

from .boxes import boxes_of
from .channels import AROUND, BOX, CROSS, HDR, INSTANCE, LABELLED, LIT, LOOSE, RGB, SEMANTIC, TIGHT
from .correspondence import INVALID, Reference, correspondence, reference_of
from .entities import PixelNumbers, entities_of
from .line_exposure import LineExposure
from .motion import Instant, motion_vectors
from .picture import Pictures, has_projector, light_places, looks_of
from .rays import CameraRays
from .shading import aces_curve, srgb
from .smooth import smooth_surfaces, smoothen
from .view import View, look

if TYPE_CHECKING:
    from sensors.device.camera import DeviceCamera
    from sensors.raycast.world import CastWorld

    from .drawn import DrawnCamera
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


class Imager(Model["CameraRuntime"]):
    """Makes the images of one camera as it is configured now; it keeps the rays of its lens and what it drew with."""

    def __init__(self, camera: CameraRuntime) -> None:
        super().__init__(camera)
        self._config, self._history = camera.config, camera.history
        self._numbers = PixelNumbers()
        self._rays: CameraRays | None = None
        self._pictures: Pictures | None = None
        self._drawn: DrawnCamera | None = None
        self._device: DeviceCamera | None = None
        self._before: Instant | None = None
        self._kept: _Kept | None = None
        self._between: tuple[CastWorld, frozenset[str], Shadows] | None = None

    def reset(self) -> None:
        """Forgets where everything was."""
        self._put_away()
        self._before = self._kept = None

    def measure(self, tick: Tick, number: int) -> Measurement:
        """The image of a tick, the frame `number`. Its arrays are read-only: frames of what stands share them."""
        wanted, pose = self._sensor.channels(), self._sensor.pose(tick.poses)
        arrays = self._arrays(tick, wanted, pose, number) if wanted else {}
        width, height = self._config.size
        return Measurement(arrays, width * height, None if self._history is not None else (pose, pose))

    def _arrays(self, tick: Tick, wanted: frozenset[str], pose: np.ndarray, number: int) -> dict[str, np.ndarray]:
        lines = self._lines(tick)
        key = self._standing(tick, wanted, pose, lines)
        shown = self._kept
        if shown is None or key is None or shown.key != key:
            shown = self._made(tick, wanted, pose, lines, key)
            self._kept = None if key is None else shown
        if shown.light is None:
            return dict(shown.arrays)
        return {**shown.arrays, RGB: self._locked(RGB, self._picture(shown.light, number))}

    def _made(
        self, tick: Tick, wanted: frozenset[str], pose: np.ndarray, lines: LineExposure | None, key: Key | None
    ) -> _Kept:
        """The images of a tick, drawn or cast; without the colours that have noise, but with their light."""
        images: Images = []
        light, by_rays, cast = None, None, wanted
        noisy = self._app.fidelity.camera_noise
        if wanted & DRAWN and self._draws():
            images, light = self._draw(tick, pose, wanted & DRAWN)
            cast = wanted - DRAWN
        colours = cast & LIT
        if colours and (shaded := self._shaded(tick, pose, lines, light=noisy or HDR in colours)) is not None:
            cast = cast - LIT
            if shaded.dtype == np.uint8:
                images.append((RGB, shaded))
            else:
                by_rays = shaded
        if cast:
            found, seen = self._cast(tick, cast, pose, lines)
            images += found
            by_rays = by_rays if seen is None else seen
        if by_rays is not None:
            light = by_rays if RGB in colours else light
            if HDR in colours:
                images.append((HDR, np.clip(by_rays, 0, MOST_HALF).astype(np.float16)))
        if light is not None and RGB in wanted and not noisy:
            images.append((RGB, self._picture(light)))
        arrays = {name: self._locked(name, array) for name, array in images}
        return _Kept(key, arrays, light if noisy and RGB in wanted else None)

    def _locked(self, name: str, array: np.ndarray) -> np.ndarray:
        """An array of a frame, which nobody may write; images by rows."""
        width, height = self._config.size
        shaped = array if name in BOXES else array.reshape(height, width, *array.shape[1:])
        shaped.setflags(write=False)
        return shaped

    def _standing(self, tick: Tick, wanted: frozenset[str], pose: np.ndarray, lines: LineExposure | None) -> Key | None:
        """What decides what the images show: equal where nothing changed; None where it is not known."""
        app, poses = self._app, tick.poses
        world = cast_world(app)
        if world.soft or app.live is None:
            return None
        if lines is not None and not lines.rests(world):
            return None
        bodies = world.body_poses(poses)
        settings = app.fidelity.camera_backend, app.fidelity.camera_noise, app.settings.get(CAMERA_TONE)
        places = [pose if lines is None else lines.poses(), *([] if bodies is None else [bodies])]
        if wanted & LIT:
            places.append(light_places(app, world, poses))
        if CROSS in wanted and (other := self._other()) is not None:
            places.append(other.pose(poses))
        before = self._before
        moves = "motion_vectors" in wanted and before is not None and before.world is world
        if moves and before is not None:
            places += [before.pose, *([] if before.bodies is None else [before.bodies])]
        return world, app.live.watch.edits, wanted, moves, settings, [place.tobytes() for place in places]

    def _lines(self, tick: Tick) -> LineExposure | None:
        shutter = self._config.shutter
        if shutter is None or self._history is None:
            return None
        return LineExposure(shutter, self._config.size, self._history, self._path, tick.time)

    def _colours(self) -> Pictures:
        if self._pictures is None:
            self._pictures = Pictures(self._path, self._config, self._exclude, self._sensor.samples())
        return self._pictures

    def _draws(self) -> bool:
        """Whether OpenGL draws; if it should and cannot, a warning says why."""
        app = self._app
        if app.fidelity.camera_backend != "gl":
            return False
        from .drawn import reason_for_rays

        world = cast_world(app)
        reason = reason_for_rays(world, self._config)
        if not reason and has_projector(app, world):
            reason = "its scene has a projector"
        if reason:
            app.warn("camera-by-rays", self._path, f"{reason}, which OpenGL does not show: its images are cast by rays")
        return not reason

    def _put_away(self) -> None:
        if self._drawn is not None:
            self._drawn.close()
        self._drawn = None

    def _draw(self, tick: Tick, pose: np.ndarray, wanted: frozenset[str]) -> tuple[Images, np.ndarray | None]:
        """Channels in demand as OpenGL draws them, and the light [nit] of each pixel if colours are among them."""
        from .drawn import DrawnCamera

        app = self._app
        world = cast_world(app)
        if self._drawn is None or self._drawn.world is not world:
            self._put_away()
            looks, smooth, samples = looks_of(app, world), smooth_surfaces(app, world), app.fidelity.camera_samples
            self._drawn = DrawnCamera(self._config, world, looks, smooth, samples, pose)
        drawn = self._drawn
        view = drawn.look(pose, tick.poses, self._exclude)
        images, light = self._images(view, tick, wanted), None
        if RGB in wanted:
            lighting = self._colours().lighting(app, world, pose, tick.poses)
            if (count := len(lighting.lights)) > drawn.most_lights:
                said = f"OpenGL shows the {drawn.most_lights} brightest of its {count} lights"
                app.warn("lights-left-out", self._path, f"{said}; camera.backend=rays shows all")
            light = drawn.radiance(view, pose, lighting)
        return images, light

    def _shaded(self, tick: Tick, pose: np.ndarray, lines: LineExposure | None, *, light: bool) -> np.ndarray | None:
        """The colours (n, 3) of each pixel as the App's device shades them: uint8, or float32 [nit] of `light`; None
        where it cannot.
        """
        app, colours = self._app, self._colours()
        world = cast_world(app)
        if world.device is None or lines is not None or self._sensor.group or colours.samples > 1:
            return None
        from sensors.device.camera import DeviceCamera
        from sensors.device.world import DeviceWorld

        if not isinstance(world, DeviceWorld) or smooth_surfaces(app, world):
            return None
        if self._device is None or self._device.world is not world:
            self._device = DeviceCamera(world, self._config, self._exclude, looks_of(app, world))
        lighting = colours.lighting(app, world, pose, tick.poses)
        if not self._device.fits(lighting):
            return None
        aces = app.settings.get(CAMERA_TONE) == TONE_ACES
        return self._device.shade(pose, tick.poses, lighting, light=light, aces=aces)

    def _cast(
        self, tick: Tick, wanted: frozenset[str], pose: np.ndarray, lines: LineExposure | None
    ) -> tuple[Images, np.ndarray | None]:
        """Channels in demand by rays from a pose, and the light [nit] of each pixel if colours are among them."""
        app = self._app
        world = cast_world(app)
        lit = bool(wanted & LIT) and self._colours().samples == 1
        normals = lit or "normals" in wanted
        shapes = smooth_surfaces(app, world) if normals else {}
        spots = bool(shapes) or (lit and looks_of(app, world).vary)
        view = self._look(world, tick, pose, lines, normals=normals, spots=spots)
        smoothen(view, shapes, world, tick.poses)
        images, light = self._images(view, tick, wanted), None
        if wanted & LIT:
            light = self._colours().radiance(app, view, pose, tick.poses, world, lines)
        if wanted & BOXES:
            labelled = dict(images).get(LABELLED)
            numbers = self._numbered(view, LABELLED) if labelled is None else labelled
            images += boxes_of(app, view, self._config, tick.poses, numbers, wanted).items()
        return images, light

    def _look(
        self,
        world: CastWorld,
        tick: Tick,
        pose: np.ndarray,
        lines: LineExposure | None,
        *,
        normals: bool,
        spots: bool,
    ) -> View:
        """What is seen from a pose: with the cameras of the group if it can be."""
        group = self._sensor.group
        together = group and group.view(self._sensor, world, tick, normals=normals, spots=spots)
        if together:
            return together
        if self._rays is None:
            self._rays = CameraRays(self._config.lens)
            if self._rays.dark is not None and len(self._rays.dark) == len(self._rays):
                self._app.warn("lens-without-rays", self._path, "its lens gives no pixel a direction: it sees nothing")
        rays, config, hidden = self._rays, self._config, self._exclude
        return look(world, rays, config, pose, tick.poses, hidden, normals=normals, spots=spots, lines=lines)

    def _images(self, view: View, tick: Tick, wanted: frozenset[str]) -> Images:
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
            found.append(("motion_vectors", self._motion(view, tick)))
        if CROSS in wanted:
            found.append((CROSS, self._correspondence(view, tick)))
        return found + [(name, self._numbered(view, name)) for name in NUMBERED if name in wanted]

    def _numbered(self, view: View, name: str) -> np.ndarray:
        hits = view.hits
        return self._numbers.of(entities_of(self._app, name).numbers, name, hits.surface_of, hits.number)

    def _picture(self, light: np.ndarray, number: int = 0) -> np.ndarray:
        """(n, 3) uint8, sRGB, of light (n, 3) [nit]; with the noise of the frame `number`, if there is noise."""
        signal = light * np.float32(self._config.exposure)
        if self._app.fidelity.camera_noise:
            signal = self._config.noise.applied(signal, self._app.seed, self._path, number)
        aces = self._app.settings.get(CAMERA_TONE) == TONE_ACES
        return srgb(aces_curve(signal) if aces else signal)

    def _other(self) -> CameraRuntime | None:
        """The camera whose image is compared; without one None, and a warning."""
        try:
            return reference_of(self._app, self._path)
        except UserError as problem:
            what = str(problem).removeprefix(f"{self._path}: ")
            self._app.warn("no-second-camera", self._path, f"{what}; its offsets are -1")
            return None

    def _correspondence(self, view: View, tick: Tick) -> np.ndarray:
        other = self._other()
        if other is None:
            return np.full((len(view.depth), 4), INVALID, np.float32)
        world, exclude = cast_world(self._app), self._exclude | other.exclude
        if self._between is None or self._between[0] is not world or self._between[1] != exclude:
            self._between = world, exclude, Shadows(world, exclude)
        reference = Reference(other.config.lens, other.pose(tick.poses))
        return correspondence(view, self._config.lens, reference, self._between[2], tick.poses)

    def _motion(self, view: View, tick: Tick) -> np.ndarray:
        world = cast_world(self._app)
        bodies = world.body_poses(tick.poses)
        now = Instant(world, self._sensor.pose(tick.poses), None if bodies is None else bodies.copy())
        before = self._before
        self._before = now
        return motion_vectors(self._config.lens, view, before, now)
