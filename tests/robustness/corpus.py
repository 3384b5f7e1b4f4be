"""Files of every kind that TickGraph reads, small and right: what the fuzz test spoils."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

GRAPHS = {
    "/World/Graph": {
        "variables": {"gain": {"type": "double", "value": 2.0}},
        "nodes": {
            "tick": "OnPlaybackTick",
            "wait": {"type": "Countdown", "inputs": {"duration": 1, "period": 1}},
            "product": {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": "/World/Lidar"}},
            "cloud": {"type": "ROS2RtxLidarHelper", "inputs": {"topicName": "points", "type": "point_cloud"}},
            "loop": {"type": "omni.graph.action.ForLoop", "inputs": {"start": 0, "stop": 3}},
            "hear": {"type": "ROS2SubscribeTwist", "inputs": {"topicName": "cmd_vel"}},
            "list": {"type": "omni.graph.nodes.ConstructArray", "inputs": {"arraySize": 4, "arrayType": "double[]"}},
            "sum": {"type": "omni.graph.nodes.Add", "inputs": {"a": 1.5, "b": [1, 2, 3]}},
        },
        "connections": [
            "tick.tick -> wait.execIn",
            "wait.finished -> product.execIn",
            "product.execOut -> cloud.execIn",
            "product.renderProductPath -> cloud.renderProductPath",
            "tick.tick -> [loop.execIn, hear.execIn]",
        ],
    }
}
PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Box": {"type": "Cube", "size": 1.0, "translate": [2, 0, 0.5], "orient": [1, 0, 0, 0]},
    "/World/Ball": {"type": "Sphere", "radius": 0.25, "translate": [1, 0, 2], "rigid_body": True, "mass": 2.0},
    "/World/Mesh": {"type": "Mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]},
    "/World/Lidar": {"type": "OmniLidar", "config": "Example_Rotary", "translate": [0, 0, 1]},
}
DOCUMENT = {
    "tickgraph": 1,
    "scene": {"prims": PRIMS},
    "clock": {"physics_hz": 120, "loop_hz": 60, "experience": "base"},
    "duration": 0.1,
    "settings": {"/rtx/hydra/supportMultiTickRate": True},
    "fidelity": {"lidar.motion": "frozen", "lidar.subrays": 1},
    "graphs": GRAPHS,
}
TESTS = {
    "tickgraph_tests": 1,
    "cases": {
        "counts": {
            "node": "omni.graph.action.Countdown",
            "inputs": {"duration": 4, "period": 2},
            "pulses": {"execIn": [0]},
            "updates": 6,
            "expect": {"fired": {"tick": [2, 4]}},
        }
    },
}
MESSAGES = [{"at": 0, "topic": "cmd_vel", "type": "geometry_msgs/msg/Twist", "message": {"linear": {"x": 1}}}]
OGN = {
    "omni.graph.nodes.Half": {
        "version": 1,
        "description": "half of a number",
        "inputs": {"value": {"type": "double", "description": "it", "default": 2.0}},
        "outputs": {"half": {"type": "double", "description": "half of it"}},
        "tests": [{"inputs:value": 2.0, "outputs:half": 1.0}],
    }
}
PROFILE = {
    "class": "sensor",
    "type": "lidar",
    "name": "Small",
    "profile": {
        "scanType": "rotary",
        "scanRateBaseHz": 10,
        "reportRateBaseHz": 3600,
        "nearRangeM": 0.3,
        "farRangeM": 100,
        "rangeResolutionM": 0.01,
        "wavelengthNm": 905,
        "pulseTimeNs": 6,
        "maxReturns": 2,
        "numberOfEmitters": 4,
        "numberOfChannels": 4,
        "numRaysPerLine": [2, 2],
        "numLines": 2,
        "ranges": [{"min": 0.3, "max": 100}],
        "emitterStateCount": 1,
        "emitterStates": [
            {
                "azimuthDeg": [0, 1, -1, 0],
                "elevationDeg": [-15, -5, 5, 15],
                "fireTimeNs": [0, 1000, 2000, 3000],
                "channelId": [1, 2, 3, 4],
                "rangeId": [0, 0, 0, 0],
                "bank": [0, 0, 0, 0],
            }
        ],
    },
}
MJCF = """<mujoco model="m">
 <option timestep="0.005" iterations="20"/>
 <worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="arm" pos="0 0 1">
   <joint name="turn" type="hinge" axis="0 1 0" range="-90 90" damping="0.1"/>
   <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.05" mass="1"/>
  </body>
 </worldbody>
 <actuator><position name="drive" joint="turn" kp="10"/></actuator>
