"""ROS 2 messages from camera frames: one for each `type` of ROS2CameraHelper, and CameraInfo."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

from .boxes import DETECTIONS_2D, DETECTIONS_3D, detections_2d, detections_3d
from .image_messages import COMPRESSED, IMAGE, image
from .messages import stamped_json
from .point_clouds import POINT_CLOUD, point_cloud
from .video import H264

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensors.camera.lens import Lens
    from sensors.frame import Frame

RESERVED = ("BACKGROUND", "UNLABELLED", "INVALID")
PINHOLE: tuple[str, Sequence[float]] = "plumb_bob", (0.0,) * 5
"""Distortion model and coefficients of a lens without distortion."""


@dataclass(frozen=True, slots=True)
class Reading:
    """The data of one message: a frame, what reads its annotator's data, the stamp [ns], the frame id."""

    frame: Frame
    read: Callable[[], Any]
    nanoseconds: int
    frame_id: str
    meters_per_unit: float
    boxes_in_world: bool
    cloud_of_corners: bool

    @property
    def found(self) -> Any:
        """The annotator's data."""
        return self.read()


@dataclass(frozen=True, slots=True)
class CameraMessage:
    """One `type`: the message, the annotator whose data it has, how it is made, and whether it comes with labels.

    begin: what makes the messages of one publisher, reading -> message.
    """

    type_name: str
    annotator: str
    begin: Callable[[], Callable[[Reading], Any]]
    labelled: bool = False


def _each(make: Callable[[Reading], Any]) -> Callable[[], Callable[[Reading], Any]]:
    """For messages that do not depend on those before."""
    return lambda: make


def _colours(reading: Reading) -> Any:
    """The frame's own colours; the annotator's have an alpha."""
    data = reading.frame.channel("rgb")
    height, width = data.shape[:2]
    return image(reading.nanoseconds, reading.frame_id, width, height, "rgb8", data)


def _image(encoding: str) -> Callable[[Reading], Any]:
    def make(reading: Reading) -> Any:
        found = reading.found
        data = found["data"] if isinstance(found, dict) else found
        height, width = data.shape[:2]
        return image(reading.nanoseconds, reading.frame_id, width, height, encoding, data)

    return make


def points_of(depths: NDArray[np.float32], focal: float) -> NDArray[np.float32]:
    """(height x width, 3) points of (height, width) distances from the image plane, in the distances' unit.

    NaN where a distance is not finite. focal: focal length [px]. Camera frame of ROS: x right, y down, z forward; the
    optical axis meets the image at (width / 2, height / 2), and a point lies on the ray through the top left corner of
    its pixel, half a pixel off the one that was cast, as in Isaac Sim.
    """
    import numpy as np

    height, width = depths.shape
    known = np.where(np.isfinite(depths), depths, np.float32(np.nan))
    points = np.empty((height, width, 3), dtype=np.float32)
    points[:, :, 0] = known * ((np.arange(width) - width / 2) / focal)
    points[:, :, 1] = known * ((np.arange(height) - height / 2) / focal)[:, None]
    points[:, :, 2] = known
    return points.reshape(-1, 3)


def _cloud(reading: Reading) -> Any:
    """Every pixel as a point in the optical frame; NaN without a hit."""
    import numpy as np

    distance, config = reading.found.reshape(-1, 1), reading.frame.config
    known = np.where(np.isfinite(distance), distance, np.float32(np.nan))
    origins, directions = _rays(config.lens)
    points = known * directions if origins is None else known * directions + origins
    if reading.cloud_of_corners:
        width, height = config.size
        points = points_of(points[:, 2].reshape(height, width), width * config.focal_length / config.film[0])
    return point_cloud(points, {}, reading.nanoseconds, reading.frame_id)


def _stereo_image(reading: Reading) -> Any:
    """Depth as a stereo camera measures it; NaN where it measures nothing (REP 118)."""
    depth = _measured(reading)
    height, width = depth.shape
    return image(reading.nanoseconds, reading.frame_id, width, height, "32FC1", depth)


def _stereo_cloud(reading: Reading) -> Any:
    """Every pixel as a point in the optical frame; NaN where nothing is measured."""
    import numpy as np

    origins, directions = _rays(reading.frame.config.lens)
    with np.errstate(divide="ignore", invalid="ignore"):
        points = _measured(reading).reshape(-1, 1) * (directions / directions[:, 2:])
    points = points if origins is None else points + origins
    return point_cloud(points, {}, reading.nanoseconds, reading.frame_id)


def _measured(reading: Reading) -> NDArray[np.float32]:
    import numpy as np

    return np.where(reading.found > 0, reading.found, np.float32(np.nan))


