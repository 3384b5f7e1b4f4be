"""Sends a camera's pictures as raw frames: attaches a writer to a render product once; then each frame is sent."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.ros2.camera_helper import (
    HELPER_INPUTS,
    CameraPublisher,
    add_camera_writer,
    check_camera,
    detach,
    product_of,
    warn_about_settings,
)
from nodes.ros2.lidar_writers import FrameWriter, stamps

from .transport import BYTES, SENT, bytes_message, receiver_inputs, topic_of
from .vb1940 import COE, MODES, frame_bytes

if TYPE_CHECKING:
    from sensors.annotators.annotator import Annotator


@node_type(
    "isaacsim.hsb.nodes.HSBCameraHelper",
    version=1,
    check=check_camera,
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
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    product = product_of(db)
    if product is None:
        return False
    memory, inputs, app = db.memory, db.inputs, db.app
    if inputs.type not in MODES:
        db.fail(f'input type is "{inputs.type}"; use {" or ".join(MODES)}')
    if product is not memory.product:
        detach(db)
        warn_about_settings(db)
        memory.product, memory.annotator = product, Annotator(find_annotator("rgb"), app=app, owner=db.path)
        stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
        make = partial(_message, memory.annotator, inputs.type)
        add_camera_writer(db, product, FrameWriter(app.bus, topic_of(db), BYTES, stamp, make))
    memory.listen(app.bus)
    db.fire("execOut")
    return True


def _message(annotator: Annotator, mode: str, frame: Any, at: int) -> Any:
    return bytes_message(frame_bytes(annotator.get_data(), mode))
