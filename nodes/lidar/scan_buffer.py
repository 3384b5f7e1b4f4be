"""A frame of a lidar or radar as separate buffers, each on request."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .buffers import cloud_attributes, write_buffers
from .frames import (
    CUDA_DEVICE,
    DATA_PTR,
    EXEC,
    RENDER_PRODUCT,
    Reader,
    attach,
    cloud_channels,
    read_frame,
    release,
    say_deprecated,
)

# Input flag -> buffer.
FLAGS = {
    "outputAzimuth": "azimuth",
    "outputElevation": "elevation",
    "outputDistance": "distance",
    "outputIntensity": "intensity",
    "outputTimestamp": "timestamp",
    "outputEmitterId": "emitterId",
    "outputChannelId": "channelId",
    "outputMaterialId": "materialId",
    "outputTickId": "tickId",
    "outputHitNormal": "hitNormal",
    "outputVelocity": "velocity",
    "outputObjectId": "objectId",
    "outputEchoId": "echoId",
    "outputTickState": "tickState",
    "outputRadialVelocityMS": "radialVelocityMS",
}
NO_EFFECT = "without effect, as in the original"


def _names(db: Database) -> frozenset[str]:
    inputs = db.inputs
    return frozenset(name for flag, name in FLAGS.items() if getattr(inputs, flag))


def _wanted(db: Database) -> frozenset[str]:
    return cloud_channels(db, _names(db))


def _prepare(db: Database) -> None:
    attach(db, _wanted)


@node_type(
    "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer",
    version=3,
    needs=(("renderProductPath", "dataPtr"),),
    inputs={
        "exec": EXEC,
        "dataPtr": Attribute("uint64", DATA_PTR),
        "cudaDeviceIndex": CUDA_DEVICE,
        "keepOnlyPositiveDistance": Attribute("bool", NO_EFFECT, default=True),
        "transformPoints": Attribute("bool", NO_EFFECT, default=False),
        "accuracyErrorAzimuthDeg": Attribute("float", NO_EFFECT, unit="deg"),
        "accuracyErrorElevationDeg": Attribute("float", NO_EFFECT, unit="deg"),
        "accuracyErrorPosition": Attribute("float[3]", NO_EFFECT, unit="m"),
        "renderProductPath": RENDER_PRODUCT,
        **{flag: Attribute("bool", f"fill {name}Ptr", default=False) for flag, name in FLAGS.items()},
        "enablePerFrameOutput": Attribute("bool", NO_EFFECT, default=False),
    },
    outputs=cloud_attributes("stage units"),
    memory=Reader,
    release=release,
    prepare=_prepare,
)
def create_scan_buffer(db: Database) -> bool:
    """Give a frame's points and the requested buffers, lengths in stage units, of a lidar or a radar.

    A buffer above the prim's auxiliary level, or that the sensor does not measure, stays empty. For a frame without
    points the outputs keep their values.
    """
    from sensors.annotators import outputs

    say_deprecated(db, "IsaacExtractRTXSensorPointCloud")
    frame = read_frame(db, _wanted)
    if frame is None or frame.count == 0:
        return False
    scan = outputs.scan_buffer(frame, db.app.meters_per_unit, _names(db))
    write_buffers(db, scan)
    db.fire("exec")
    return True
