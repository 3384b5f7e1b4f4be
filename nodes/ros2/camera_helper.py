"""Publishes a camera's frames: attaches a writer to a render product once; from then on each frame is published."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim import settings as keys
from nodes.fitting_sensors import check_fit, misfit

from .camera_messages import MESSAGES, Reading, labels_message
from .lidar_writers import STRING, FrameWriter, add_writer, stamps
from .publishing import check_names, publisher_inputs, topic_name
from .video import NO_ENCODER, has_encoder

if TYPE_CHECKING:
    import numpy as np

    from graph.sim.renderer.products import RenderProduct
    from sensors.annotators.annotator import Annotator

COMPRESSED = "rgb_h264"


@dataclass(slots=True)
class CameraPublisher:
    """What a helper keeps between attaching and detaching: the product, the writers each with the product whose frames
    it gets, the annotator they read.

    The annotator is attached only while a topic has a subscriber, so that nothing is computed without need.
    """

    product: RenderProduct | None = None
    writers: list[tuple[RenderProduct, FrameWriter]] = field(default_factory=list)
    annotator: Annotator | None = None

    def listen(self, bus: Any) -> None:
        """Attaches the annotator while there are subscribers, and only then."""
        if self.annotator is None or self.product is None:
            return
        wanted = any(bus.has_subscribers(writer.topic) for _, writer in self.writers)
        if wanted and self.annotator.product is None:
            self.annotator.attach(self.product)
        elif not wanted:
            self.annotator.detach()


def detach(db: Database) -> None:
    """Removes the writers and the request of a helper from its products."""
    memory = db.memory
    if memory.annotator is not None:
        memory.annotator.detach()
    for product, writer in memory.writers:
        product.writers[:] = [one for one in product.writers if one is not writer]
    memory.product, memory.writers, memory.annotator = None, [], None


HELPER_INPUTS = {
    "resetSimulationTimeOnStop": Attribute(
        "bool", "stamp with the time since play; if not, with the time that no stop resets", default=True
    ),
    "useSystemTime": Attribute("bool", "stamp with the wall time of the last physics step", default=False),
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
        yield "type", NO_ENCODER


@node_type(
    "isaacsim.ros2.bridge.ROS2CameraHelper",
    version=3,
    check=_check,
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
)
def camera_helper(db: Database) -> bool:
    """Publish every frame of a camera's render product, as an image, a cloud, or detections.

    Settings are read when the publisher is attached; a new product path attaches it again. depth is in metres along the
    view axis, infinite without a hit; depth_pcl and boxes in space are in the optical frame (x right, y down, z
    forward), which is that of the camera in TF.
    """
    product = product_of(db)
    if product is None:
        return False
    if product is not db.memory.product:
        detach(db)
        _attach(db, product)
    db.memory.listen(db.app.bus)
    return True


def product_of(db: Database, path_input: str = "renderProductPath") -> RenderProduct | None:
    """The render product that a helper's input names, of a camera; None if disabled or, with a warning, if it does not
    exist.

    Fails the node for a path without a product.
    """
    from graph.sim.scene.prim_paths import prim_at
    from sensors.camera.names import PRIM_TYPE

    if not getattr(db.inputs, "enabled", True):
        detach(db)
        return None
    path = getattr(db.inputs, path_input)
    if not path:
        db.warn("render-product-missing", f"{path_input} is empty; connect it to a render product")
        return None
    product: RenderProduct | None = db.app.rendering.products.get(path)
    if product is None:
        db.fail(f"there is no render product {path}; connect {path_input} to one")
    if problem := misfit(prim_at(db.app.stage, product.camera_path), product.camera_path, PRIM_TYPE):
        db.warn("not-a-camera", f"{problem}; nothing is published")
        return None
    return product


def warn_about_settings(db: Database) -> None:
    """Warns of inputs that are deprecated or contradict each other."""
    inputs = db.inputs
    if getattr(inputs, "frameSkipCount", 0):
        db.warn("frame-skip-deprecated", "frameSkipCount is deprecated; lower the camera's tickRate instead")
    if inputs.useSystemTime and inputs.resetSimulationTimeOnStop:
        db.warn(
            "system-time-never-resets",
            "useSystemTime stamps with wall time, which resetSimulationTimeOnStop cannot reset",
        )


def add_camera_writer(db: Database, product: RenderProduct, writer: FrameWriter) -> None:
    """Attaches a writer to the product, and notes it in the node's memory."""
    add_writer(db, product, writer)
    db.memory.writers.append((product, writer))


def send_pictures(db: Database, topic: str, type_name: str, make: Callable[[np.ndarray, int], Any]) -> bool:
    """Computes a helper that sends every colour picture of its product on another transport; whether it did.

    make: turns a picture (height, width, 4) uint8 and its stamp [ns] into a message of the type.
    """
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
        every = getattr(inputs, "frameSkipCount", 0) + 1
        message = partial(_picture, memory.annotator, make)
        add_camera_writer(db, product, FrameWriter(app.bus, topic, type_name, stamp, message, every))
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
    warn_about_settings(db)
    annotator = Annotator(find_annotator(kind.annotator), app=app, owner=db.path)
    memory.product, memory.annotator = product, annotator
    stamp = stamps(app, system_time=inputs.useSystemTime, reset_on_stop=inputs.resetSimulationTimeOnStop)
    every, camera = inputs.frameSkipCount + 1, product.camera_path
    make = partial(_message, kind.begin(), annotator, inputs.frameId, app.meters_per_unit, app.settings)
    add_camera_writer(db, product, FrameWriter(app.bus, topic_name(db, camera), kind.type_name, stamp, make, every))
    if inputs.enableSemanticLabels and kind.labelled:
        topic = topic_name(db, camera, inputs.semanticLabelsTopicName)
        add_camera_writer(db, product, FrameWriter(app.bus, topic, STRING, stamp, partial(_labels, annotator), every))


def _check_video(db: Database, product: RenderProduct) -> None:
    """Fails the node without an encoder, and for sizes that H.264 does not have."""
    width, height = product.resolution
    if not has_encoder():
        db.fail(NO_ENCODER)
    if width % 2 or height % 2:
        db.fail(f"type {COMPRESSED} needs an even width and height; {product.path} has {width} x {height} pixels")


def _message(
    make: Callable[[Reading], Any], annotator: Annotator, frame_id: str, unit: float, settings: Any, frame: Any, at: int
) -> Any:
    in_world = bool(settings.get(keys.BOXES_IN_WORLD))
    return make(Reading(frame, annotator.get_data(), at, frame_id, unit, in_world))


def _labels(annotator: Annotator, frame: Any, at: int) -> Any:
    return labels_message(annotator.get_data(), at)
