"""Modules, classes and extensions of Isaac Sim that 6.0 renamed or deprecates, and their replacements."""

from __future__ import annotations

from collections.abc import Mapping

GONE: Mapping[str, str] = {
    "omni.isaac.core.utils.nucleus": "isaacsim.storage.native",
    "isaacsim.core.utils.nucleus": "isaacsim.storage.native",
    "omni.isaac.core.utils": "isaacsim.core.utils",
    "omni.isaac.core.prims": "isaacsim.core.prims",
    "omni.isaac.core.articulations": "isaacsim.core.prims",
    "omni.isaac.core": "isaacsim.core.api",
    "omni.isaac.core_nodes": "isaacsim.core.nodes",
    "omni.isaac.kit": "isaacsim",
    "omni.isaac.sensor": "isaacsim.sensors.camera, .physics or .rtx",
    "omni.isaac.range_sensor": "isaacsim.sensors.physx",
    "omni.isaac.isaac_sensor": "isaacsim.sensors.physics",
    "omni.isaac.ros2_bridge": "isaacsim.ros2.bridge",
    "omni.isaac.ros_bridge": "isaacsim.ros2.bridge",
    "omni.isaac.wheeled_robots": "isaacsim.robot.wheeled_robots",
    "omni.isaac.conveyor": "isaacsim.asset.gen.conveyor",
    "omni.isaac.surface_gripper": "isaacsim.robot.surface_gripper",
    "omni.isaac.manipulators": "isaacsim.robot.manipulators",
    "omni.isaac.debug_draw": "isaacsim.util.debug_draw",
    "omni.isaac.nucleus": "isaacsim.storage.native",
    "omni.isaac.version": "isaacsim.core.version",
    "omni.isaac.cloner": "isaacsim.core.cloner",
    "omni.isaac.franka": "isaacsim.robot.manipulators.examples.franka",
    "omni.isaac.urdf": "isaacsim.asset.importer.urdf",
    "omni.isaac.mjcf": "isaacsim.asset.importer.mjcf",
    "omni.isaac.IsaacSensorSchema": "",
    "omni.isaac.RangeSensorSchema": "",
    "omni.isaac": "the isaacsim module of its name",
    "omni.graph.action_nodes": "omni.graph.action",
}
"""Former modules and extensions that 6.0 does not have; the longest name that matches counts, "" is still there."""

COMPLETE: Mapping[str, str] = {
    "isaacsim.core": "api cloner deprecation_manager experimental nodes prims rendering_manager simulation_manager "
    "throttling utils version",
    "isaacsim.core.experimental": "actuators materials objects prims utils",
    "isaacsim.core.experimental.utils": "app backend bounds foundation impl ops prim semantics stage tests transform "
    "xform",
    "isaacsim.core.utils": "articulations bindings bounds camera_utils carb collisions commands constants "
    "deformable_mesh_utils distance_metrics extensions fabric interops math mesh numpy physics prims random "
    "render_product rotations semantics stage string tests torch transformations types viewports warp xforms",
    "isaacsim.sensors": "camera experimental physics physx rtx",
    "isaacsim.sensors.experimental": "physics rtx",
}
"""Packages of which every module is known, from the wheels of 6.0.1: what else is imported from them does not exist.
Other packages are not judged."""

DEPRECATED: Mapping[str, str] = {
    "isaacsim.core.api.objects": "isaacsim.core.experimental.objects",
    "isaacsim.core.api": "isaacsim.core.experimental, isaacsim.core.simulation_manager and .rendering_manager",
    "isaacsim.core.prims": "isaacsim.core.experimental.prims",
    "isaacsim.core.utils": "isaacsim.core.experimental.utils",
    "isaacsim.replicator.domain_randomization": "isaacsim.replicator.experimental.domain_randomization",
    "isaacsim.robot.wheeled_robots": "isaacsim.robot.experimental.wheeled_robots",
    "isaacsim.sensors.rtx": "isaacsim.sensors.experimental.rtx",
    "isaacsim.sensors.camera": "isaacsim.sensors.experimental.rtx",
    "isaacsim.sensors.physics": "isaacsim.sensors.experimental.physics",
    "isaacsim.util.merge_mesh": "the Scene Optimizer",
}
"""Modules that 6.0 deprecates; those of nodes (`isaacsim.sensors.rtx.nodes`) are not among them."""

STILL_THERE = (
    "isaacsim.robot.wheeled_robots.nodes",
    "isaacsim.robot.wheeled_robots.ui",
    "isaacsim.sensors.rtx.nodes",
    "isaacsim.sensors.physics.nodes",
    "isaacsim.sensors.rtx.generic_model_output",
)

CLASSES: Mapping[str, str] = {
    "LidarRtx": "Lidar and LidarSensor",
    "IsaacSensorCreateRtxLidar": "Lidar.create",
    "IsaacSensorCreateRtxRadar": "Radar.create",
    "IsaacSensorCreateRtxIDS": "an authoring class",
    "IsaacSensorCreateRtxUltrasonic": "Acoustic.create",
}
"""Deprecated classes and Kit commands."""

ANNOTATORS: Mapping[str, str] = {
    "IsaacCreateRTXLidarScanBuffer": "IsaacExtractRTXSensorPointCloud",
    "IsaacCreateRTXLidarScanBufferForFlatScan": "IsaacExtractRTXSensorPointCloud",
    "IsaacComputeRTXLidarFlatScan": "IsaacExtractRTXSensorPointCloud, or ROS2RtxLidarHelper with type laser_scan",
    "IsaacExtractRTXSensorPointCloudNoAccumulator": "IsaacExtractRTXSensorPointCloud",
    "IsaacCreateRTXRadarPointCloud": "IsaacExtractRTXSensorPointCloud",
    "RtxSensorCpuIsaacCreateRTXLidarScanBuffer": "IsaacExtractRTXSensorPointCloud",
    "RtxSensorCpuIsaacComputeRTXLidarFlatScan": "IsaacExtractRTXSensorPointCloud",
    "RtxSensorCpuIsaacReadRTXLidarData": "GenericModelOutput",
    "RtxLidarDebugDrawPointCloudBuffer": "RtxSensorDebugDrawPointCloud",
    "RtxLidarDebugDrawPointCloud": "RtxSensorDebugDrawPointCloud",
    "RtxRadarDebugDrawPointCloud": "RtxSensorDebugDrawPointCloud",
}
"""Deprecated annotators and writers by name."""

PARSERS: Mapping[str, str] = {
    "get_gmo_data": "parse_generic_model_output_data",
    "decode_stable_id_mapping": "parse_stable_id_map_data",
    "get_object_ids": "parse_object_ids",
}
"""Deprecated functions that read sensor data."""


def replacement(name: str, table: Mapping[str, str]) -> str:
    """What replaces a dotted name: by its longest prefix in a table."""
    for known in sorted(table, key=len, reverse=True):
        if name == known or name.startswith(f"{known}."):
            return table[known]
    return ""
