"""Chooses the quantities in a lidar helper's clouds."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

# Input -> the name it puts into selectedMetadata, in the order of the list. Ring and Time are our additions.
_CHOICES = {
    "outputIntensity": ("Intensity", "normalised intensity"),
    "outputTimestamp": ("Timestamp", "absolute time of each point [ns], as two 32-bit words"),
    "outputEmitterId": ("EmitterId", "index of the emitter"),
    "outputChannelId": ("ChannelId", "channel of the emitter"),
    "outputMaterialId": ("MaterialId", "encoded non-visual material"),
    "outputTickId": ("TickId", "index of the firing tick within the scan"),
    "outputHitNormal": ("HitNormal", "unit surface normal"),
    "outputVelocity": ("Velocity", "velocity of the hit point [m/s]"),
    "outputObjectId": ("ObjectId", "128-bit id of the prim that was hit"),
    "outputEchoId": ("EchoId", "number of the return, from 0"),
    "outputTickState": ("TickState", "index of the emitter state"),
    "outputRing": ("Ring", "channel as uint16, the field that SLAM front ends read"),
    "outputTime": ("Time", "seconds after the header's stamp, the field that SLAM front ends read"),
}


@node_type(
    "isaacsim.ros2.bridge.ROS2RtxLidarPointCloudConfig",
    version=1,
    inputs={name: Attribute("bool", f"add {what}", default=False) for name, (_, what) in _CHOICES.items()},
    outputs={"selectedMetadata": Attribute("token[]", "names for ROS2RtxLidarHelper's selectedMetadata", default=[])},
)
def point_cloud_config(db: Database) -> None:
    """List the chosen quantities by name."""
    inputs = db.inputs
    db.outputs.selectedMetadata = [name for choice, (name, _) in _CHOICES.items() if getattr(inputs, choice)]
