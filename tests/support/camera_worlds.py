"""Cameras for tests, and places as they see them: x to the right, y down, z forward [m] of a camera at the origin."""

from pxr import Gf, UsdGeom

from sensors.products import render_product
from sensors.replicator import get_annotator

SIZE = (640, 480)
FX, CENTRE = 500.0, (320.0, 240.0)
"""Of the camera that `add_camera` makes unless told otherwise: 640 x 16 / 20.48, in the middle of 640 x 480."""


def ahead(x, y, z):
    """A place in the optical frame of a camera that nobody has moved, in the world: that looks along -Z, +Y up."""
    return (x, -y, -z)


def add_camera(app, path="/World/Camera", size=SIZE, focal=16.0, aperture=20.48, near=0.01, far=1e6, **attributes):
    """A Camera prim with its render product; attributes by name, "__" for ":"."""
    camera = UsdGeom.Camera.Define(app.stage, path)
    camera.GetFocalLengthAttr().Set(focal)
    camera.GetHorizontalApertureAttr().Set(aperture)
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(near, far))
    for name, value in attributes.items():
        camera.GetPrim().GetAttribute(name.replace("__", ":")).Set(value)
    return render_product(app, path, size)


def look(app, product, *names, **options):
    """The annotators' data of the first frame, one of each name; with options where they have some."""
    found = [get_annotator(name, options, app=app).attach(product) for name in names]
    app.play()
    app.update()
    return [one.get_data() for one in found]
