"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import CAMERA, CAMERA_WORLD, Parts

PARTS = {
    "GetCameraPosition": Parts({"prim": CAMERA, "usePath": False}, CAMERA_WORLD),
    "GetCameraTarget": Parts(
        {"prim": CAMERA, "usePath": False}, CAMERA_WORLD, needs="a camera that SetCameraTarget or the editor has aimed"
    ),
    "SetActiveViewportCamera": Parts({"primPath": CAMERA}, CAMERA_WORLD),
    "SetCameraPosition": Parts({"prim": CAMERA, "usePath": False, "position": [1.0, 0.0, 1.0]}, CAMERA_WORLD),
}
