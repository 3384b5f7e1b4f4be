"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import ARM, ROBOT, Parts, robot

_FINGER = robot("PhysicsPrismaticJoint", "linear", 0.04)
_CUP = {
    "/World/Arm": "{type: Cube, size: 0.2, translate: [0, 0, 1], rigid_body: true, mass: 5}",
    "/World/Box": "{type: Cube, size: 0.2, translate: [0, 0, 0.795], rigid_body: true, mass: 1}",
    "/World/Arm/Point": (
        "{type: PhysicsJoint, attributes: {physics:body0: /World/Arm, physics:localPos0: [0, 0, -0.1], "
        "physics:localRot0: [0, 1, 0, 0]}}"
    ),
    "/World/Arm/Cup": "{type: IsaacSurfaceGripper, attributes: {isaac:attachmentPoints: /World/Arm/Point}}",
}

PARTS = {
    "AckermannController": Parts(
        {"wheelBase": 0.3, "trackWidth": 0.2, "frontWheelRadius": 0.05, "backWheelRadius": 0.05, "speed": 1.0}
    ),
    "HolonomicController": Parts(
        {
            "wheelRadius": [0.1],
            "wheelPositions": [[0.5, 0.0, 0.0], [-0.25, 0.433, 0.0], [-0.25, -0.433, 0.0]],
            "wheelOrientations": [[1.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.866], [-0.5, 0.0, 0.0, 0.866]],
            "mecanumAngles": [90.0],
            "inputVelocity": [1.0, 0.0, 0.0],
        }
    ),
    "HolonomicRobotUsdSetup": Parts(
        {"robotPrim": ROBOT},
        ARM,
        needs="a robot in USD whose wheel joints have isaacmecanumwheel:radius and :angle",
    ),
    "IsaacGripperController": Parts(
        {"articulationRootPrim": ROBOT, "jointNames": ["joint"], "gripperSpeed": [0.01]}, _FINGER
    ),
    "SurfaceGripper": Parts({"SurfaceGripper": "/World/Arm/Cup"}, _CUP),
}
