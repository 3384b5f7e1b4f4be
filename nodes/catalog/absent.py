"""Node types that files use and that cannot work here, listed so that no similar name is suggested instead."""

from __future__ import annotations

_VIDEO = "there is no RTSP server here; ROS2CameraHelper with type rgb_h264 publishes the same video"
_POSES = "its training files are not written here; use annotators of sensors.replicator"
_RL = "randomization of views for learning is not modelled here; write attributes with WritePrimAttribute"
_BUNDLE = "bundles of prims are not modelled here; use ReadPrimAttribute and WritePrimAttribute, one for each attribute"
_MANEUVER = "use Timer with Ease and WritePrimAttribute, which move a prim just so"
_VARIANT = "variants are chosen when the scene is composed: physics and sensors read it at play"
_SOUND = "there is no sound here"
_CURVE = "curves are not deformed here; sensors see them as tubes of their widths"
_EXTERNAL = "steps and clocks are not exchanged between processes here; drive App.update() from the other side"
_WINDOW = "there is no window here"
_SELECTION = "nobody selects prims here; name them"
_LIDAR = "use OgnIsaacExtractRTXSensorPointCloud, or ROS2RtxLidarHelper, which publishes"
_RADAR = "use OgnIsaacExtractRTXSensorPointCloud, or ROS2RtxRadarHelper, which publishes"
_PRINT = "use graph inspect, which prints a frame of a sensor"
_IMMEDIATE = "colliders are asked where physics has them; use the SceneQuery nodes of omni.physx.graph"
_PRIM = "ask with a box or a sphere of the prim's size: SceneQueryOverlapBoxAll, SceneQuerySweepSphereAll"
_VEHICLE = "vehicles of PhysX are not modelled here; build them of bodies and joints"

