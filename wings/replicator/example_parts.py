"""What the examples of this wing's node types need besides defaults."""

from nodes.catalog.example_parts import CAMERA, CAMERA_WORLD, THING, THINGS, Parts

_PIPELINE = "SdOnNewFrame and SdOnNewRenderProductFrame before it"

PARTS = {
    "IsaacConvertDepthToPointCloud": Parts(needs="an image of distances at dataPtr and the lens of its camera"),
    "IsaacConvertRGBAToRGB": Parts(needs="an RGBA image at dataPtr"),
    "SdFrameIdentifier": Parts(needs=_PIPELINE),
    "SdOnNewRenderProductFrame": Parts(prims=CAMERA_WORLD, product=True, sensor=CAMERA),
    "SdRenderVarPtr": Parts(needs=_PIPELINE),
    "SdRenderVarToRawArray": Parts(needs=_PIPELINE),
    "OgnGetPrimAtPath": Parts({"paths": [THING]}, THINGS),
}
