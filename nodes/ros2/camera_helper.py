"""Publishes a camera's frames: attaches a writer to a render product once; from then on each frame is published."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim import settings as keys
from nodes.fitting_sensors import check_fit

from .camera_messages import MESSAGES, Reading, labels_message
from .frame_publisher import (
    STAMP_INPUTS,
    CameraPublisher,
    detach,
    product_of,
    publish_with,
    stamp_notes,
    warn_of_inputs,
)
from .frame_writers import FrameWriter, stamps
from .messages import STRING
from .publishing import check_names, publisher_inputs, topic_name
from .video import has_encoder, no_encoder

if TYPE_CHECKING:
    import numpy as np

    from graph.sim.renderer.products import RenderProduct
    from sensors.annotators.annotator import Annotator

COMPRESSED = "rgb_h264"


HELPER_INPUTS = {
    **STAMP_INPUTS,
    "frameSkipCount": Attribute(
        "uint",
        "frames left out between two messages",
        default=0,
        unit="frames",
        deprecated="lower the camera's tickRate",
        warns_itself=True,
    ),
}


def check_camera(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Checks names as for every publisher, and that the product is that of a camera."""
    from sensors.camera.names import PRIM_TYPE

    yield from check_names(node)
    yield from check_fit(node, PRIM_TYPE)


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    yield from check_camera(node)
    if not node.db.connected("inputs:type") and node.db.inputs.type == COMPRESSED and not has_encoder():
        yield "type", no_encoder()


@node_type(
    "isaacsim.ros2.bridge.ROS2CameraHelper",
    version=3,
    check=_check,
    notes=stamp_notes,
    inputs={
        "execIn": Attribute("execution", "attaches the publisher to the product; later activations find it attached"),
        "enabled": Attribute("bool", "if not, nothing is published and what was attached is taken off", default=True),
        **publisher_inputs("rgb", frame_id="sim_camera"),
        "renderProductPath": Attribute("token", "path of the camera's render product", role="product"),
        "type": Attribute("token", "what to publish", default="rgb", allowed_tokens=tuple(MESSAGES)),
        "enableSemanticLabels": Attribute("bool", "also publish what the numbers in images and boxes stand for"),
        "semanticLabelsTopicName": Attribute("string", "topic of these labels", default="semantic_labels"),
        "stereoOffset": Attribute("float[2]", "without effect; stereo is of ROS2CameraInfoHelper", default=[0, 0]),
        **HELPER_INPUTS,
        "srtxCompressionType": Attribute("string", "without effect: rgb_h264 is compressed by x264", default="hevc"),
    },
    memory=CameraPublisher,
    release=detach,
    message_type=lambda db: MESSAGES[db.inputs.type].type_name if db.inputs.type in MESSAGES else "",
    asks=lambda db: [MESSAGES[db.inputs.type].annotator] if db.inputs.type in MESSAGES else [],
    further_topics=lambda db: {"semanticLabelsTopicName": STRING} if _sends_labels(db.inputs) else {},
)
def camera_helper(db: Database) -> bool:
    """Publish every frame of a camera's render product, as an image, a cloud, or detections.

    Settings are read when the publisher is attached; a new product path attaches it again. depth is in metres along the
    view axis, infinite without a hit. stereo_depth is measured by disparity, with steps and noise, as the attributes
    omni:rtx:post:depthSensor of the product, or of its camera, say; NaN where nothing is measured. Clouds and boxes in
    space are in the optical frame (x right, y down, z forward), which is that of the camera in TF.
    """
    product = camera_product(db)
    if product is None:
        return False
    if product is not db.memory.product:
        detach(db)
        _attach(db, product)
    db.memory.listen(db.app.bus)
    return True


def camera_product(db: Database, path_input: str = "renderProductPath") -> RenderProduct | None:
    """The render product of a camera that a helper's input names; None while the helper is disabled.

    Warns and fails as `product_of` does.
    """
    from sensors.camera.names import PRIM_TYPE

    if not getattr(db.inputs, "enabled", True):
        detach(db)
        return None
    return product_of(db, PRIM_TYPE, "not-a-camera", path_input)


def asks_pictures(db: Database) -> tuple[str, ...]:
    """The annotators of a helper that sends colour pictures."""
    return ("rgb",)


def send_pictures(db: Database, topic: str, type_name: str, make: Callable[[np.ndarray, int], Any]) -> bool:
    """Computes a helper that sends every colour picture of its product on another transport; whether it did.

    make: turns a picture (height, width, 4) uint8 and its stamp [ns] into a message of the type.
    """
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    product = camera_product(db)
    if product is None:
        return False
    memory, inputs, app = db.memory, db.inputs, db.app
    if product is not memory.product:
        detach(db)
        warn_of_inputs(db, stamp_notes(db))
        memory.product, memory.annotator = (
            product,
            Annotator(find_annotator(*asks_pictures(db)), app=app, owner=db.path, copies=False),
        )
        stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
        every = getattr(inputs, "frameSkipCount", 0) + 1
        message = partial(_picture, memory.annotator, make)
        publish_with(db, product, FrameWriter(app.bus, topic, type_name, stamp, message, every, "rgb"))
    memory.listen(app.bus)
    db.fire("execOut")
    return True


def _picture(annotator: Annotator, make: Callable[[np.ndarray, int], Any], frame: Any, at: int) -> Any:
    return make(annotator.get_data(), at)


def _attach(db: Database, product: RenderProduct) -> None:
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    app, inputs, memory = db.app, db.inputs, db.memory
    kind = MESSAGES.get(inputs.type)
    if kind is None:
        db.fail(f"input type is {inputs.type!r}; it must be one of {', '.join(MESSAGES)}")
    if inputs.type == COMPRESSED:
        _check_video(db, product)
    warn_of_inputs(db, stamp_notes(db))
    annotator = Annotator(find_annotator(kind.annotator), app=app, owner=db.path, copies=False)
    memory.product, memory.annotator = product, annotator
    stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    every, camera = inputs.frameSkipCount + 1, product.camera_path
    make = partial(_message, kind.begin(), annotator, inputs.frameId, app.meters_per_unit, app.settings)
    topic, gate = topic_name(db, camera), kind.annotator
    publish_with(db, product, FrameWriter(app.bus, topic, kind.type_name, stamp, make, every, gate))
    if _sends_labels(inputs):
        topic = topic_name(db, camera, inputs.semanticLabelsTopicName)
        publish_with(db, product, FrameWriter(app.bus, topic, STRING, stamp, partial(_labels, annotator), every, gate))


def _sends_labels(inputs: Any) -> bool:
    kind = MESSAGES.get(inputs.type)
    return bool(inputs.enableSemanticLabels and kind is not None and kind.labelled)


def _check_video(db: Database, product: RenderProduct) -> None:
    """Fails the node without an encoder, and for sizes that H.264 does not have."""
    width, height = product.resolution
    if not has_encoder():
        db.fail(no_encoder())
    if width % 2 or height % 2:
        db.fail(f"type {COMPRESSED} needs an even width and height; {product.path} has {width} x {height} pixels")


def _message(
    make: Callable[[Reading], Any], annotator: Annotator, frame_id: str, unit: float, settings: Any, frame: Any, at: int
) -> Any:
    chosen = (bool(settings.get(key)) for key in (keys.BOXES_IN_WORLD, keys.CLOUD_OF_CORNERS))
    return make(Reading(frame, annotator.get_data, at, frame_id, unit, *chosen))


def _labels(annotator: Annotator, frame: Any, at: int) -> Any:
    return labels_message(annotator.get_data(), at)
