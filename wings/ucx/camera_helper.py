"""Sends a camera's colour pictures: attaches a writer to a render product once, then the frames send themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.ros2.camera_helper import HELPER_INPUTS, asks_pictures, check_camera, send_pictures
from nodes.ros2.frame_publisher import CameraPublisher, detach, stamp_notes
from nodes.ros2.image_messages import IMAGE, image

from .transport import SENT, endpoint_inputs, topic_of

if TYPE_CHECKING:
    import numpy as np


@node_type(
    "isaacsim.ucx.nodes.UCXCameraHelper",
    version=1,
    check=check_camera,
    notes=stamp_notes,
    asks=asks_pictures,
    inputs={
        **endpoint_inputs(13337, 270059627, wide_port=True, timeout=False),
        "renderProductPath": Attribute("token", "path of the camera's render product", role="product"),
        **HELPER_INPUTS,
        "sendCudaBuffer": Attribute("bool", "without effect: pictures are in host memory", default=True),
    },
    outputs={"execOut": SENT},
    memory=CameraPublisher,
    release=detach,
)
def ucx_camera_helper(db: Database) -> bool:
    """Send every colour picture of a camera's render product, as `sensor_msgs/Image` with encoding rgb8."""
    return send_pictures(db, topic_of(db), IMAGE, _message)


def _message(picture: np.ndarray, at: int) -> Any:
    return image(at, "", picture.shape[1], picture.shape[0], "rgb8", picture[:, :, :3])
