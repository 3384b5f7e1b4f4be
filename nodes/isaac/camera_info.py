"""The parameters of a camera's lens and film."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at
from sensors.camera.config import film_of

FISHEYE = (
    *(f"ftheta{name}" for name in ("Width", "Height", "Cx", "Cy", "MaxFov")),
    *(f"fthetaPoly{letter}" for letter in "ABCDEF"),
    *("p0", "p1", "s0", "s1", "s2", "s3"),
    *("fisheyeResolutionBudget", "fisheyeFrontFaceResolutionScale"),
)
"""The camera attributes that make cameraFisheyeParams, in order."""

FILM = "tenths of a stage unit"


@node_type(
    "isaacsim.core.nodes.IsaacReadCameraInfo",
    version=2,
    needs=(("renderProductPath",),),
    volatile=True,
    inputs={"renderProductPath": Attribute("token", "path of the render product whose camera is read", role="product")},
    outputs={
        "width": Attribute("uint", "width of the product", unit="px"),
        "height": Attribute("uint", "height of the product", unit="px"),
        "focalLength": Attribute("float", "focal length", unit=FILM),
        "horizontalAperture": Attribute("float", "width of the film", unit=FILM),
        "verticalAperture": Attribute("float", "height of the film, such that pixels are square", unit=FILM),
        "horizontalOffset": Attribute("float", "offset of the film to the right", unit=FILM),
        "verticalOffset": Attribute("float", "offset of the film upwards", unit=FILM),
        "projectionType": Attribute("token", "cameraProjectionType of the camera, else pinhole"),
        "cameraFisheyeParams": Attribute("float[]", f"{len(FISHEYE)} numbers of the lens; 0 for a pinhole"),
        "physicalDistortionModel": Attribute("token", "physicalDistortionModel of the camera"),
        "physicalDistortionCoefficients": Attribute("float[]", "physicalDistortionCoefficients of the camera"),
    },
)
def read_camera_info(db: Database) -> bool:
    """Read the Camera prim of a render product, and the product's size."""
    path = db.inputs.renderProductPath
    if not path:
        db.warn("render-product-missing", "input renderProductPath is empty; nothing is read")
        return False
    camera, (width, height) = camera_and_size(db, path)
    if not width or not height:
        db.fail(f"{path} has {width} x {height} pixels; give it a size")
    outputs, number = db.outputs, _Numbers(camera)
    outputs.width, outputs.height = width, height
    outputs.focalLength = number["focalLength"]
    outputs.horizontalAperture, outputs.verticalAperture = film_of(camera, (width, height))
    outputs.horizontalOffset = number["horizontalApertureOffset"]
    outputs.verticalOffset = number["verticalApertureOffset"]
    projection = number.get("cameraProjectionType") or "pinhole"
    outputs.projectionType = str(projection)
    outputs.cameraFisheyeParams = [0.0 if projection == "pinhole" else number[name] for name in FISHEYE]
    outputs.physicalDistortionModel = str(number.get("physicalDistortionModel") or "")
    outputs.physicalDistortionCoefficients = list(number.get("physicalDistortionCoefficients") or ())
    return True


class _Numbers:
    """A camera's attributes; an unauthored number has the schema's default, else 0."""

    def __init__(self, prim: Any) -> None:
        self._prim = prim

    def get(self, name: str) -> Any:
        attribute = self._prim.GetAttribute(name)
        return attribute.Get() if attribute else None

    def __getitem__(self, name: str) -> float:
        return float(self.get(name) or 0.0)


def camera_and_size(db: Database, path: str) -> tuple[Any, tuple[int, int]]:
    """The Camera prim and the size of a render product. Fails the node if either does not exist."""
    from graph.sim.usd import UsdGeom, UsdRender

    app = db.app
    product = app.rendering.products.get(path)
    prim = UsdRender.Product(prim_at(app.stage, path))
    if product is not None:
        camera, size = product.camera_path, product.resolution
    elif prim:
        targets, given = prim.GetCameraRel().GetTargets(), prim.GetResolutionAttr().Get()
        camera, size = (str(targets[0]) if targets else ""), (int(given[0]), int(given[1]))
    else:
        db.lack(f"there is no render product {path}; connect renderProductPath to one")
    found = app.stage.GetPrimAtPath(camera) if camera else None
    if not found or not found.IsA(UsdGeom.Camera):
        db.fail(f"{path} renders {camera or 'nothing'}, which is not a Camera prim")
    return found, size
