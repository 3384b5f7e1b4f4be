"""Publishes a camera's lens parameters with each of its frames; for a stereo pair also the rectification."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from operator import is_
from typing import TYPE_CHECKING, Any, cast

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.settings import INFO_SQUARE_PIXELS

from .camera_helper import HELPER_INPUTS, camera_product, check_camera
from .camera_messages import PINHOLE, distortion_of, matrix_of
from .frame_publisher import CameraPublisher, detach, publish_with, stamp_notes, warn_of_inputs
from .frame_writers import FrameWriter, stamps
from .image_messages import CAMERA_INFO, camera_info
from .publishing import publisher_inputs, topic_name

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graph.sim.renderer.products import RenderProduct
    from sensors.camera.config import CameraConfig
    from sensors.camera.lens import Lens
    from sensors.camera.runtime import CameraRuntime

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(slots=True)
class _PairPublisher(CameraPublisher):
    """What the node keeps: of a stereo pair also the right camera's product; and the cameras as they were read."""

    right: RenderProduct | None = None
    configs: tuple[CameraConfig, ...] = ()


@node_type(
    "isaacsim.ros2.bridge.ROS2CameraInfoHelper",
    version=1,
    check=check_camera,
    notes=stamp_notes,
    inputs={
        "execIn": Attribute("execution", "attaches the publisher to the product; later activations find it attached"),
        "enabled": Attribute("bool", "if not, nothing is published and what was attached is taken off", default=True),
        **publisher_inputs("camera_info", frame_id="sim_camera"),
        "renderProductPath": Attribute("token", "path of the camera's render product", role="product"),
        "frameIdRight": Attribute("string", "frame of the right camera", default="sim_camera_right", optional=True),
        "topicNameRight": Attribute("string", "topic of the right camera", default="camera_info_right", optional=True),
        "renderProductPathRight": Attribute(
            "token", "path of the right camera's render product; unset: there is one camera", optional=True
        ),
        **HELPER_INPUTS,
    },
    memory=_PairPublisher,
    release=detach,
    message_type=lambda db: CAMERA_INFO,
    further_topics=lambda db: {"topicNameRight": CAMERA_INFO} if _is_pair(db) else {},
)
def camera_info_helper(db: Database) -> bool:
    """Publish `sensor_msgs/CameraInfo` with every frame of a camera, or of both cameras of a stereo pair.

    K is that of the image: a lens schema scaled to it, else focal length and aperture; the profile isaacsim-6.0.1 makes
    both of its focal lengths the first. P of both cameras of a pair is the mean of their K, that of the right one with
    -fx times the baseline. The lens is read when the publisher is attached; an activation attaches it again once there
    is a new product path, of the right camera too, or another lens.
    """
    product = camera_product(db)
    if product is None:
        return False
    right = camera_product(db, "renderProductPathRight") if db.inputs.renderProductPathRight else None
    if db.inputs.renderProductPathRight and right is None:
        return False
    memory, configs = db.memory, tuple(_config(one) for one in (product, right) if one is not None)
    same = len(configs) == len(memory.configs) and all(map(is_, configs, memory.configs))
    if product is memory.product and right is memory.right and same:
        return True
    detach(db)
    memory.configs = configs
    return _attach(db, product, right)


def _is_pair(db: Database) -> bool:
    return bool(db.connected("inputs:renderProductPathRight") or db.inputs.renderProductPathRight)


def _attach(db: Database, product: RenderProduct, right: RenderProduct | None) -> bool:
    inputs, memory = db.inputs, db.memory
    warn_of_inputs(db, stamp_notes(db))
    topic, k = topic_name(db, product.camera_path), _matrix(db, product)
    if right is None:
        memory.product, memory.right = product, None
        _add(db, product, topic, inputs.frameId, IDENTITY, projection(k))
        return True
    problem = _unlike(lens_of(product), lens_of(right))
    if problem:
        db.warn("stereo-unlike", f"{product.path} and {right.path} differ in their {problem}; nothing is published")
        return False
    memory.product, memory.right = product, right
    rotations, baseline = rectification(_pose(db, product), _pose(db, right))
    k = [(one + other) / 2 for one, other in zip(k, _matrix(db, right), strict=True)]  # rows meet, far points coincide
    _add(db, product, topic, inputs.frameId, rotations[0], projection(k))
    topic = topic_name(db, right.camera_path, inputs.topicNameRight)
    _add(db, right, topic, inputs.frameIdRight, rotations[1], projection(k, -k[0] * baseline))
    return True


