"""What the examples of some node types need besides defaults: a robot, a lidar, a message type."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass, field
from sensors.lidar.names import PRIM_TYPE

if TYPE_CHECKING:
    from graph.node import NodeType

THING = "/World/Thing"
ROBOT = "/World/Robot"
LIDAR = "/World/Lidar"
CAMERA = "/World/Camera"


@dataclass(frozen=True)
class Parts:
    """Additions to an example.

    inputs: values that replace defaults; prims: by path, as YAML; product: whether a render product of `sensor` starts
    the node and is connected to it; needs: one line on what the reader must provide, "" if the example runs unchanged.
    """

    inputs: Mapping[str, Any] = field(default_factory=dict)
    prims: Mapping[str, str] = field(default_factory=dict)
    product: bool = False
    sensor: str = LIDAR
    needs: str = ""


LIDAR_WORLD = {
    LIDAR: f"{{type: {PRIM_TYPE}, config: Example_Rotary_2D}}",
    "/World/Wall": "{type: Cube, translate: [4, 0, 0]}",
}
CAMERA_WORLD = {
    CAMERA: "{type: Camera, translate: [0, 0, 1], rotate: [90, 0, -90]}",
    "/World/Wall": "{type: Cube, translate: [4, 0, 0]}",
    "/World/Sky": "{type: DomeLight, attributes: {inputs:intensity: 1000}}",
}
_RADAR = {
    "/World/Radar": '{type: OmniRadar, attributes: {"omni:sensor:tickRate": 10}}',
    "/World/Wall": "{type: Cube, translate: [10, 0, 0]}",
}
_JOINT = (
    "schemas: [PhysicsDriveAPI:{drive}], attributes: {{physics:axis: Y, physics:body1: {body}, "
    "physics:localPos0: [0, 0, 1], physics:lowerLimit: 0, physics:upperLimit: {upper}, "
    "drive:{drive}:physics:stiffness: 100}}"
)


def robot(joint: str, drive: str, upper: float) -> dict[str, str]:
    """A body on one driven joint, a metre above the origin."""
    body = f"{ROBOT}/arm"
    return {
        ROBOT: "{schemas: PhysicsArticulationRootAPI}",
        body: "{type: Cube, size: 0.2, translate: [0, 0, 1], rigid_body: true, mass: 1}",
        f"{ROBOT}/joint": f"{{type: {joint}, {_JOINT.format(drive=drive, body=body, upper=upper)}}}",
    }


ARM = robot("PhysicsRevoluteJoint", "angular", 90)
_VARIANTS = "a USD scene with a prim that has a variant set, named at prim and variantSetName"
THINGS = {THING: "{type: Cube, rigid_body: true}"}

PARTS: dict[str, Parts] = {
    "AddPrimRelationship": Parts({"name": "partner", "path": THING, "target": "/World"}, THINGS),
    "AppendPath": Parts({"path": {"type": "token", "value": "/World"}, "suffix": "Thing"}),
    "DifferentialController": Parts({"wheelRadius": 0.1, "wheelDistance": 0.5, "linearVelocity": 1.0}),
    "GetParentPath": Parts({"path": {"type": "token", "value": "/World/Thing"}}),
    "GetPrimRelationship": Parts({"prim": f"{ROBOT}/joint", "name": "physics:body1"}, ARM),
    "GetRelativePath": Parts({"anchor": "/World", "path": {"type": "token", "value": "/World/Thing"}}),
    "GetVariantNames": Parts(needs=_VARIANTS),
    "GetVariantSelection": Parts(needs=_VARIANTS),
    "Interpolator": Parts({"knots": [0.0, 1.0, 3.0], "values": [0.0, 10.0, 30.0], "param": 0.5}),
    "IsaacArticulationController": Parts({"targetPrim": ROBOT, "positionCommand": [0.5]}, ARM),
    "IsaacArticulationState": Parts({"targetPrim": ROBOT}, ARM),
    "IsaacAttachHydraTexture": Parts(
        {"renderProductPrim": "/World/Product"},
        {**LIDAR_WORLD, "/World/Product": f"{{type: RenderProduct, attributes: {{camera: {LIDAR}}}}}"},
    ),
    "IsaacComputeRTXLidarFlatScan": Parts(prims=LIDAR_WORLD, product=True),
    "IsaacCreateRTXLidarScanBuffer": Parts(prims=LIDAR_WORLD, product=True),
    "IsaacJointNameResolver": Parts({"targetPrim": ROBOT, "jointNames": ["joint"]}, ARM),
    "IsaacReadCameraInfo": Parts(needs="the render product of a camera at renderProductPath"),
    "IsaacReadEffortSensor": Parts({"prim": f"{ROBOT}/joint"}, ARM),
    "IsaacReadFilePath": Parts({"path": "notes.txt"}, needs="a text file notes.txt beside this one"),
    "IsaacReadJointState": Parts({"prim": ROBOT}, ARM),
    "IsaacReadRaycastSensor": Parts(
        {"raycastSensorPrim": "/World/Ray"},
        {
            "/World/Ray": (
                "{type: IsaacRaycastSensor, attributes: {numRays: 2, rayOrigins: [[0, 0, 0], [0, 0, 0]], "
                "rayDirections: [[1, 0, 0], [0, 1, 0]]}}"
            ),
            "/World/Wall": "{type: Cube, translate: [4, 0, 0]}",
        },
    ),
    "IsaacSetCameraOnRenderProduct": Parts({"cameraPrim": LIDAR}, LIDAR_WORLD, product=True),
    "OgnIsaacExtractRTXSensorPointCloud": Parts(prims=LIDAR_WORLD, product=True),
    "ReadPrimRelationship": Parts({"prim": f"{ROBOT}/joint", "name": "physics:body1"}, ARM),
    "ReadSetting": Parts({"settingPath": "/app/runLoops/main/rateLimitFrequency"}),
    "ROS2CameraHelper": Parts(prims=CAMERA_WORLD, product=True, sensor=CAMERA),
    "ROS2CameraInfoHelper": Parts(prims=CAMERA_WORLD, product=True, sensor=CAMERA),
    "ROS2PublishCameraInfo": Parts(
        {
            "width": 640,
            "height": 480,
            "k": [500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0],
            "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "p": [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        }
    ),
    "ROS2PublishJointState": Parts({"targetPrim": ROBOT}, ARM),
    "ROS2PublishLaserScan": Parts(
        {
            "horizontalFov": 90,
            "horizontalResolution": 45,
            "depthRange": [0.1, 30.0],
            "linearDepthData": [4.0, 3.5, 4.0],
            "numRows": 1,
            "numCols": 3,
            "azimuthRange": [-45.0, 45.0],
        }
    ),
    "ROS2Publisher": Parts({"messagePackage": "geometry_msgs", "messageName": "Point", "x": 1.5}),
    "ROS2RtxLidarHelper": Parts(prims=LIDAR_WORLD, product=True),
    "ROS2RtxRadarHelper": Parts(prims=_RADAR, product=True, sensor="/World/Radar"),
    "ROS2Subscriber": Parts({"messagePackage": "geometry_msgs", "messageName": "Point"}),
    "ScriptNode": Parts(needs="your leave to run its script: graph run --allow-scripts"),
    "SetPrimActive": Parts({"primTarget": THING}, {THING: "{type: Scope}"}),
    "SetTarget": Parts({"targets": THING, "setTarget": "/World"}, THINGS),
    "ToTarget": Parts({"value": {"type": "token", "value": THING}}, THINGS),
    "WritePrimAttribute": Parts(
        {"prim": THING, "name": "xformOp:translate", "value": {"type": "double[3]", "value": [1.0, 2.0, 3.0]}},
        {THING: "{type: Cube, translate: [0, 0, 1]}"},
    ),
    "WritePrimRelationship": Parts({"prim": THING, "name": "partner", "value": ["/World"]}, THINGS),
    "WritePrimMaterial": Parts(
        {"materialPath": "/World/Paint", "primPath": THING}, {**THINGS, "/World/Paint": "{type: Material}"}
    ),
    "WriteSetting": Parts({"settingPath": "/my/number"}),
}
_NOTHING = Parts()


def parts_of(node_type: NodeType) -> Parts:
    """What the example of a node type needs; nothing for those of other packages. A wing has a table of its own."""
    if not node_type.shipped:
        return _NOTHING
    package, folder = node_type.origin.split(".")[:2]
    table = f"{package}.{folder}.example_parts"
    parts = PARTS if package == "nodes" else import_module(table).PARTS if find_spec(table) else {}
    return parts.get(node_type.short_name, _NOTHING)
