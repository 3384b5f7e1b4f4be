"""Sends a camera's colour pictures: attaches a writer to a render product once, then the frames send themselves."""

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
from nodes.ros2.image_messages import IMAGE, image
from nodes.ros2.lidar_writers import FrameWriter, stamps

from .transport import SENT, endpoint_inputs, topic_of

if TYPE_CHECKING:
    from sensors.annotators.annotator import Annotator


@node_type(
    "isaacsim.ucx.nodes.UCXCameraHelper",
    version=1,
    check=check_camera,
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
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    product = product_of(db)
    if product is None:
        return False
    memory, inputs, app = db.memory, db.inputs, db.app
    if product is not memory.product:
        detach(db)
        warn_about_settings(db)
        memory.product, memory.annotator = product, Annotator(find_annotator("rgb"), app=app, owner=db.path)
        stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
        make = partial(_message, memory.annotator)
        add_camera_writer(
            db, product, FrameWriter(app.bus, topic_of(db), IMAGE, stamp, make, inputs.frameSkipCount + 1)
        )
    memory.listen(app.bus)
    db.fire("execOut")
    return True


def _message(annotator: Annotator, frame: Any, at: int) -> Any:
    picture = annotator.get_data()
    return image(at, "", picture.shape[1], picture.shape[0], "rgb8", picture[:, :, :3])