def _add(
    db: Database, product: RenderProduct, topic: str, frame_id: str, r: Sequence[float], p: Sequence[float]
) -> None:
    inputs, lens = db.inputs, lens_of(product)
    distortion = distortion_of(lens) or PINHOLE
    if distortion_of(_config(product).lens) is None:
        said = "ROS has no model of its lens; K is that of its focal length and aperture, D is 0"
        db.warn("lens-without-model", f"{product.camera_path}: {said}")
    make = partial(_message, frame_id, (lens.width, lens.height), distortion, _matrix(db, product), r, p)
    stamp = stamps(db.app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    every = inputs.frameSkipCount + 1
    publish_with(db, product, FrameWriter(db.app.bus, topic, CAMERA_INFO, stamp, make, every, "camera_info"))


def _matrix(db: Database, product: RenderProduct) -> list[float]:
    lens = lens_of(product)
    square = lens.fx != lens.fy and bool(db.app.settings.get(INFO_SQUARE_PIXELS))
    if square:
        said = f"{product.camera_path}: its CameraInfo has fx {lens.fx:g} for fy {lens.fy:g}, unlike its image"
        db.warn("camera-info-square", f"{said} (as in Isaac Sim; --{INFO_SQUARE_PIXELS}=false keeps fy)")
    return matrix_of(lens, square=square)


def projection(k: Sequence[float], shift: float = 0.0) -> list[float]:
    """P, row by row, of a matrix K; shift: what lies in its last column [px m]."""
    return [*k[:3], shift, *k[3:6], 0.0, *k[6:], 0.0]


def _message(
    frame_id: str,
    size: tuple[int, int],
    distortion: tuple[str, Sequence[float]],
    k: Sequence[float],
    r: Sequence[float],
    p: Sequence[float],
    frame: Any,
    at: int,
) -> Any:
    return camera_info(at, frame_id, size, distortion, k, r, p)


def _config(product: RenderProduct) -> CameraConfig:
    from graph.sim.renderer.wrapper import unwrapped

    return cast("CameraRuntime", unwrapped(product.sensor)).config


def lens_of(product: RenderProduct) -> Lens:
    """The lens that a CameraInfo describes: the camera's, or a pinhole on its film where ROS has no model of it."""
    from sensors.camera.lens import Lens

    config = _config(product)
    if distortion_of(config.lens) is not None:
        return config.lens
    width, height = config.size
    focal = width * config.focal_length / config.film[0]
    return Lens(width, height, focal, focal, width / 2, height / 2)


def _pose(db: Database, product: RenderProduct) -> NDArray[np.float64]:
    """The optical frame of a camera in the world, (4, 4) float64 [m]."""
    from graph.sim.transforms import rigid_part
    from sensors.camera.rays import TO_USD

    pose = rigid_part(db.app.fabric.world_matrix(product.camera_path))
    pose[:3, 3] *= db.app.meters_per_unit
    pose[:3, :3] = pose[:3, :3] @ TO_USD
    return pose


def _unlike(left: Lens, right: Lens) -> str:
    if (left.width, left.height) != (right.width, right.height):
        return "resolution"
    first, second = (distortion_of(lens) or PINHOLE for lens in (left, right))
    return "distortion model" if first[0] != second[0] else ""


def rectification(
    left: NDArray[np.float64], right: NDArray[np.float64]
) -> tuple[tuple[Sequence[float], Sequence[float]], float]:
    """The rectifying rotations of a stereo pair, row by row, and the baseline [m], above 0 for a right camera.

    left, right: (4, 4) optical frames in the world. Both are turned to the mean of their axes, whose x is then put
    along the baseline (Bouguet's method, as in OpenCV's stereoRectify).
    """
    import numpy as np

    from graph.sim.transforms import quaternions, rotation_matrices, slerp

    away = left[:3, :3].T @ (right[:3, 3] - left[:3, 3])
    between = left[:3, :3].T @ right[:3, :3]  # right axes in the left camera
    unity, turned = quaternions(np.stack([np.eye(3), between]))
    half = rotation_matrices(slerp(unity, turned, 0.5))
    along = half.T @ away
    baseline = float(np.linalg.norm(along))
    if baseline == 0:
        return (IDENTITY, IDENTITY), 0.0
    x = along / baseline * (1.0 if along[0] >= 0 else -1.0)
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y)
    rows = np.stack([x, y, np.cross(x, y)])
    first, second = rows @ half.T, rows @ half.T @ between
    return (first.reshape(-1).tolist(), second.reshape(-1).tolist()), float(x @ along)
