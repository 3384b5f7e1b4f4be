"""Converts depth images to points."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from nodes.ros2.camera_messages import points_of

from .images import CUDA_IN, CUDA_OUT, Given, buffer_of, give, given, release


@node_type(
    "isaacsim.core.nodes.IsaacConvertDepthToPointCloud",
    version=1,
    inputs={
        "execIn": Attribute("execution", "converts the image"),
        "dataPtr": Attribute("uint64", "handle of distances from the image plane, float32, row by row", default=0),
        "cudaDeviceIndex": CUDA_IN,
        "width": Attribute("uint", "width of the image", unit="px"),
        "height": Attribute("uint", "height of the image", unit="px"),
        "focalLength": Attribute("float", "focal length of the camera, in the unit of its apertures"),
        "horizontalAperture": Attribute("float", "width of the camera's film, in the unit of the focal length"),
        "verticalAperture": Attribute("float", "height of the camera's film; not used, since pixels are square"),
        "bufferSize": Attribute("uint", "size of the image", unit="bytes"),
        "format": Attribute("uint64", "texture format; only 33, one float32 a pixel", default=33),
    },
    outputs={
        "execOut": Attribute("execution", "follows every cloud"),
        "dataPtr": Attribute("uint64", "handle of the points, float32 x 3, unit of the distances", default=0),
        "cudaDeviceIndex": CUDA_OUT,
        "bufferSize": Attribute("uint", "size of the points", unit="bytes"),
        "height": Attribute("uint", "always 1", default=1),
        "width": Attribute("uint", "number of points, one a pixel", default=0),
    },
    memory=Given,
    release=release,
)
def convert_depth_to_point_cloud(db: Database) -> bool:
    """Place every pixel in the camera frame of ROS (x right, y down, z forward); NaN without a finite distance."""
    if not given(db):
        return False

    inputs, outputs = db.inputs, db.outputs
    if inputs.format != 33:
        db.fail(f"input format is {inputs.format}; only 33, one float32 a pixel, can be converted")
    if not min(inputs.focalLength, inputs.horizontalAperture) > 0:
        db.lack("focalLength and horizontalAperture must be above 0; connect IsaacReadCameraInfo")
    width, height = inputs.width, inputs.height
    depths = buffer_of(db, "f4", width, height, 1)[:, :, 0]
    points = points_of(depths, width * inputs.focalLength / inputs.horizontalAperture)
    outputs.dataPtr, outputs.bufferSize = give(db, points), points.nbytes
    outputs.width, outputs.height, outputs.cudaDeviceIndex = len(points), 1, -1
    db.fire("execOut")
    return True
