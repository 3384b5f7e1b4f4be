"""A laser scan from one row of depths, as IsaacComputeRTXLidarFlatScan gives it, or from a lidar frame."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.isaac.clocks import stamp_ns

from .laser_scans import LASER_SCAN, laser_scan, scan_style
from .publishing import TIME_STAMP, Publisher, check_names, publisher_inputs, subscribed_topic

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishLaserScan",
    version=3,
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "publishes the scan"),
        **publisher_inputs("scan", frame_id="sim_lidar"),
        "timeStamp": TIME_STAMP,
        "dataPtr": Attribute(
            "uint64", "handle of a lidar frame to bin; 0 takes linearDepthData", default=0, role="data"
        ),
        "bufferSize": Attribute("uint64", "size of dataPtr; the handle knows it", default=0, unit="bytes"),
        "horizontalFov": Attribute("float", "horizontal field of view", default=0, unit="deg"),
        "horizontalResolution": Attribute("float", "angle between neighbouring beams", default=0, unit="deg"),
        "depthRange": Attribute("float[2]", "shortest and longest range", default=[0, 0], unit="m"),
        "rotationRate": Attribute("float", "scans per second; 0 is unknown", default=0, unit="Hz"),
        "linearDepthData": Attribute(
            "float[]", "range of each beam; -1 for an empty one", default=[], unit="m", role="data"
        ),
        "intensitiesData": Attribute(
            "uchar[]", "intensity of each beam; none means 255 where there is a range", default=[]
        ),
        "numRows": Attribute("int", "rows of linearDepthData; must be 1", default=0),
        "numCols": Attribute("int", "beams of linearDepthData", default=0),
        "azimuthRange": Attribute(
            "float[2]", "azimuths of the first and the last beam", default=[0.0, 0.0], unit="deg"
        ),
    },
    memory=partial(Publisher, LASER_SCAN),
)
def publish_laser_scan(db: Database) -> bool:
    """Publish `sensor_msgs/LaserScan`; empty beams are +inf, angle_max is the last beam's (or as the profile says)."""
    inputs = db.inputs
    for name in ("horizontalFov", "horizontalResolution"):
        if not getattr(inputs, name) > 0:
            db.lack(f"input {name} is {getattr(inputs, name):g} deg; give it a positive angle")
    topic = subscribed_topic(db)
    if topic is None:
        return False
    ranges, intensities = _of_frame(db) if inputs.dataPtr else _of_row(db)
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    message = laser_scan(
        ranges,
        intensities,
        start_deg=float(inputs.azimuthRange[0]),
        resolution_deg=inputs.horizontalResolution,
        horizontal_fov_deg=inputs.horizontalFov,
        depth_range=(float(inputs.depthRange[0]), float(inputs.depthRange[1])),
        rotation_rate=inputs.rotationRate,
        nanoseconds=nanoseconds,
        frame_id=inputs.frameId,
        style=scan_style(db.app),
    )
    db.app.bus.publish(topic, LASER_SCAN, message, nanoseconds)
    return True


def _of_row(db: Database) -> tuple[NDArray[np.float32], NDArray[Any]]:
    """Ranges and intensities as given. Fails the node if their sizes differ."""
    import numpy as np

    inputs = db.inputs
    ranges, intensities = inputs.linearDepthData, inputs.intensitiesData
    if inputs.numRows != 1:
        db.fail(f"input numRows is {inputs.numRows}; a laser scan has 1 row")
    if len(ranges) != inputs.numCols:
        db.fail(f"linearDepthData has {len(ranges)} values for {inputs.numCols} columns; they must agree")
    if not len(intensities):
        return ranges, np.where(ranges > 0, 255, 0)
    if len(intensities) != len(ranges):
        db.fail(f"intensitiesData has {len(intensities)} values for {len(ranges)} beams; they must agree")
    return ranges, intensities


def _of_frame(db: Database) -> tuple[NDArray[np.float32], NDArray[Any]]:
    """Ranges and intensities of the frame of dataPtr, binned by azimuth."""
    from nodes.lidar.frames import frame_of_handle
    from sensors.lidar.flat_scan import flat_scan

    flat = flat_scan(frame_of_handle(db, db.inputs.dataPtr), check_2d=False, bins=scan_style(db.app).bins)
    return flat.ranges, flat.intensities
