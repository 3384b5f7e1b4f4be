"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import LIDAR, Parts

_LIDAR = {
    LIDAR: "{type: Lidar, attributes: {rotationRate: 0}}",
    "/World/Wall": "{type: Cube, translate: [4, 0, 0]}",
}

PARTS = {
    "DebugDrawRayCast": Parts(
        {"beamOrigins": [[0.0, 0.0, 0.0]], "beamEndPoints": [[1.0, 0.0, 0.0]], "numRays": 1},
        needs="a folder for its pictures: graph run --out",
    ),
    "IsaacReadLidarBeams": Parts({"lidarPrim": LIDAR}, _LIDAR),
    "IsaacReadLidarPointCloud": Parts({"lidarPrim": LIDAR}, _LIDAR),
    "IsaacReadLightBeam": Parts(
        {"lightbeamPrim": "/World/Beam"},
        {
            "/World/Beam": "{type: IsaacLightBeamSensor, attributes: {numRays: 4, curtainLength: 1}}",
            "/World/Wall": "{type: Cube, translate: [4, 0, 0]}",
        },
    ),
}
