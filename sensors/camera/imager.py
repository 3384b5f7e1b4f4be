"""The images of a camera: what its rays meet, or OpenGL draws, as arrays of the requested channels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
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
from .picture import Pictures, has_projector, looks_of
from .rays import CameraRays
from .shading import aces_curve, srgb
from .smooth import smooth_surfaces, smoothen
from .view import View, look

if TYPE_CHECKING:
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


class Imager(Model["CameraRuntime"]):
    """Makes the images of one camera as it is configured now; it keeps the rays of its lens and what it drew with."""

    def __init__(self, camera: CameraRuntime) -> None:
        super().__init__(camera)
        self._config, self._history = camera.config, camera.history
        self._number = 0
        self._numbers = PixelNumbers()
        self._rays: CameraRays | None = None
        self._pictures: Pictures | None = None
        self._drawn: DrawnCamera | None = None
        self._before: Instant | None = None
        self._between: tuple[CastWorld, frozenset[str], Shadows] | None = None

    def reset(self) -> None:
        """Forgets where everything was."""
        self._put_away()
        self._before = None

    def measure(self, tick: Tick, number: int) -> Measurement:
        """The image of a tick, the frame `number`."""
        self._number = number
        width, height = self._config.size
        wanted, images, pose = self._sensor.channels(), [], None
        if wanted & DRAWN and self._draws():
            pose = self._sensor.pose(tick.poses)
            images, wanted = self._draw(tick, pose, wanted & DRAWN), wanted - DRAWN
        if wanted:
            pose, cast = self._cast(tick, wanted)
            images += cast
        elif pose is None:
            pose = self._sensor.pose(tick.poses)
        arrays = {
            name: array if name in BOXES else array.reshape(height, width, *array.shape[1:]) for name, array in images
        }
        return Measurement(arrays, width * height, None if self._history is not None else (pose, pose))

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

    def _draw(self, tick: Tick, pose: np.ndarray, wanted: frozenset[str]) -> list[tuple[str, np.ndarray]]:
        """Channels in demand as OpenGL draws them."""
        from .drawn import DrawnCamera

        app = self._app
        world = cast_world(app)
        if self._drawn is None or self._drawn.world is not world:
            self._put_away()
            seen = world, looks_of(app, world), smooth_surfaces(app, world)
            self._drawn = DrawnCamera(self._config, *seen, app.fidelity.camera_samples, pose)
        drawn = self._drawn
        view = drawn.look(pose, tick.poses, self._exclude)
        images = self._images(view, tick, wanted)
        if RGB in wanted:
            lighting = self._colours().lighting(app, world, pose, tick.poses)
            if (count := len(lighting.lights)) > drawn.most_lights:
                said = f"OpenGL shows the {drawn.most_lights} brightest of its {count} lights"
                app.warn("lights-left-out", self._path, f"{said}; camera.backend=rays shows all")
            images += self._lit(drawn.radiance(view, pose, lighting), wanted)
        return images

    def _cast(self, tick: Tick, wanted: frozenset[str]) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
        """The pose, (4, 4) float64 [m], and channels in demand by rays."""
        app = self._app
        world, lines = cast_world(app), self._lines(tick)
        lit = bool(wanted & LIT) and self._colours().samples == 1
        normals = lit or "normals" in wanted
        shapes = smooth_surfaces(app, world) if normals else {}
        spots = bool(shapes) or (lit and looks_of(app, world).vary)
        pose, view = self._look(world, tick, lines, normals=normals, spots=spots)
        smoothen(view, shapes, world, tick.poses)
        images = self._images(view, tick, wanted)
        if wanted & LIT:
            images += self._lit(self._colours().radiance(app, view, pose, tick.poses, world, lines), wanted)
        if wanted & BOXES:
            labelled = dict(images).get(LABELLED)
            numbers = self._numbered(view, LABELLED) if labelled is None else labelled
            images += boxes_of(app, view, self._config, tick.poses, numbers, wanted).items()
        return pose, images

    def _look(
        self, world: CastWorld, tick: Tick, lines: LineExposure | None, *, normals: bool, spots: bool
    ) -> tuple[np.ndarray, View]:
        """The pose, (4, 4) float64 [m], and what is seen: with the cameras of the group if it can be."""
        camera = self._sensor
        together = camera.group and camera.group.view(camera, world, tick, normals=normals, spots=spots)
        if together:
            return together
        if self._rays is None:
            self._rays = CameraRays(self._config.lens)
            if self._rays.dark is not None and len(self._rays.dark) == len(self._rays):
                self._app.warn("lens-without-rays", self._path, "its lens gives no pixel a direction: it sees nothing")
        pose = camera.pose(tick.poses)
        seen = world, self._rays, self._config, pose, tick.poses, self._exclude
        return pose, look(*seen, normals=normals, spots=spots, lines=lines)

    def _images(self, view: View, tick: Tick, wanted: frozenset[str]) -> list[tuple[str, np.ndarray]]:
        """Channels in demand, each with a row for every pixel."""
        hits = view.hits
        found: list[tuple[str, np.ndarray]] = []
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

    def _lit(self, light: np.ndarray, wanted: frozenset[str]) -> list[tuple[str, np.ndarray]]:
        """Channels in demand that hold light [nit]."""
        found: list[tuple[str, np.ndarray]] = []
        if HDR in wanted:
            found.append((HDR, np.clip(light, 0, MOST_HALF).astype(np.float16)))
        if RGB in wanted:
            signal = light * np.float32(self._config.exposure)
            if self._app.fidelity.camera_noise:
                signal = self._config.noise.applied(signal, self._app.seed, self._path, self._number)
            aces = self._app.settings.get(CAMERA_TONE) == TONE_ACES
            found.append((RGB, srgb(aces_curve(signal) if aces else signal)))
        return found

    def _correspondence(self, view: View, tick: Tick) -> np.ndarray:
        try:
            other = reference_of(self._app, self._path)
        except UserError as problem:
            what = str(problem).removeprefix(f"{self._path}: ")
            self._app.warn("no-second-camera", self._path, f"{what}; its offsets are -1")
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
        if "motion_vectors" in self._sensor.requested():
            self._before = now
        return motion_vectors(self._config.lens, view, before, now)
