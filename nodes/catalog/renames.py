"""Former names of node types and attributes, and their present names.

Sources: the extension renaming of Isaac Sim 4.5 (`omni.isaac.*` to `isaacsim.*`), the removal of the ROS 1 bridge, and
the attributes of older type versions found in saved graphs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

PREFIXES: Mapping[str, tuple[str, ...]] = {
    "omni.isaac.ros2_bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.ros_bridge.": ("isaacsim.ros2.bridge.",),
    "isaacsim.ros2.nodes.": ("isaacsim.ros2.bridge.",),
    "isaacsim.ros1.bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.core_nodes.": ("isaacsim.core.nodes.",),
    "omni.isaac.wheeled_robots.": ("isaacsim.robot.wheeled_robots.",),
    "isaacsim.robot.wheeled_robots.nodes.": ("isaacsim.robot.wheeled_robots.",),
    "omni.isaac.sensor.": (
        "isaacsim.sensors.physics.",
        "isaacsim.sensors.rtx.",
        "isaacsim.sensors.physx.",
        "isaacsim.sensors.rtx.nodes.Ogn",
    ),
    "omni.isaac.isaac_sensor.": ("isaacsim.sensors.physics.", "isaacsim.sensors.rtx.", "isaacsim.sensors.physx."),
    "omni.isaac.range_sensor.": ("isaacsim.sensors.physx.", "isaacsim.sensors.rtx.", "isaacsim.sensors.physics."),
    "isaacsim.sensors.physics.nodes.": ("isaacsim.sensors.physics.",),
    "isaacsim.sensors.rtx.nodes.": ("isaacsim.sensors.rtx.", "isaacsim.sensors.rtx.nodes.Ogn"),
    "omni.isaac.conveyor.": ("isaacsim.asset.gen.conveyor.",),
    "omni.isaac.surface_gripper.": ("isaacsim.robot.surface_gripper.",),
    "omni.isaac.manipulators.": ("isaacsim.robot.manipulators.",),
    "omni.isaac.debug_draw.": ("isaacsim.util.debug_draw.",),
    "isaacsim.ucx.bridge.": ("isaacsim.ucx.nodes.",),
    "isaacsim.ucx.nodes.": ("isaacsim.ucx.bridge.",),
    "omni.graph.ui.": ("omni.graph.ui_nodes.",),
    "omni.graph.action_nodes.": ("omni.graph.action.",),
    "omni.graph.action_nodes_core.": ("omni.graph.action.",),
    "omni.graph.nodes_core.": ("omni.graph.nodes.",),
}
"""Former prefixes of type ids and their possible present ones; the first that gives a registered type is used."""

TYPES: Mapping[str, str] = {
    "omni.graph.nodes.ReadVariable": "omni.graph.core.ReadVariable",
    "omni.graph.nodes.WriteVariable": "omni.graph.core.WriteVariable",
    "omni.graph.ui.PrintText": "omni.graph.ui_nodes.PrintText",
    "omni.graph.action.PrintText": "omni.graph.ui_nodes.PrintText",
    "omni.isaac.core_nodes.IsaacSetViewportResolution": "isaacsim.core.nodes.IsaacSetViewportResolution",
    "omni.graph.scriptnode.OgnScriptNode": "omni.graph.scriptnode.ScriptNode",
    "omni.graph.nodes.MakeArray": "omni.graph.nodes.ConstructArray",
}
"""Former ids that follow no rule."""

_GRIPPER = (
    *("ParentRigidBody", "GripPosition", "GripThreshold", "ForceLimit", "TorqueLimit", "BendAngle"),
    *("Stiffness", "Damping", "DisableGravity", "RetryClose", "onStep", "Delta"),
)
"""Inputs of SurfaceGripper up to Isaac Sim 4.5; they are attributes of an IsaacSurfaceGripper prim now."""

_LENS = ("focalLength", "horizontalAperture", "verticalAperture", "horizontalOffset", "verticalOffset", "stereoOffset")
"""Inputs of ROS2PublishCameraInfo in version 1; k, r and p hold the lens now."""

RENAMED: Mapping[str, Mapping[str, str]] = {
    "isaacsim.core.nodes.IsaacReadSimulationTime": {},
    "isaacsim.ros2.bridge.ROS2Context": {"inputs:domainId": "inputs:domain_id"},
    "isaacsim.ros2.bridge.ROS2PublishTransformTree": {"inputs:targetPrim": "inputs:targetPrims"},
    "isaacsim.core.nodes.IsaacArticulationController": {"inputs:usePath": ""},
    "isaacsim.core.nodes.IsaacComputeOdometry": {"inputs:robotPrim": "inputs:chassisPrim"},
    "isaacsim.robot.surface_gripper.SurfaceGripper": {f"inputs:{name}": "" for name in _GRIPPER}
    | {"outputs:Closed": ""},
    "isaacsim.robot.wheeled_robots.DifferentialController": {
        "outputs:positionCommand": "",
        "outputs:effortCommand": "",
    },
    "isaacsim.robot.wheeled_robots.HolonomicController": {
        "inputs:velocityCommands": "inputs:inputVelocity",
        "outputs:jointPositionCommand": "",
        "outputs:jointEffortCommand": "",
    },
    "isaacsim.sensors.physx.IsaacReadLidarPointCloud": {"outputs:pointCloudData": "outputs:data"},
    "isaacsim.ros2.bridge.ROS2PublishPointCloud": {"inputs:pointCloudData": "inputs:data"},
    "isaacsim.ros2.bridge.ROS2PublishCameraInfo": {f"inputs:{name}": "" for name in _LENS},
    "omni.graph.nodes.ConstructArray": {f"inputs:{old}": f"inputs:input{new}" for new, old in enumerate("abcde")},
}
"""Attributes by present type id: former full name to the present one, "" if it was removed."""

REMOVED: Mapping[str, str] = {
    "inputs:swhFrameNumber": "use the reference time inputs for the time of a past frame",
    "inputs:resetSimulationTimeOnStop": "set resetOnStop of the node that reads the time",
    "inputs:viewport": "connect renderProductPath",
    "inputs:forceUSDRead": "values are always read as they are now",
    "inputs:ParentRigidBody": "author an IsaacSurfaceGripper prim and name it in SurfaceGripper",
    "inputs:GripPosition": "author isaac:attachmentPoints of an IsaacSurfaceGripper prim",
    "inputs:nodeType": "it has no meaning any more",
}
"""Attributes of old type versions, for every present type that does not have them, and what to do instead."""

KINDS: Mapping[tuple[str, str], Mapping[str, str]] = {
    ("isaacsim.ros2.bridge.ROS2CameraHelper", "type"): {
        "camera_info": "isaacsim.ros2.bridge.ROS2CameraInfoHelper",
    },
}
"""By type id and input: values that made it do what a type of its own does now; its other inputs have their names."""

MEANT_NOTHING: Mapping[str, tuple[int, Mapping[str, Any]]] = {
    "omni.graph.nodes.ReadPrimAttribute": (3, {"usdTimecode": -1}),
    "omni.graph.nodes.ReadPrimAttributes": (3, {"usdTimecode": -1}),
}
"""By type: the first version in which these values are explicit; older files wrote them for "unset"."""
