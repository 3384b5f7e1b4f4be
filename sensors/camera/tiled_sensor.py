"""TiledCameraSensor: several cameras of one size at work, as a batch of images or as tiles of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.suggesting import Suggesting
from graph.sim import entered
from sensors.errors import SensorValueError
from sensors.raycast.rays import RayBundle, RayMemory
from sensors.raycast.world import CastWorld, anchor_of
from sensors.sensor import RenderedSensor, short_names
from sensors.sensor_prim import matching_paths

from .camera_view import CameraView
from .lens import ParallelLens
from .names import PRIM_TYPE
from .rays import CameraRays
from .sensor import WIDTHS, CameraSensor, checked_resolution, handed_out
from .view import View, shown

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.schedule import Tick
    from graph.sim.renderer.view import WorldView

    from .runtime import CameraRuntime


Moment = tuple[Any, ...]


class TileGroup:
    """Cameras that are due at the same ticks; the first one that renders casts the rays of all.

    A ray's hit does not depend on the other rays, so each camera gets the bytes that it gets alone.
    """

    def __init__(self, members: Sequence[CameraRuntime]) -> None:
        self._members = list(members)
        for member in self._members:
            member.group = self
        self._rays: list[CameraRays] = []
        self._lens: Any = None
        self._table = np.empty((0, 6), np.float32)
        self._offsets = np.empty((0, 3), np.float32)
        self._memory = RayMemory()
        self._placed = b""
        self._moment: Moment = ()
        self._seen: dict[CameraRuntime, View] = {}

    def view(self, camera: CameraRuntime, world: CastWorld, tick: Tick, *, normals: bool, spots: bool) -> View | None:
        """What one of the cameras sees; None if it has to look alone."""
        if tick.poses is not None:
            return None
        moment = tick.time, world, normals, spots
        if camera not in self._seen or self._moment != moment:
            self._seen, self._moment = self._look(world, normals, spots), moment
        return self._seen.pop(camera, None)

    def _look(self, world: CastWorld, normals: bool, spots: bool) -> dict[CameraRuntime, View]:
        """What each camera sees; empty where they differ, or where a cast depends on who else casts."""
        first, count = self._members[0], len(self._members)
        if not (world.rays_go_everywhere and self._alike()):
            return {}
        poses = [member.pose() for member in self._members]
        places = np.stack([pose[:3, 3] for pose in poses])
        anchor = anchor_of(places[0])
        if (anchor_of(places) != anchor).any() or not world.shares_frame(places - anchor):
            return {}
        if self._lens != first.config.lens:
            self._lens = first.config.lens
            self._table, self._rays = CameraRays(self._lens).copies(count)
            self._placed = b""
        parts = [
            rays.bundle(pose, first.exclude, grid=bool(len(world.moving_surfaces)))
            for rays, pose in zip(self._rays, poses, strict=True)
        ]
        pixels = len(self._rays[0])
        placed = np.stack(poses).tobytes()
        if placed != self._placed:
            self._placed = placed
            self._memory.forget()
            self._offsets = np.repeat((places - anchor).astype(np.float32), pixels, axis=0)
        bundle = RayBundle(anchor, self._table, self._offsets, first.exclude, memory=self._memory, parts=parts)
        hits = world.cast(bundle, normals=normals, spots=spots)
        found = {}
        for number, (member, rays, part) in enumerate(zip(self._members, self._rays, parts, strict=True)):
            own = hits.some(slice(number * pixels, (number + 1) * pixels))
            found[member] = shown(world, rays, first.config, part, own, None)
        return found

    def _alike(self) -> bool:
        """Whether all have one lens, rate and shutter, and leave the same prims out."""
        first = self._members[0]
        if first.config.shutter is not None or isinstance(first.config.lens, ParallelLens):
            return False
        own = first.config, first.rate, first.exclude
        return all((one.config, one.rate, one.exclude) == own for one in self._members)


class TiledCameraSensor(Suggesting):
    """Renders several cameras of one size: a batch of images, or one image of their tiles, row after row.

    paths: of Camera prims, or regular expressions (/World/env_.*/Camera). resolution: height and width of each. Pixels
    are made square, as by `CameraSensor`. There are round(sqrt(N)) rows of tiles, camera k is in row k // columns;
    spare tiles are 0. Annotators: those of `CameraSensor` that give images. Raises SensorValueError as it does.
    """

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        resolution: tuple[int, int],
        annotators: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        names = _checked(annotators)
        scene: WorldView = (entered.current() if app is None else app).world
        given = [paths] if isinstance(paths, str) else [str(path) for path in paths]
        self.paths = [found for path in given for found in matching_paths(scene.stage, path)]
        if not self.paths:
            raise SensorValueError("there is no camera to tile; give the path of one")
        self.render_vars = tuple(render_vars or ())
        self.sensors = [Tile(scene, path, resolution, names) for path in self.paths]
        self.rows = max(1, round(len(self) ** 0.5))
        self.columns = -(-len(self) // self.rows)
        self._given: dict[tuple[str, bool], tuple[list[Any], np.ndarray]] = {}
        self._group = TileGroup([sensor.runtime for sensor in self.sensors])

    def __len__(self) -> int:
        return len(self.paths)

    @property
    def camera(self) -> CameraView:
        """The lenses of the prims."""
        return CameraView([prim for sensor in self.sensors for prim in sensor.camera.prims])

    @property
    def resolution(self) -> tuple[int, int]:
        """Height and width of a tile."""
        return self.sensors[0].resolution

    @property
    def tiled_resolution(self) -> tuple[int, int]:
        """Height and width of the whole image."""
        height, width = self.resolution
        return self.rows * height, self.columns * width

    @property
    def annotators(self) -> list[str]:
        """Names of the attached annotators, sorted."""
        return self.sensors[0].annotators

    def attach_annotators(self, annotators: str | Iterable[str]) -> None:
        """Attaches annotators to every camera."""
        names = _checked(annotators)
        for sensor in self.sensors:
            sensor.attach_annotators(names)

    def detach_annotators(self, annotators: str | Iterable[str]) -> None:
        """Detaches annotators from every camera; a name that is not attached gives a warning."""
        names = _checked(annotators)
        for sensor in self.sensors:
            sensor.detach_annotators(names)

    def get_data(
        self, annotator: str, *, tiled: bool = False, out: np.ndarray | None = None
    ) -> tuple[np.ndarray | None, dict[str, Any]]:
        """(data, info): the images (N, height, width, n), or tiled (rows x height, columns x width, n).

        (None, {}) before every camera has a frame. The data are the caller's own; between ticks the same object again.
        out: an array of that shape that takes the data. info: one for all
        cameras, whose numbers have one meaning. Raises SensorValueError as `CameraSensor.get_data` does.
        """
        (annotator,) = _checked(annotator)
        found = [sensor.get_data(annotator) for sensor in self.sensors]
        if any(data is None for data, _ in found):
            return None, {}
        parts = [data for data, _ in found]
        known = self._given.get((annotator, tiled))
        if known is None or any(one is not other for one, other in zip(known[0], parts, strict=True)):
            images = np.stack(parts)
            known = self._given[annotator, tiled] = parts, self._tiled(images) if tiled else images
        return handed_out(known[1], out), _joined([info for _, info in found])

    def _tiled(self, images: np.ndarray) -> np.ndarray:
        spare = self.rows * self.columns - len(images)
        images = np.concatenate([images, np.zeros((spare, *images.shape[1:]), images.dtype)])
        grid = images.reshape(self.rows, self.columns, *images.shape[1:]).swapaxes(1, 2)
        return grid.reshape(*self.tiled_resolution, images.shape[-1])


class Tile(CameraSensor):
    """One camera of many: a plain Camera prim, which need not have the schema of sensors."""

    def __init__(self, scene: WorldView, path: str, resolution: tuple[int, int], annotators: Iterable[str]) -> None:
        self.resolution = checked_resolution(resolution)
        self._given = {}
        prim = scene.stage.GetPrimAtPath(path)
        if prim.GetTypeName() == PRIM_TYPE and not prim.IsInstanceProxy():  # what nothing can be written on stays
            CameraView(prim).enforce_square_pixels(self.resolution)
        RenderedSensor.__init__(self, scene, path, self.resolution[::-1], annotators)

    @property
    def camera(self) -> CameraView:
        """The lens of the prim."""
        return CameraView(self.scene.stage.GetPrimAtPath(self.path))


def _checked(names: str | Iterable[str] | None) -> list[str]:
    """Names of annotators. Raises SensorValueError for one that tiles do not have."""
    listed = short_names(names)
    for name in listed:
        if name not in WIDTHS:
            raise SensorValueError(f"there is no annotator {name!r} of tiles; there are: {', '.join(WIDTHS)}")
    return listed


def _joined(infos: Iterable[Mapping[str, Mapping[Any, Any]]]) -> dict[str, Any]:
    """The tables of all cameras as one, by rising number."""
    joined: dict[str, dict[Any, Any]] = {}
    for info in infos:
        for name, table in info.items():
            joined.setdefault(name, {}).update(table)
    return {name: dict(sorted(table.items(), key=lambda entry: int(entry[0]))) for name, table in joined.items()}
