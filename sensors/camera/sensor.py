"""CameraSensor: a camera at work, with images of one shape whatever is in view."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from graph.sim.renderer.wrapper import unwrapped
from sensors.errors import SensorValueError
from sensors.products import image_size
from sensors.sensor import RenderedSensor, check_names, short_names

from .authoring import RtxCamera
from .camera_view import CameraView

if TYPE_CHECKING:
    from graph.sim.app import App

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
        path: RtxCamera | str,
        *,
        resolution: tuple[int, int],
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        annotators, writers = short_names(annotators), short_names(writers)
        check_names(annotators, writers, self.annotator_specs)
        self._authored = path if isinstance(path, RtxCamera) else RtxCamera(path, app=app)
        self.render_vars = tuple(render_vars or ())
        self.resolution = checked_resolution(resolution)
        self.camera.enforce_square_pixels(self.resolution)
        self._given: dict[str, tuple[Any, np.ndarray]] = {}
        super().__init__(self._authored.scene, self._authored.path, self.resolution[::-1], annotators, writers)

    @property
    def authoring_object(self) -> RtxCamera:
        """The RtxCamera."""
        return self._authored

    @property
    def camera(self) -> CameraView:
        """The lens of the prim."""
        return self._authored.camera

    @property
    def runtime(self) -> CameraRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("CameraRuntime", unwrapped(self._product.sensor))

    def get_data(self, annotator: str, out: np.ndarray | None = None) -> tuple[Any, Mapping[str, Any]]:
        """(data, info) of an attached annotator: images are (height, width, n), boxes and clouds (count, ...).

        (None, {}) before the first frame. The data are the caller's own, to write on; between ticks the same object
        again. out: an image of the same shape that takes the data. Raises SensorValueError for a name that is unknown
        or not attached.
        """
        data, info = super().get_data(annotator)
        if self._product.frame is None:
            return None, {}
        if annotator not in self.widths:
            return data, {**info, "resolution": self.resolution}
        known = self._given.get(annotator)
        if known is None or known[0] is not data:
            image = data.reshape(*self.resolution, -1)[..., : self.widths[annotator]]
            known = self._given[annotator] = data, np.ascontiguousarray(image)
        return handed_out(known[1], out), info


def handed_out(image: np.ndarray, out: np.ndarray | None) -> np.ndarray:
    """An image, or the array `out` with it. Raises SensorValueError for one of another shape."""
    if out is None:
        return image
    if np.shape(out) != image.shape:
        raise SensorValueError(f"out has the shape {np.shape(out)}; the data have {image.shape}")
    out[...] = image
    return out


def checked_resolution(resolution: Sequence[int]) -> tuple[int, int]:
    """Height and width [px]. Raises SensorValueError for anything but two whole numbers above 0."""
    height, width = image_size(resolution, "(height, width)")
    if height < 1 or width < 1:
        raise SensorValueError(f"resolution {resolution} is not (height, width) above 0")
    return height, width
