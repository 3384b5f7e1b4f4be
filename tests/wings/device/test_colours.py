"""Colours that a device shades: the picture that the processor makes, but for what its float32 rounds."""

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")

from pxr import Sdf

from graph.sim import App
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera
from tests.support.devices import on_each
from wings.device.camera import DeviceCamera

SIZE = (64, 48)
PRIMS = {
    "/Floor": {"type": "Cube", "size": 1.0, "scale": [14, 14, 1], "translate": [0, 0, -7], "color": [0.6, 0.5, 0.4]},
    "/Ball": {"type": "Sphere", "radius": 0.5, "translate": [-1, 0, -4], "rigid_body": True, "velocity": [1, 0.2, 0]},
    "/Post": {"type": "Cube", "size": 1.0, "scale": [0.3, 0.3, 2], "translate": [1, 0.3, -5], "color": [0.1, 0.3, 0.8]},
    "/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}},
}
ABOVE = {"translate": [0.5, 1.5, -2]}
LIGHTS = {
    "a sun": {"type": "DistantLight", "rotate": [25, -30, 0], "attributes": {"inputs:intensity": 900}},
    "the sky": {"type": "DomeLight", "attributes": {"inputs:intensity": 300, "inputs:color": [0.5, 0.7, 1]}},
    "a lamp": {"type": "SphereLight", **ABOVE, "attributes": {"inputs:intensity": 3e4, "inputs:radius": 0.2}},
    "a window": {"type": "RectLight", **ABOVE, "attributes": {"inputs:intensity": 2e3, "inputs:width": 2.0}},
    "a disk": {"type": "DiskLight", **ABOVE, "attributes": {"inputs:intensity": 2e3}},
    "a tube": {"type": "CylinderLight", **ABOVE, "attributes": {"inputs:intensity": 4e3, "inputs:radius": 0.1}},
    "a spot": {
        "type": "SphereLight",
        **ABOVE,
        "schemas": ["ShapingAPI"],
        "attributes": {
            "inputs:intensity": 3e4,
            "inputs:shaping:cone:angle": 30.0,
            "inputs:shaping:cone:softness": 0.5,
            "inputs:shaping:focus": 2.0,
        },
    },
    "a headlight": {"type": "DomeLight", "attributes": {"inputs:intensity": 100}},
    "no shadows": {"type": "DistantLight", "attributes": {"inputs:intensity": 900, "inputs:shadow:enable": False}},
}


def frames_on(device, lights, *names, updates=5, near=0.01, options=None):
    """The data of the annotators after each update, the floor's light in all of them; what the device shaded."""
    shaded = []
    plain = DeviceCamera.shade
    with pytest.MonkeyPatch.context() as patch, App(physics_hz=60, loop_hz=60, device=device, **(options or {})) as app:
        patch.setattr(DeviceCamera, "shade", lambda *given, **how: shaded.append(plain(*given, **how)) or shaded[-1])
        app.add_prims({**PRIMS, **{f"/Light{number}": light for number, light in enumerate(lights)}})
        for number in (n for n, light in enumerate(lights) if light is LIGHTS["a headlight"]):
            prim = app.stage.GetPrimAtPath(f"/Light{number}")
            prim.CreateAttribute("mjc:headlight", Sdf.ValueTypeNames.Float3).Set((500, 400, 300))
        product = add_camera(app, "/Camera", size=SIZE, near=near, far=20.0)
        readers = [get_annotator(name, app=app).attach(product) for name in names]
        app.play()
        found = []
        for _ in range(updates):
            app.update()
            found.append([np.array(one.get_data()) for one in readers])
    return found, shaded


@on_each
@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_each_light_shines_as_on_the_processor(device, light):
    """Linear light, after the first picture, a recorded one and its replays; edges of shadows may fall otherwise."""
    ours, shaded = frames_on(device, [light], "HdrColor")
    theirs, _ = frames_on("cpu", [light], "HdrColor")
    assert [one is not None for one in shaded] == [True] * len(ours)
    for (mine,), (other,) in zip(ours, theirs, strict=True):
        apart = np.abs(mine.astype(float) - other) > 2e-3 * np.abs(other) + 1e-4 * other.max()
        assert other.max() > 1
        assert apart.mean() < 2e-3


@on_each
@pytest.mark.parametrize("tone", ["linear", "aces"])
def test_a_picture_of_all_lights_has_the_processors_bytes(device, tone):
    settings = {"settings": {"/tickgraph/cameraTone": "aces"}} if tone == "aces" else {}
    (ours, shaded), (theirs, _) = (frames_on(one, LIGHTS.values(), "rgb", options=settings) for one in (device, "cpu"))
    assert all(one.dtype == np.uint8 for one in shaded)
    for (mine,), (other,) in zip(ours, theirs, strict=True):
        apart = np.abs(mine.astype(int) - other)
        assert (apart > 1).mean() < 2e-3
        assert 20 < other[..., :3].mean() < 235


@on_each
def test_what_is_nearer_than_the_near_distance_is_looked_through(device):
    """The ball is before the near plane: the device leaves the picture to the rays that begin behind it."""
    ours, shaded = frames_on(device, [LIGHTS["the sky"]], "rgb", "distance_to_camera", near=4.6)
    theirs, _ = frames_on("cpu", [LIGHTS["the sky"]], "rgb", "distance_to_camera", near=4.6)
    assert shaded == [None] * len(ours)
    for mine, other in zip(ours, theirs, strict=True):
        assert (np.abs(mine[0].astype(int) - other[0]) > 1).mean() < 2e-3
        assert (np.abs(mine[1] - other[1]) < 1e-5)[np.isfinite(other[1])].mean() > 0.99


@on_each
def test_pictures_on_a_device_repeat_to_the_byte(device):
    one, other = (frames_on(device, LIGHTS.values(), "rgb")[0] for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one[0], one[-1])


@on_each
def test_noise_is_added_to_the_light_that_the_device_shaded(device):
    noisy = {"fidelity": {"camera.noise": "on"}}
    ours, shaded = frames_on(device, [LIGHTS["a sun"]], "rgb", options=noisy)
    theirs, _ = frames_on("cpu", [LIGHTS["a sun"]], "rgb", options=noisy)
    assert all(one.dtype == np.float32 for one in shaded)
    for (mine,), (other,) in zip(ours, theirs, strict=True):
        assert (np.abs(mine.astype(int) - other) > 1).mean() < 2e-3
