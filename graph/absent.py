"""Node types that files name and that cannot work here, so that no other is offered in their place."""

from __future__ import annotations

_CAMERAS = "cameras are not rendered here"
_PHYSX = "PhysX's own ray sensors are not modelled here; an OmniLidar prim measures the same"

ABSENT = {
    "isaacsim.ros2.bridge.ROS2CameraHelper": _CAMERAS,
    "isaacsim.ros2.bridge.ROS2CameraInfoHelper": _CAMERAS,
    "isaacsim.ucx.nodes.UCXCameraHelper": _CAMERAS,
    "isaacsim.hsb.nodes.HSBCameraHelper": _CAMERAS,
    "isaacsim.streaming.rtsp.RTSPCameraHelper": _CAMERAS,
    "isaacsim.ros2.bridge.ROS2RtxRadarHelper": "radars are not modelled here",
    "isaacsim.sensors.physics.IsaacReadRaycastSensor": _PHYSX,
    "isaacsim.sensors.physx.IsaacReadLidarBeams": _PHYSX,
    "isaacsim.sensors.physx.IsaacReadLidarPointCloud": _PHYSX,
    "isaacsim.sensors.physx.IsaacReadLightBeam": _PHYSX,
    "isaacsim.util.debug_draw.DebugDrawRayCast": "nothing is drawn here",
    "omni.graph.action.OnMouseInput": "there is no window here",
    "omni.graph.action.OnGamepadInput": "there is no gamepad here",
}
"""Why a type is not there, by its id."""


def why_absent(name: str) -> str | None:
    """The reason, for an id or its last part; None for a name that no such type has."""
    if name in ABSENT:
        return ABSENT[name]
    if "." in name:
        return None
    return next((why for known, why in ABSENT.items() if known.rpartition(".")[2] == name), None)
