"""Images and camera parameters as ROS 2 topics."""

from __future__ import annotations

from functools import partial
from typing import Any

from graph.node import Attribute, Database, node_type
from sensors import handles

from .image_messages import CAMERA_INFO, COMPRESSED, IMAGE, PIXEL_BYTES, as_bytes, camera_info, compressed_image, image
from .publishing import Publisher, check_names, publishes, stamped_inputs

DATA_PTR = Attribute("uint64", "handle of the pixels; 0 takes data", default=0, role="data")
CUDA_DEVICE = Attribute("int", "must stay -1: pixels are in host memory", default=-1)
PLUMB_BOB = "plumb_bob"


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishImage",
    version=1,
    check=check_names,
    inputs={
        **stamped_inputs("rgb", frame_id="sim_camera"),
        "data": Attribute("uchar[]", "pixels, rows from the top", default=[], role="data"),
        "width": Attribute("uint", "pixels in a row", default=0, unit="px"),
        "height": Attribute("uint", "rows of pixels", default=0, unit="px"),
        "encoding": Attribute(
            "token",
            "what a pixel is: bytes for the colours, or a depth [m] or an id of four bytes",
            default="rgb8",
            allowed_tokens=("rgb8", "rgba8", "32FC1", "32SC1"),
        ),
        "dataPtr": DATA_PTR,
        "cudaDeviceIndex": CUDA_DEVICE,
        "bufferSize": Attribute("uint", "size of dataPtr; not needed, the handle knows", unit="bytes"),
        "format": Attribute("uint64", "pixel format of dataPtr; not needed, encoding says it"),
    },
    memory=partial(Publisher, IMAGE),
)
@publishes
def publish_image(db: Database, nanoseconds: int) -> Any:
    """Publish `sensor_msgs/Image`; without pixels (before the first frame) nothing is sent."""
    return image_of(db, nanoseconds, db.inputs.frameId)


def image_of(db: Database, nanoseconds: int, frame_id: str) -> Any:
    """The message of an image publisher's inputs; None without pixels."""
    inputs = db.inputs
    data = pixels(db)
    if not data.size:
        return None
    width, height, encoding = inputs.width, inputs.height, inputs.encoding
    if encoding not in PIXEL_BYTES:
        db.fail(f'encoding "{encoding}" is unknown; use one of {", ".join(PIXEL_BYTES)}')
    expected = width * height * PIXEL_BYTES[encoding]
    if data.size != expected:
        db.fail(
            f"{width} x {height} pixels of {encoding} are {expected} bytes, but there are {data.size}; "
            "correct width, height or encoding"
        )
    return image(nanoseconds, frame_id, width, height, encoding, data)


def pixels(db: Database) -> Any:
    """(n,) uint8: the buffer of dataPtr, else the input data. Fails the node for device memory."""
    inputs = db.inputs
    if getattr(inputs, "cudaDeviceIndex", -1) != -1:
        db.fail(f"cudaDeviceIndex {inputs.cudaDeviceIndex}: pixels are in host memory; set it to -1")
    if not inputs.dataPtr:
        return as_bytes(inputs.data)
    found = handles.resolve(inputs.dataPtr)
    if found is None:
        db.fail(f"dataPtr {inputs.dataPtr} refers to no live image; connect it to the node that makes the image")
    return as_bytes(found)


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishCompressedImage",
    version=1,
    check=check_names,
    inputs={
        **stamped_inputs("image_raw/compressed", frame_id="sim_camera"),
        "data": Attribute("uchar[]", "the encoded image", default=[], role="data"),
        "dataPtr": Attribute("uint64", "handle of the encoded image; 0 takes data", default=0, role="data"),
        "bufferSize": Attribute("uint64", "size of dataPtr; not needed, the handle knows", default=0, unit="bytes"),
        "input_format": Attribute("token", "how the image is encoded", default="h264", allowed_tokens=("h264",)),
    },
    memory=partial(Publisher, COMPRESSED),
)
@publishes
def publish_compressed_image(db: Database, nanoseconds: int) -> Any:
    """Publish `sensor_msgs/CompressedImage`; without data nothing is sent."""
    data = pixels(db)
    return compressed_image(nanoseconds, db.inputs.frameId, db.inputs.input_format, data) if data.size else None


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishCameraInfo",
    version=2,
    check=check_names,
    inputs={
        **stamped_inputs("camera_info", frame_id="sim_camera"),
        "width": Attribute("uint", "pixels in a row", unit="px"),
        "height": Attribute("uint", "rows of pixels", unit="px"),
        "projectionType": Attribute("token", "the camera's projection; told apart by the distortion model"),
        "k": Attribute("double[]", "intrinsic matrix 3 x 3, row by row", unit="px", role="data"),
        "r": Attribute("double[]", "rectification matrix 3 x 3, row by row; empty is the identity"),
        "p": Attribute("double[]", "projection matrix 3 x 4, row by row; empty is k without rectification", unit="px"),
        "physicalDistortionModel": Attribute("token", f"distortion model; empty is {PLUMB_BOB}"),
        "physicalDistortionCoefficients": Attribute("float[]", "its coefficients; empty means no distortion"),
    },
    memory=partial(Publisher, CAMERA_INFO),
)
@publishes
def publish_camera_info(db: Database, nanoseconds: int) -> Any:
    """Publish `sensor_msgs/CameraInfo`."""
    inputs = db.inputs
    for name, count, needed in (("k", 9, True), ("r", 9, False), ("p", 12, False)):
        found = len(getattr(inputs, name))
        if found != count and (found or needed):
            db.lack(f"{name} has {found} values; it needs {count}, row by row")
    k = inputs.k.tolist()
    r = inputs.r.tolist() or [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    p = inputs.p.tolist() or [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]
    model = inputs.physicalDistortionModel or PLUMB_BOB
    coefficients = inputs.physicalDistortionCoefficients.tolist()
    if model == PLUMB_BOB and not coefficients:
        coefficients = [0.0] * 5
    return camera_info(nanoseconds, inputs.frameId, (inputs.width, inputs.height), (model, coefficients), k, r, p)
