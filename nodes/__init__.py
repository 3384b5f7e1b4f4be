"""The node library: which module registers which types.

A type's module is imported when the type is first used, so that a graph costs only the nodes it has. A new type is one
more name here.
"""

from collections.abc import Mapping


def _of(library: str, names: str) -> tuple[str, ...]:
    """The ids of a library's types, from their short names."""
    return tuple(f"{library}.{name}" for name in names.split())


TYPES: Mapping[str, tuple[str, ...]] = {
    "action.application": _of("omni.graph.action", "ExitApplication OnClosing"),
    "action.change_events": _of("omni.graph.action", "OnVariableChange OnObjectChange"),
    "action.custom_events": _of(
        "omni.graph.action",
        "SendCustomEvent OnCustomEvent SendMessageBusEvent OnMessageBusEvent",
    ),
    "action.events": _of("omni.graph.action", "OnPlaybackTick OnTick OnImpulseEvent"),
    "action.flow": _of(
        "omni.graph.action", "Branch Gate Once Counter FlipFlop Multisequence Multigate SwitchToken Sequence"
    ),
    "action.keyboard": (*_of("omni.graph.action", "OnKeyboardInput"), *_of("omni.graph.nodes", "ReadKeyboardState")),
    "action.latent": _of("omni.graph.action", "Countdown Delay"),
    "action.log": (*_of("omni.graph.action", "LogMessage"), *_of("omni.graph.ui_nodes", "PrintText")),
    "action.loops": _of("omni.graph.action", "ForLoop ForEach"),
    "action.prims": _of("omni.graph.action", "SetPrimActive AddPrimRelationship ForEachTarget"),
    "action.stage_events": _of("omni.graph.action", "OnLoaded OnStageEvent"),
    "action.sync_gates": _of("omni.graph.action", "SyncGate RationalTimeSyncGate"),
    "data.arithmetic": _of(
        "omni.graph.nodes",
        "Add Subtract Multiply Divide Modulo Increment Clamp Absolute Negate FMod IsZero AnyZero EachZero",
    ),
    "data.array_edits": _of(
        "omni.graph.nodes",
        "ArrayGetSize ArrayFindValue ArraySetIndex ArrayInsertValue ArrayResize AppendArray",
    ),
    "data.array_parts": _of(
        "omni.graph.nodes",
        "ConstructArray ArrayIndex ArrayAppendValue ArrayFill ArrayRemoveIndex ArrayRemoveValue ArrayRotate "
        "ArraySlice PartialSum",
    ),
    "data.constants": _of(
        "omni.graph.nodes",
        "ConstantBool ConstantInt ConstantInt64 ConstantUChar ConstantUInt ConstantUInt64 ConstantHalf ConstantFloat "
        "ConstantDouble ConstantTimecode ConstantString ConstantToken ConstantPath ConstantTarget ConstantQuatd "
        "ConstantQuatf ConstantQuath ConstantMatrix2d ConstantMatrix3d ConstantMatrix4d ConstantFrame ConstantInt2 "
        "ConstantInt3 ConstantInt4 ConstantHalf2 ConstantHalf3 ConstantHalf4 ConstantFloat2 ConstantFloat3 "
        "ConstantFloat4 ConstantDouble2 ConstantDouble3 ConstantDouble4 ConstantColor3d ConstantColor3f "
        "ConstantColor3h ConstantColor4d ConstantColor4f ConstantColor4h ConstantNormal3d ConstantNormal3f "
        "ConstantNormal3h ConstantPoint3d ConstantPoint3f ConstantPoint3h ConstantTexCoord2d ConstantTexCoord2f "
        "ConstantTexCoord2h ConstantTexCoord3d ConstantTexCoord3f ConstantTexCoord3h ConstantVector3d "
        "ConstantVector3f ConstantVector3h",
    ),
    "data.conversions": _of("omni.graph.nodes", "ToDouble ToString ToFloat ToHalf ToUint64 ToUchar ToToken"),
    "data.easing": _of("omni.graph.nodes", "InterpolateTo Ease Interpolator"),
    "data.functions": _of("omni.graph.nodes", "Sin Cos Tan Asin Acos Atan Ceil Floor Round ToDeg ToRad ATan2"),
    "data.logic": _of(
        "omni.graph.nodes",
        "BooleanAnd BooleanNand BooleanOr BooleanNor BooleanXor BooleanExpr BooleanNot SelectIf Compare",
    ),
    "data.materials": _of("omni.graph.nodes", "WritePrimMaterial ReadPrimMaterial"),
    "data.matrices": _of(
        "omni.graph.nodes",
        "MatrixMultiply OgnInvertMatrix Transpose BreakMatrix2 BreakMatrix3 BreakMatrix4 MakeMatrix2 MakeMatrix3 "
        "MakeMatrix4",
    ),
    "data.metric": _of("example", "Metric"),
    "data.paths": _of(
        "omni.graph.nodes",
        "GetParentPath AppendPath GetRelativePath GetParentPrims AppendTargets AppendTargetPaths CompareTargets "
        "FindTarget GetTargets InsertTargets ReplaceTargets GraphTarget GetGraphTargetPrim SetTarget SelectTargetIf",
    ),
    "data.powers": _of("omni.graph.nodes", "Exponent NthRoot ConstantE ConstantPi Logarithm"),
    "data.prim_attributes": _of("omni.graph.nodes", "ReadPrimAttribute WritePrimAttribute"),
    "data.prim_transforms": _of(
        "omni.graph.nodes",
        "ReadPrimLocalTransform GetPrimLocalToWorldTransform WritePrimLocalTransform GetPrimDirectionVector",
    ),
    "data.prims": _of("omni.graph.nodes", "GetPrimPath GetPrimPaths ToTarget IsPrimActive FindPrims"),
    "data.random_values": _of(
        "omni.graph.nodes",
        "RandomBoolean RandomNumeric RandomGaussian RandomUnitVector RandomUnitQuaternion",
    ),
    "data.relationships": _of(
        "omni.graph.nodes",
        "ReadPrimRelationship GetPrimRelationship WritePrimRelationship HasVariantSet GetVariantSetNames "
        "GetVariantNames GetVariantSelection",
    ),
    "data.settings": _of("omni.graph.nodes", "ReadSetting WriteSetting StartTimeline"),
    "data.strings": _of(
        "omni.graph.nodes",
        "StartsWith EndsWith CapitalizeString GetStringLength FindString InsertString ReplaceString SplitString "
        "IsEmpty BuildString",
    ),
    "data.time": _of("omni.graph.nodes", "ReadTime Timer"),
    "data.transforms": _of(
        "omni.graph.nodes",
        "GetMatrix4Translation GetMatrix4Quaternion GetMatrix4Rotation MakeTransform MakeTransformLookAt "
        "GetMatrix4Scale SetMatrix4Translation SetMatrix4Scale SetMatrix4Quaternion SetMatrix4Rotation RotateVector "
        "TransformVector",
    ),
    "data.variables": _of("omni.graph.core", "ReadVariable WriteVariable"),
    "data.vectors": _of(
        "omni.graph.nodes",
        "BreakVector2 BreakVector3 BreakVector4 MakeVector2 MakeVector3 MakeVector4 Magnitude DotProduct CrossProduct "
        "Normalize Distance3D",
    ),
    "isaac.articulation": _of("isaacsim.core.nodes", "IsaacArticulationController"),
    "isaac.articulation_state": _of("isaacsim.core.nodes", "IsaacArticulationState"),
    "isaac.camera_info": _of("isaacsim.core.nodes", "IsaacReadCameraInfo"),
    "isaac.clocks": _of(
        "isaacsim.core.nodes",
        "IsaacReadSimulationTime IsaacReadSystemTime IsaacRealTimeFactor IsaacTimeSplitter "
        "IsaacReadSimulationTimeAnnotator IsaacReadSystemTimeAnnotator",
    ),
    "isaac.copying": _of("isaacsim.core.nodes", "IsaacTestNode"),
    "isaac.differential": _of("isaacsim.robot.wheeled_robots", "DifferentialController"),
    "isaac.gates": _of("isaacsim.core.nodes", "IsaacSimulationGate OgnIsaacRunOneSimulationFrame"),
    "isaac.joint_names": _of("isaacsim.core.nodes", "IsaacJointNameResolver"),
    "isaac.odometry": _of("isaacsim.core.nodes", "IsaacComputeOdometry"),
    "isaac.outside": _of("isaacsim.core.nodes", "IsaacReadEnvVar IsaacReadFilePath"),
    "isaac.physics_step": _of("isaacsim.core.nodes", "OnPhysicsStep"),
    "isaac.poses": _of("isaacsim.core.nodes", "IsaacReadWorldPose"),
    "isaac.render_products": _of("isaacsim.core.nodes", "IsaacCreateRenderProduct IsaacAttachHydraTexture"),
    "isaac.stage_units": _of("isaacsim.core.nodes", "OgnIsaacScaleToFromStageUnit"),
    "isaac.transform_tree": _of("isaacsim.core.nodes", "IsaacComputeTransformTree"),
    "isaac.viewports": _of(
        "isaacsim.core.nodes",
        "IsaacCreateViewport IsaacGetViewportRenderProduct IsaacSetViewportResolution IsaacSetCameraOnRenderProduct",
    ),
    "lidar.extract": _of("isaacsim.sensors.rtx.nodes", "OgnIsaacExtractRTXSensorPointCloud"),
    "lidar.flat_scan": _of("isaacsim.sensors.rtx", "IsaacComputeRTXLidarFlatScan"),
    "lidar.scan_buffer": _of("isaacsim.sensors.rtx", "IsaacCreateRTXLidarScanBuffer"),
    "ros2.any_topic": _of("isaacsim.ros2.bridge", "ROS2Publisher ROS2Subscriber"),
    "ros2.boxes": _of("isaacsim.ros2.bridge", "ROS2PublishBbox2D ROS2PublishBbox3D"),
    "ros2.camera_helper": _of("isaacsim.ros2.bridge", "ROS2CameraHelper"),
    "ros2.camera_info_helper": _of("isaacsim.ros2.bridge", "ROS2CameraInfoHelper"),
    "ros2.clock": _of("isaacsim.ros2.bridge", "ROS2PublishClock"),
    "ros2.commands": _of(
        "isaacsim.ros2.bridge",
        "ROS2SubscribeTwist ROS2SubscribeJointState ROS2SubscribeClock ROS2SubscribeAckermannDrive",
    ),
    "ros2.context": _of("isaacsim.ros2.bridge", "ROS2Context ROS2QoSProfile"),
    "ros2.follow_transforms": _of("isaacsim.ros2.bridge", "ROS2SubscribeTransformTree"),
    "ros2.images": _of("isaacsim.ros2.bridge", "ROS2PublishImage ROS2PublishCompressedImage ROS2PublishCameraInfo"),
    "ros2.joint_states": _of("isaacsim.ros2.bridge", "ROS2PublishJointState"),
    "ros2.labels": _of("isaacsim.ros2.bridge", "ROS2PublishSemanticLabels ROS2PublishObjectIdMap"),
    "ros2.lidar_helper": _of("isaacsim.ros2.bridge", "ROS2RtxLidarHelper"),
    "ros2.radar_helper": _of("isaacsim.ros2.bridge", "ROS2RtxRadarHelper"),
    "ros2.motion": _of(
        "isaacsim.ros2.bridge",
        "ROS2PublishOdometry ROS2PublishRawTransformTree ROS2PublishImu ROS2PublishAckermannDrive",
    ),
    "ros2.point_cloud_config": _of("isaacsim.ros2.bridge", "ROS2RtxLidarPointCloudConfig"),
    "ros2.publish_laser_scan": _of("isaacsim.ros2.bridge", "ROS2PublishLaserScan"),
    "ros2.publish_point_cloud": _of("isaacsim.ros2.bridge", "ROS2PublishPointCloud"),
    "ros2.transforms": _of("isaacsim.ros2.bridge", "ROS2PublishTransformTree"),
    "script.script_node": _of("omni.graph.scriptnode", "ScriptNode"),
    "sensing.contact": _of("isaacsim.sensors.physics", "IsaacReadContactSensor"),
    "sensing.imu": _of("isaacsim.sensors.physics", "IsaacReadIMU"),
    "sensing.joints": _of("isaacsim.sensors.physics", "IsaacReadEffortSensor IsaacReadJointState"),
    "sensing.raycast": _of("isaacsim.sensors.physics", "IsaacReadRaycastSensor"),
}
"""Ids of types by the module of this package that registers them, in the order in which they are suggested."""
