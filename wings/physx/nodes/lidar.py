"""The rotating lidar of PhysX: its points, and its beams."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.node import Attribute, Database, NodeAtLoad, node_type

from .polling import Poll, check_polled, poll, release

if TYPE_CHECKING:
    from sensors.frame import Frame

_LIDAR = Attribute("target", "a Lidar prim of PhysX")


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    from wings.physx.names import LIDAR

    return check_polled(node, "lidarPrim", LIDAR)


def _new_scan(db: Database, channels: tuple[str, ...]) -> Frame | None:
    """The scan that this node has not given yet."""
    from wings.physx.names import LIDAR

    frame = poll(db, "lidarPrim", LIDAR, channels)
    if frame is None or frame is db.memory.frame:
        return None
    db.memory.frame = frame
    return frame


@node_type(
    "isaacsim.sensors.physx.IsaacReadLidarPointCloud",
    version=2,
    check=_check,
    inputs={"execIn": Attribute("execution", "reads the sensor"), "lidarPrim": _LIDAR},
    outputs={
        "execOut": Attribute("execution", "follows when a scan is complete"),
        "data": Attribute("pointf[3][]", "where the beams hit, in the sensor's axes", default=[], unit="m"),
    },
    memory=Poll,
    release=release,
)
def read_lidar_point_cloud(db: Database) -> None:
    """Read the points of a whole scan: at rotationRate 0 in every update, else once a turn.

    Beams that hit nothing, or something maxRange away or farther, give no point.
    """
    scan = _new_scan(db, ("xyz", "distance", "flags"))
    if scan is None:
        return
    hit = (scan.channel("flags") != 0) & (scan.channel("distance") < scan.config.ranges[1])
    db.outputs.data = scan.xyz[hit]
    db.fire("execOut")


@node_type(
    "isaacsim.sensors.physx.IsaacReadLidarBeams",
    version=1,
    check=_check,
    inputs={"execIn": Attribute("execution", "reads the sensor"), "lidarPrim": _LIDAR},
    outputs={
        "execOut": Attribute("execution", "follows when a scan is complete"),
        "horizontalFov": Attribute("float", "horizontal field of view", default=0, unit="deg"),
        "verticalFov": Attribute("float", "vertical field of view", default=0, unit="deg"),
        "horizontalResolution": Attribute("float", "angle between columns", default=0, unit="deg"),
        "verticalResolution": Attribute("float", "angle between rows", default=0, unit="deg"),
        "depthRange": Attribute("float[2]", "minRange and maxRange", default=[0, 0], unit="m"),
        "rotationRate": Attribute("float", "turns per second; 0 fires all beams at once", default=0, unit="Hz"),
        "beamTimeData": Attribute(
            "float[]", "simulation time of the update in which each beam was fired", default=[], unit="s"
        ),
        "linearDepthData": Attribute(
            "float[]", "how far each beam goes, column after column; maxRange if it hits nothing", default=[], unit="m"
        ),
        "intensitiesData": Attribute("uchar[]", "255 if the beam hits something, else 0", default=[]),
        "numRows": Attribute("int", "beams in a column", default=0),
        "numCols": Attribute("int", "columns in a scan", default=0),
        "azimuthRange": Attribute(
            "float[2]", "azimuths of the first and the last column", default=[0.0, 0.0], unit="deg"
        ),
        "zenithRange": Attribute(
            "float[2]", "angles of the first and the last row, downwards positive", default=[0.0, 0.0], unit="deg"
        ),
    },
    memory=Poll,
    release=release,
)
def read_lidar_beams(db: Database) -> None:
    """Read the beams of a whole scan: at rotationRate 0 in every update, else once a turn."""
    import numpy as np

    scan, outputs = _new_scan(db, ("distance", "flags", "beamTime")), db.outputs
    if scan is None:
        return
    config = scan.config
    outputs.horizontalFov, outputs.verticalFov = config.horizontal_fov, config.vertical_fov
    outputs.horizontalResolution = config.horizontal_resolution
    outputs.verticalResolution = config.vertical_resolution
    outputs.depthRange, outputs.rotationRate = config.ranges, float(config.rotation_rate)
    outputs.numRows, outputs.numCols = config.rows, config.columns
    outputs.azimuthRange = config.azimuths[[0, -1]]
    outputs.zenithRange = config.zeniths[[0, -1]]
    outputs.beamTimeData, outputs.linearDepthData = scan.channel("beamTime"), scan.channel("distance")
    outputs.intensitiesData = np.where(scan.channel("flags"), np.uint8(255), np.uint8(0))
    db.fire("execOut")
