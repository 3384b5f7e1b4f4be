"""Sends a camera's pictures as raw frames: attaches a writer to a render product once; then each frame is sent."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.ros2.camera_helper import HELPER_INPUTS, asks_pictures, check_camera, send_pictures
from nodes.ros2.frame_publisher import CameraPublisher, detach, stamp_notes

from .transport import BYTES, SENT, bytes_message, receiver_inputs, topic_of
from .vb1940 import COE, MODES, frame_bytes

if TYPE_CHECKING:
    import numpy as np


@node_type(
    "isaacsim.hsb.nodes.HSBCameraHelper",
    version=1,
    check=check_camera,
    notes=stamp_notes,
    asks=asks_pictures,
    inputs={
        **receiver_inputs(tokens=True),
        "renderProductPath": Attribute("token", "path of the camera's render product", role="product"),
        **{name: one for name, one in HELPER_INPUTS.items() if name != "frameSkipCount"},
        "type": Attribute("token", "how the frame is packed", default=COE, allowed_tokens=MODES),
    },
    outputs={"execOut": SENT},
    memory=CameraPublisher,
    release=detach,
)
def hsb_camera_helper(db: Database) -> bool:
    """Send every picture of a camera's render product as the raw frame of a VB1940 (see RGBToVB1940)."""
    mode = db.inputs.type
    if mode not in MODES:
        db.fail(f'input type is "{mode}"; use {" or ".join(MODES)}')
    return send_pictures(db, topic_of(db), BYTES, partial(_message, mode))


def _message(mode: str, picture: np.ndarray, at: int) -> Any:
    return bytes_message(frame_bytes(picture, mode))
