"""CameraSensor and TiledCameraSensor: cameras at work, with images of one shape whatever is in view."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from graph.sim.renderer.wrapper import unwrapped
from sensors.errors import SensorValueError
from sensors.products import image_size
from sensors.sensor import RenderedSensor, check_names, short_names
from sensors.sensor_prim import matching_paths

from .authoring import CameraView, RtxCamera
from .tiles import TileGroup

if TYPE_CHECKING:
    from graph.sim import App

    from .runtime import CameraRuntime

WIDTHS = {
    "rgb": 3,
    "rgba": 4,
    "distance_to_camera": 1,
    "distance_to_image_plane": 1,
    "normals": 3,
    "motion_vectors": 2,
    "semantic_segmentation": 1,
    "instance_segmentation": 1,
    "instance_id_segmentation": 1,
}
"""Annotators that give images -> numbers a pixel."""

LISTS = ("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "pointcloud")
ANNOTATORS: dict[str, dict[str, Any]] = {
    name: {"name": "rgb" if name == "rgba" else name} for name in (*WIDTHS, *LISTS)
}
"""Short names of a camera's annotators -> their names in the registry."""


class CameraSensor(RenderedSensor):
    """Renders a camera: `CameraSensor("/World/Camera", resolution=(480, 640), annotators=["rgb"])`.

    resolution: height and width. Pixels are made square: the height of the film is authored again. Annotators: rgb,
    rgba, distance_to_camera, distance_to_image_plane, normals, motion_vectors, semantic_, instance_ and
    instance_id_segmentation, bounding_box_2d_tight, bounding_box_2d_loose, bounding_box_3d, pointcloud. The render
    product exists from now on; if it was made while playing, until the stop. Raises SensorValueError (a UserError and a
    ValueError) for unknown names and prims.
    """

    annotator_specs: ClassVar[Mapping[str, dict[str, Any]]] = ANNOTATORS
    widths: ClassVar[Mapping[str, int]] = WIDTHS
    product_word = "camera_sensor"

    def __init__(
        self,
        camera: RtxCamera | str,
        *,
        resolution: tuple[int, int],
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        annotators, writers = short_names(annotators), short_names(writers)
        check_names(annotators, writers, self.annotator_specs)
        self.camera = camera if isinstance(camera, RtxCamera) else RtxCamera(camera, app=app)
        self.render_vars = tuple(render_vars or ())
        self.resolution = _size(resolution)
        CameraView(self.camera.prim).enforce_square_pixels(self.resolution)
        super().__init__(self.camera.app, self.camera.path, self.resolution[::-1], annotators, writers)

    @property
    def authoring_object(self) -> RtxCamera:
        """The RtxCamera."""
        return self.camera

    @property
    def runtime(self) -> CameraRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("CameraRuntime", unwrapped(self._product.sensor))

    def get_data(self, name: str, out: np.ndarray | None = None) -> tuple[Any, Mapping[str, Any]]:
        """(data, info) of an attached annotator: images are (height, width, n), boxes and clouds (count, ...).

        (None, {}) before the first frame. out: an image of the same shape that takes the data. Raises SensorValueError
        for a name that is unknown or not attached.
        """
        data, info = super().get_data(name)
        if self._product.frame is None:
            return None, {}
        if name not in self.widths:
            return data, {**info, "resolution": self.resolution}
        data = data.reshape(*self.resolution, -1)[..., : self.widths[name]]
        if out is not None:
            out[...] = data
            return out, info
        return np.ascontiguousarray(data), info


class TiledCameraSensor:
    """Renders several cameras of one size into one image, row after row of tiles.

    paths: of Camera prims, or regular expressions (/World/env_.*/Camera). resolution: height and width of each. There
    are round(sqrt(N)) rows of tiles, camera k is in row k // columns; spare tiles are 0. Annotators: those of
    `CameraSensor` that give images. Raises SensorValueError as it does.
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
        from graph.sim import App

        names = short_names(annotators)
        for name in names:
            if name not in WIDTHS:
                raise SensorValueError(f"there is no annotator {name!r} of tiles; there are: {', '.join(WIDTHS)}")
        app = app if app is not None else App.current()
        given = [paths] if isinstance(paths, str) else [str(path) for path in paths]
        listed = [found for path in given for found in matching_paths(app.stage, path)]
        if not listed:
            raise SensorValueError("there is no camera to tile; give the path of one")
        self.paths = listed
        self.render_vars = tuple(render_vars or ())
        self.sensors = [Tile(app, path, resolution, names) for path in listed]
        self.rows = max(1, round(len(listed) ** 0.5))
        self.columns = -(-len(listed) // self.rows)
        self._size = _size(resolution)
        self._group = TileGroup([sensor.runtime for sensor in self.sensors])

    @property
    def resolution(self) -> tuple[int, int]:
        """Height and width of a tile."""
        return self._size

    @property
    def tiled_resolution(self) -> tuple[int, int]:
        """Height and width of the whole image."""
        return self.rows * self._size[0], self.columns * self._size[1]

    def get_data(self, name: str, *, tiled: bool = True) -> tuple[np.ndarray | None, dict[str, Any]]:
        """(data, info): (rows x height, columns x width, n), or without tiling (N, height, width, n).

        (None, {}) before every camera has a frame. info: of each camera, by its path. Raises SensorValueError as
        `CameraSensor.get_data` does.
        """
        found = [sensor.get_data(name) for sensor in self.sensors]
        if any(data is None for data, _ in found):
            return None, {}
        images = np.stack([data for data, _ in found])
        info = {path: dict(each) for path, (_, each) in zip(self.paths, found, strict=True) if each}
        if not tiled:
            return images, info
        spare = self.rows * self.columns - len(images)
        images = np.concatenate([images, np.zeros((spare, *images.shape[1:]), images.dtype)])
        height, width, count = images.shape[1:]
        grid = images.reshape(self.rows, self.columns, height, width, count).swapaxes(1, 2)
        return np.ascontiguousarray(grid.reshape(*self.tiled_resolution, count)), info


def _size(resolution: Sequence[int]) -> tuple[int, int]:
    height, width = image_size(resolution, "(height, width)")
    if height < 1 or width < 1:
        raise SensorValueError(f"resolution {resolution} is not (height, width) above 0")
    return height, width


class Tile(CameraSensor):
    """One camera of many: a plain Camera prim, which need not have the schema of sensors."""

    def __init__(self, app: App, path: str, resolution: tuple[int, int], annotators: Iterable[str]) -> None:
        self.resolution = _size(resolution)
        RenderedSensor.__init__(self, app, path, self.resolution[::-1], annotators)
