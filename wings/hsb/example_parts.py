"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import CAMERA, CAMERA_WORLD, Parts

PARTS = {
    "HSBCameraHelper": Parts(prims=CAMERA_WORLD, product=True, sensor=CAMERA),
}