ABSENT = {
    "isaacsim.streaming.rtsp.RTSPCameraHelper": _VIDEO,
    "isaacsim.examples.ipc.SimpleReceiveExternalStepCpp": _EXTERNAL,
    "isaacsim.examples.ipc.SimpleReceiveExternalStepPy": _EXTERNAL,
    "isaacsim.examples.ipc.SimpleSendSimulationClockCpp": _EXTERNAL,
    "isaacsim.examples.ipc.SimpleSendSimulationClockPy": _EXTERNAL,
    "isaacsim.robot.wheeled_robots.AckermannSteering": "use AckermannController",
    "isaacsim.sensors.physics.IsaacRenderVarToCpuPointer": "use omni.syntheticdata.SdRenderVarPtr",
    "isaacsim.sensors.rtx.IsaacComputeRTXLidarPointCloud": _LIDAR,
    "isaacsim.sensors.rtx.IsaacReadRTXLidarData": _LIDAR,
    "isaacsim.sensors.rtx.IsaacComputeRTXRadarPointCloud": _RADAR,
    "isaacsim.sensors.rtx.IsaacPrintRTXLidarInfo": _PRINT,
    "isaacsim.sensors.rtx.IsaacPrintRTXRadarInfo": _PRINT,
    "isaacsim.util.debug_draw.DebugDrawPointCloud": "use graph view, or showDebugView of ROS2RtxLidarHelper",
    "omni.isaac.ros_bridge.ROS1Master": "ROS 2 has no master; leave the node out",
    "omni.isaac.ros_bridge.ROS1ServiceTeleport": "use ROS2ServicePrim, which sets attributes of prims",
    "omni.physx.graph.GenerateContacts": _IMMEDIATE,
    "omni.physx.graph.ImmediateComputeBoundsOverlaps": _IMMEDIATE,
    "omni.physx.graph.ImmediateComputeGeometryBounds": _IMMEDIATE,
    "omni.physx.graph.ImmediateComputeGeometryOverlaps": _IMMEDIATE,
    "omni.physx.graph.ImmediateComputeGeometryPenetration": _IMMEDIATE,
    "omni.physx.graph.ImmediateComputeMeshIntersectingFaces": _IMMEDIATE,
    "omni.physx.graph.ImmediateGenerateGeometryContacts": _IMMEDIATE,
    "omni.physx.graph.SceneQueryOverlapPrimAll": _PRIM,
    "omni.physx.graph.SceneQueryOverlapPrimAny": _PRIM,
    "omni.physx.graph.SceneQuerySweepPrimAll": _PRIM,
    "omni.physx.graph.SceneQuerySweepPrimAny": _PRIM,
    "omni.physx.graph.SceneQuerySweepPrimClosest": _PRIM,
    "omni.physx.graph.VehicleGetDriveState": _VEHICLE,
    "omni.physx.graph.VehicleGetWheelState": _VEHICLE,
    "isaacsim.replicator.domain_randomization.OgnOnRLFrame": _RL,
    "isaacsim.replicator.domain_randomization.OgnWritePhysicsArticulationView": _RL,
    "isaacsim.replicator.domain_randomization.OgnWritePhysicsRigidPrimView": _RL,
    "isaacsim.replicator.domain_randomization.OgnWritePhysicsSimulationContext": _RL,
    "isaacsim.replicator.writers.Dope": _POSES,
    "isaacsim.replicator.writers.Pose": _POSES,
    "omni.anim.curve.AnimCurve": "its curves are not read here; write time samples, which play",
    "omni.graph.action.OnMouseInput": _WINDOW,
    "omni.graph.action.OnGamepadInput": "there is no gamepad here; use OnKeyboardInput or a Twist subscriber",
    "omni.graph.nodes.ArrayLength": _BUNDLE,
    "omni.graph.nodes.AttributeType": _BUNDLE,
    "omni.graph.nodes.BlendVariants": _VARIANT,
    "omni.graph.nodes.BundleConstructor": _BUNDLE,
    "omni.graph.nodes.BundleInspector": _BUNDLE,
    "omni.graph.nodes.ClearVariantSelection": _VARIANT,
    "omni.graph.nodes.ConstantPrims": _BUNDLE,
    "omni.graph.nodes.CopyAttribute": _BUNDLE,
    "omni.graph.nodes.CreateTubeTopology": _CURVE,
    "omni.graph.nodes.CurveToFrame": _CURVE,
    "omni.graph.nodes.CurveTubePositions": _CURVE,
    "omni.graph.nodes.CurveTubeST": _CURVE,
    "omni.graph.nodes.ExtractAttribute": _BUNDLE,
    "omni.graph.nodes.ExtractBundle": _BUNDLE,
    "omni.graph.nodes.ExtractPrim": _BUNDLE,
    "omni.graph.nodes.GetAttributeNames": _BUNDLE,
    "omni.graph.nodes.GetGraphTargetId": "prims have no numbers here; use GraphTarget, which gives the path",
    "omni.graph.nodes.GetLocationAtDistanceOnCurve": _CURVE,
    "omni.graph.nodes.GetLocationAtDistanceOnCurve2": _CURVE,
    "omni.graph.nodes.GetLookAtRotation": "use MakeTransformLookAt and GetMatrix4Rotation",
    "omni.graph.nodes.GetPrims": _BUNDLE,
    "omni.graph.nodes.GetPrimsAtPath": _BUNDLE,
    "omni.graph.nodes.HasAttribute": _BUNDLE,
    "omni.graph.nodes.InsertAttribute": _BUNDLE,
    "omni.graph.nodes.IsPrimSelected": _SELECTION,
    "omni.graph.nodes.LengthAlongCurve": _CURVE,
    "omni.graph.nodes.LoopTimeline": "the timeline loops where the stage has start and end time codes",
    "omni.graph.nodes.MoveToTarget": _MANEUVER,
    "omni.graph.nodes.MoveToTransform": _MANEUVER,
    "omni.graph.nodes.Noise": "its gradient noise is not documented number by number; use RandomNumeric with isNoise",
    "omni.graph.nodes.PauseSound": _SOUND,
    "omni.graph.nodes.PlaySound": _SOUND,
    "omni.graph.nodes.ReadGamepadState": "there is no gamepad here; use ReadKeyboardState or a Twist subscriber",
    "omni.graph.nodes.ReadMouseState": _WINDOW,
    "omni.graph.nodes.ReadPrim": _BUNDLE,
    "omni.graph.nodes.ReadPrimAttributes": _BUNDLE,
    "omni.graph.nodes.ReadPrimBundle": _BUNDLE,
    "omni.graph.nodes.ReadPrims": _BUNDLE,
    "omni.graph.nodes.ReadPrimsBundle": _BUNDLE,
    "omni.graph.nodes.ReadPrimsBundleV2": _BUNDLE,
    "omni.graph.nodes.ReadPrimsV2": _BUNDLE,
    "omni.graph.nodes.ReadStageSelection": _SELECTION,
    "omni.graph.nodes.RemoveAttribute": _BUNDLE,
    "omni.graph.nodes.RenameAttribute": _BUNDLE,
    "omni.graph.nodes.RotateToOrientation": _MANEUVER,
    "omni.graph.nodes.RotateToTarget": _MANEUVER,
    "omni.graph.nodes.ScaleToSize": _MANEUVER,
    "omni.graph.nodes.SelectPrims": _SELECTION,
    "omni.graph.nodes.SetTimeline": "the timeline cannot be moved while it plays; give the stage its time codes",
    "omni.graph.nodes.SetVariantSelection": _VARIANT,
    "omni.graph.nodes.SourceIndices": "its rule and its documented example contradict each other",
    "omni.graph.nodes.ReadOmniGraphValue": "use ReadPrimAttribute, which reads what was written to Fabric first",
    "omni.graph.nodes.StopAllSound": _SOUND,
    "omni.graph.nodes.StopSound": _SOUND,
    "omni.graph.nodes.StopTimeline": "a stop ends the world that the graph runs in; use ExitApplication",
    "omni.graph.nodes.TranslateToLocation": _MANEUVER,
    "omni.graph.nodes.TranslateToTarget": _MANEUVER,
    "omni.graph.nodes.UpdateTickEvent": "use OnTick",
    "omni.graph.nodes.WritePrim": _BUNDLE,
    "omni.graph.nodes.WritePrims": _BUNDLE,
    "omni.graph.nodes.WritePrimsV2": _BUNDLE,
}
"""Why a type is not available, by its id."""