@lru_cache(maxsize=8)
def _rays(lens: Lens) -> tuple[NDArray[np.float32] | None, NDArray[np.float32]]:
    """Of all pixels, optical frame: where their rays start [m] (n, 3), None for the origin; unit directions (n, 3)."""
    import numpy as np

    from sensors.camera.lens import ParallelLens

    directions = np.ascontiguousarray(lens.unproject(lens.centres()).T, np.float32)
    if not isinstance(lens, ParallelLens):
        return None, directions
    return np.ascontiguousarray(lens.origins().T, np.float32), directions


def _flat_boxes(reading: Reading) -> Any:
    rows = reading.found["data"]
    names = ("semanticId", "x_min", "y_min", "x_max", "y_max")
    return detections_2d([tuple(map(int, row[list(names)])) for row in rows], reading.nanoseconds, reading.frame_id)


def _solid_boxes(reading: Reading) -> Any:
    """Poses in the camera's optical frame, which the header names; if the setting chooses it, in the world, with the
    origins of prims for the centres of their boxes.
    """
    import numpy as np

    from graph.sim.transforms import inverse_rigid
    from sensors.camera.rays import TO_USD

    rows, unit = reading.found["data"], reading.meters_per_unit
    poses = rows["transform"].astype(np.float64).transpose(0, 2, 1)
    if not reading.boxes_in_world:
        camera = reading.frame.end.world_sensor.copy()
        camera[:3, 3] /= unit
        camera[:3, :3] = camera[:3, :3] @ TO_USD
        poses = inverse_rigid(camera) @ poses
    low, high = (
        np.stack([rows[f"{axis}_{end}"] for axis in "xyz"], axis=1).astype(np.float64) for end in ("min", "max")
    )
    numbers = rows["semanticId"].tolist()
    where = reading.nanoseconds, reading.frame_id
    return detections_3d(numbers, poses, low, high, unit, *where, at_origins=reading.boxes_in_world)


MESSAGES: Mapping[str, CameraMessage] = {
    "rgb": CameraMessage(IMAGE, "rgb", _each(_colours)),
    "rgb_h264": CameraMessage(COMPRESSED, "rgb", H264),
    "depth": CameraMessage(IMAGE, "distance_to_image_plane", _each(_image("32FC1"))),
    "depth_pcl": CameraMessage(POINT_CLOUD, "distance_to_camera", _each(_cloud)),
    "stereo_depth": CameraMessage(IMAGE, "depth_sensor_distance", _each(_stereo_image)),
    "stereo_depth_pcl": CameraMessage(POINT_CLOUD, "depth_sensor_distance", _each(_stereo_cloud)),
    "instance_segmentation": CameraMessage(IMAGE, "instance_segmentation", _each(_image("32SC1")), labelled=True),
    "semantic_segmentation": CameraMessage(IMAGE, "semantic_segmentation", _each(_image("32SC1")), labelled=True),
    "bbox_2d_tight": CameraMessage(DETECTIONS_2D, "bounding_box_2d_tight", _each(_flat_boxes), labelled=True),
    "bbox_2d_loose": CameraMessage(DETECTIONS_2D, "bounding_box_2d_loose", _each(_flat_boxes), labelled=True),
    "bbox_3d": CameraMessage(DETECTIONS_3D, "bounding_box_3d", _each(_solid_boxes), labelled=True),
}
"""By the `type` of a camera helper."""


def labels_message(found: Mapping[str, Any], nanoseconds: int) -> Any:
    """`std_msgs/String`: JSON of the labels of the numbers in a message, in lower case, and its stamp."""
    labels = found["info"]["idToLabels"]
    return stamped_json({str(number): _lower(label) for number, label in labels.items()}, nanoseconds)


def _lower(label: Any) -> Any:
    """Labels in lower case; paths of prims, and the names for missing labels, stay unchanged."""
    if not isinstance(label, Mapping):
        return label
    return {kind: text if text in RESERVED else text.lower() for kind, text in label.items()}


def distortion_of(lens: Lens) -> tuple[str, Sequence[float]] | None:
    """Distortion model and coefficients of a CameraInfo; None for a lens that ROS has no model of."""
    from sensors.camera.lens import BrownLens, FisheyeLens

    if isinstance(lens, BrownLens):
        k, p = lens.k, lens.p
        if any(k[3:]) or any(lens.s):
            return "rational_polynomial", (*k[:2], *p, *k[2:], *lens.s)
        return "plumb_bob", (*k[:2], *p, k[2])
    if isinstance(lens, FisheyeLens) and lens.coefficients[0] == 1.0 and len(lens.coefficients) == 5:
        return "equidistant", lens.coefficients[1:]
    if lens.is_pinhole:
        return PINHOLE
    return None


def matrix_of(lens: Lens, *, square: bool) -> list[float]:
    """The intrinsic matrix K, row by row [px]; square: with fx for fy."""
    return [lens.fx, 0.0, lens.cx, 0.0, lens.fx if square else lens.fy, lens.cy, 0.0, 0.0, 1.0]
