"""A two-dimensional lidar's frame as one row of depths, binned by azimuth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim import settings as keys

from .frames import (
    CUDA_DEVICE,
    DATA_PTR,
    EXEC,
    RENDER_PRODUCT,
    Reader,
    attach,
    read_lidar_frame,
    release,
    say_deprecated,
)

OLDER = "of an older array interface; the frame is used instead"


def _wanted(db: Database) -> frozenset[str]:
    from sensors.lidar.flat_scan import FLAT_SCAN_CHANNELS

    return FLAT_SCAN_CHANNELS


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Reports a lidar with a beam off the plane, in the profile that stops the run (the other profile logs it)."""
    from graph.base.errors import UserError
    from graph.sim.scene.prim_paths import prim_at
    from sensors.lidar.flat_scan import flat_scan_problem

    for path in node.sensors if node.settings.get(keys.FLAT_SCAN_NEEDS_2D) else ():
        try:
            prim = prim_at(node.stage, path)
            problem = flat_scan_problem(prim) if prim else None
        except UserError:  # reported at the prim
            continue
        if problem:
            yield "", problem


def _prepare(db: Database) -> None:
    attach(db, _wanted)


def _older(name: str, data_type_default: float, **defaults: Any) -> dict[str, Attribute]:
    return {
        f"{name}Ptr": Attribute("uint64", f"{name} buffer {OLDER}", **defaults),
        f"{name}DataType": Attribute("float", f"{name} element type {OLDER}", default=data_type_default),
        f"{name}BufferSize": Attribute("uint64", f"{name} buffer size {OLDER}", unit="bytes", **defaults),
    }


@node_type(
    "isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan",
    version=3,
    needs=(("renderProductPath", "dataPtr"),),
    inputs={
        "exec": EXEC,
        "dataPtr": Attribute("uint64", DATA_PTR, default=0),
        "cudaDeviceIndex": CUDA_DEVICE,
        "bufferSize": Attribute("uint64", f"frame size {OLDER}", unit="bytes"),
        "renderProductPath": RENDER_PRODUCT,
        **_older("azimuth", 4),
        **_older("distance", 4),
        **_older("intensity", 0, default=0),
    },
    outputs={
        "exec": Attribute("execution", "follows when there is a scan"),
        "horizontalFov": Attribute("float", "horizontal field of view", default=0, unit="deg"),
        "horizontalResolution": Attribute("float", "angle between neighbouring beams", default=0, unit="deg"),
        "depthRange": Attribute("float[2]", "shortest and longest range", default=[0, 0], unit="m"),
        "rotationRate": Attribute("float", "scans per second", default=0, unit="Hz"),
        "linearDepthData": Attribute("float[]", "range of each beam; -1 for an empty one", default=[], unit="m"),
        "intensitiesData": Attribute("uchar[]", "intensity of each beam, 0 to 255", default=[]),
        "numRows": Attribute("int", "always 1", default=1),
        "numCols": Attribute("int", "number of beams", default=0),
        "azimuthRange": Attribute(
            "float[2]", "azimuths of the first and the last beam", default=[0.0, 0.0], unit="deg"
        ),
    },
    memory=Reader,
    release=release,
    prepare=_prepare,
    check=_check,
)
def compute_flat_scan(db: Database) -> bool:
    """Bin a frame by azimuth; the last return in a beam wins. A lidar with a beam off the horizontal plane fails."""
    from graph.base.errors import UserError
    from sensors.lidar.flat_scan import flat_scan

    say_deprecated(db, "ROS2RtxLidarHelper with type laser_scan")
    frame = read_lidar_frame(db, _wanted)
    if frame is None or frame.count == 0:
        return False
    try:
        flat = flat_scan(frame, bins=db.app.settings.get(keys.SCAN_BINS))
    except UserError as error:
        if db.app.settings.get(keys.FLAT_SCAN_NEEDS_2D):
            db.fail(str(error))
        if not db.memory.not_flat:
            db.memory.not_flat = True
            db.warn("flat-scan-3d", f"{error}; its outputs stay at their defaults")
        return False
    outputs = db.outputs
    outputs.horizontalFov = flat.horizontal_fov
    outputs.horizontalResolution = flat.horizontal_resolution
    outputs.depthRange = flat.depth_range
    outputs.rotationRate = flat.rotation_rate
    outputs.linearDepthData = flat.ranges
    outputs.intensitiesData = flat.intensities
    outputs.numRows, outputs.numCols = flat.num_rows, flat.num_cols
    outputs.azimuthRange = flat.azimuth_range
    db.fire("exec")
    return True