</mujoco>
"""
SCENE = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
    timeCodesPerSecond = 60
)

def Xform "World"
{
    def PhysicsScene "Physics" {
            float physics:gravityMagnitude = 9.81
        }
    def Mesh "Tile" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)]
        uniform token subdivisionScheme = "none"
    }
    def Cube "Box" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"])
    {
        double size = 0.5
        float physics:mass = 2
        double3 xformOp:translate = (0, 0, 2)
        quatf xformOp:orient = (1, 0, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
    }
    def Cylinder "Wheel" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"])
    {
        double radius = 0.2
        double height = 0.1
        double3 xformOp:translate = (1, 0, 1)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def PhysicsRevoluteJoint "Joint" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])
    {
        rel physics:body0 = </World/Box>
        rel physics:body1 = </World/Wheel>
        uniform token physics:axis = "Z"
        float drive:angular:physics:stiffness = 10
        float physics:lowerLimit = -90
        float physics:upperLimit = 90
    }
    def PointInstancer "Many"
    {
        rel prototypes = </World/Many/Proto>
        int[] protoIndices = [0, 0]
        point3f[] positions = [(3, 0, 0), (4, 0, 0)]
        def Sphere "Proto" {
            double radius = 0.1
        }
    }
    def BasisCurves "Wire"
    {
        int[] curveVertexCounts = [3]
        point3f[] points = [(0, 0, 1), (1, 0, 1), (1, 1, 1)]
        float[] widths = [0.1]
        uniform token type = "linear"
    }
    def Xform "Copy" (
        instanceable = true
        references = </World/Model>
    )
    {
    }
    def Xform "Model"
    {
        def Cone "Cone" {
            double radius = 0.3
        }
    }
    def OmniLidar "Lidar" (prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI"])
    {
        double3 xformOp:translate.timeSamples = { 0: (0, 0, 1), 60: (1, 0, 1) }
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def OmniGraph "Graph"
    {
        token evaluator:type = "execution"
        def OmniGraphNode "tick" {
            token node:type = "omni.graph.action.OnPlaybackTick"
        }
        def OmniGraphNode "count"
        {
            token node:type = "omni.graph.action.Counter"
            int node:typeVersion = 1
            uint inputs:execIn.connect = </World/Graph/tick.outputs:tick>
        }
        def OmniGraphNode "product"
        {
            token node:type = "isaacsim.core.nodes.IsaacCreateRenderProduct"
            uint inputs:execIn.connect = </World/Graph/tick.outputs:tick>
            rel inputs:cameraPrim = </World/Lidar>
        }
    }
}
"""


def write_corpus(folder: Path) -> Mapping[str, Path]:
    """Writes one file of each kind into a folder; gives their paths by kind."""

    texts = {
        "graph.json": json.dumps(DOCUMENT, indent=1),
        "graph.yaml": yaml_of(DOCUMENT),
        "cases.test.yaml": yaml_of(TESTS),
        "messages.yaml": yaml_of(MESSAGES),
        "OgnHalf.ogn": json.dumps(OGN, indent=1),
        "profile.json": json.dumps(PROFILE, indent=1),
        "model.xml": MJCF,
        "scene.usda": SCENE,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "half.py").write_text("")
    _export(folder / "scene.usda", folder / "scene.usdc")
    _record(folder / "run.mcap")
    return {name: folder / name for name in (*texts, "scene.usdc", "run.mcap")}


def yaml_of(document: object) -> str:
    """YAML as people write it."""
    from io import StringIO

    from ruamel.yaml import YAML

    stream = StringIO()
    YAML(typ="safe", pure=True).dump(document, stream)
    return stream.getvalue()


def _export(source: Path, target: Path) -> None:
    from graph.sim.usd import Sdf

    Sdf.Layer.FindOrOpen(str(source)).Export(str(target))


def _record(path: Path) -> None:
    from graph.recording.mcap_sink import McapSink
    from graph.sim.messages.bus import MessageBus
    from graph.sim.messages.ros_fields import from_plain

    bus, sink = MessageBus(), McapSink(path)
    bus.subscribe(sink)
    for number in range(10):
        for topic, name, fields in (
            ("/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": number}}),
            ("/joints", "sensor_msgs/msg/JointState", {"name": ["a"], "position": [number]}),
        ):
            bus.publish(topic, name, from_plain(name, fields), number * 10**7)
    bus.close()
