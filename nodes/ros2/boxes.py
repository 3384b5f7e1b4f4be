"""Bounding boxes as ROS 2 detections."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from graph.sim.settings import BOXES_IN_WORLD

from .messages import header, type_of
from .publishing import Publisher, check_names, publishes, stamped_inputs
from .robot_messages import point, quaternion, vector

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

DETECTIONS_2D = "vision_msgs/msg/Detection2DArray"
DETECTIONS_3D = "vision_msgs/msg/Detection3DArray"

BOX_2D = [("id", "<u4"), ("x_min", "<i4"), ("y_min", "<i4"), ("x_max", "<i4"), ("y_max", "<i4"), ("occlusion", "<f4")]
"""One box in the image [px], in the layout of the bounding box annotators."""

BOX_3D = [("id", "<u4"), ("low", "<f4", 3), ("high", "<f4", 3), ("transform", "<f4", (4, 4)), ("occlusion", "<f4")]
"""One box in its prim's axes [stage units], and the prim's pose (row vectors) in the frame of the message."""


def _inputs(topic: str) -> dict[str, Attribute]:
    return {
        **stamped_inputs(topic, frame_id="sim_camera"),
        "data": Attribute("uchar[]", "boxes, one structure after the other", default=[], role="data"),
    }


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishBbox2D",
    version=1,
    check=check_names,
    inputs=_inputs("bbox2d"),
    memory=partial(Publisher, DETECTIONS_2D),
)
@publishes
def publish_boxes_2d(db: Database, nanoseconds: int) -> Any:
    """Publish `vision_msgs/Detection2DArray`: centre and size [px] of each box by semantic id."""
    return detections_2d([row[:5] for row in _rows(db, BOX_2D).tolist()], nanoseconds, db.inputs.frameId)


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishBbox3D",
    version=1,
    check=check_names,
    inputs=_inputs("bbox3d"),
    memory=partial(Publisher, DETECTIONS_3D),
)
@publishes
def publish_boxes_3d(db: Database, nanoseconds: int) -> Any:
    """Publish `vision_msgs/Detection3DArray`: centre, orientation, size [m] of each box by semantic id."""
    import numpy as np

    rows = _rows(db, BOX_3D)
    return detections_3d(
        rows["id"].tolist(),
        rows["transform"].astype(np.float64).transpose(0, 2, 1),
        rows["low"].astype(np.float64),
        rows["high"].astype(np.float64),
        db.app.meters_per_unit,
        nanoseconds,
        db.inputs.frameId,
        at_origins=bool(db.app.settings.get(BOXES_IN_WORLD)),
    )


def detections_2d(rows: Iterable[tuple[int, ...]], nanoseconds: int, frame_id: str) -> Any:
    """`vision_msgs/Detection2DArray`; rows: semantic id, x_min, y_min, x_max, y_max [px]."""
    box, position, pose = (type_of(f"vision_msgs/msg/{name}") for name in ("BoundingBox2D", "Point2D", "Pose2D"))
    head = header(nanoseconds, frame_id)
    detections = []
    for number, x_low, y_low, x_high, y_high in rows:
        centre = position((x_low + x_high) / 2, (y_low + y_high) / 2)
        found = box(pose(centre, 0.0), float(x_high - x_low), float(y_high - y_low))
        detections.append(type_of("vision_msgs/msg/Detection2D")(head, [_hypothesis(number)], found, ""))
    return type_of(DETECTIONS_2D)(head, detections)


def detections_3d(
    numbers: Iterable[int],
    poses: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    unit: float,
    nanoseconds: int,
    frame_id: str,
    *,
    at_origins: bool = False,
) -> Any:
    """`vision_msgs/Detection3DArray` of boxes by semantic id.

    poses: (n, 4, 4) prim to the frame of the message; low, high: (n, 3) corners in the prim's axes; lengths are in
    stage units of `unit` m. at_origins: the origins of the prims stand for the centres of the boxes, as in Isaac Sim.
    """
    import numpy as np

    from graph.sim.transforms import quaternions, rotations_and_scales, to_xyzw

    rotations, scales = rotations_and_scales(poses)
    middle = np.zeros_like(low) if at_origins else (low + high) / 2
    middles = (poses[:, :3, :3] @ middle[:, :, None])[:, :, 0] + poses[:, :3, 3]
    middles, sizes = middles * unit, (high - low) * np.abs(scales) * unit
    turns = to_xyzw(quaternions(rotations))
    head = header(nanoseconds, frame_id)
    box, pose, detection = (
        type_of(name)
        for name in ("vision_msgs/msg/BoundingBox3D", "geometry_msgs/msg/Pose", "vision_msgs/msg/Detection3D")
    )
    detections = [
        detection(head, [_hypothesis(number)], box(pose(point(middle), quaternion(turn)), vector(size)), "")
        for number, middle, turn, size in zip(numbers, middles, turns, sizes, strict=True)
    ]
    return type_of(DETECTIONS_3D)(head, detections)


def _rows(db: Database, layout: Any) -> Any:
    """The boxes of the input data. Fails the node if the number of bytes is not a multiple of a box's size."""
    import numpy as np

    data, kind = np.ascontiguousarray(db.inputs.data), np.dtype(layout)
    if data.size % kind.itemsize:
        db.fail(f"data has {data.size} bytes; a box has {kind.itemsize}")
    return data.view(kind)


def _hypothesis(number: int) -> Any:
    import numpy as np

    hypothesis = type_of("vision_msgs/msg/ObjectHypothesis")(str(number), 1.0)
    pose = type_of("geometry_msgs/msg/Pose")(point((0.0, 0.0, 0.0)), quaternion((0.0, 0.0, 0.0, 1.0)))
    placed = type_of("geometry_msgs/msg/PoseWithCovariance")(pose, np.zeros(36))
    return type_of("vision_msgs/msg/ObjectHypothesisWithPose")(hypothesis, placed)
