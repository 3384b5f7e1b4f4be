"""A camera does not look again where nothing changed; every change is in the next picture."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, UsdShade

from graph.sim import App
from sensors.prim import write_exclude
from sensors.raycast.triangles import TriangleScene
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead
from tests.support.lidar_worlds import add_box, weightless

CHANNELS = ("rgb", "HdrColor", "distance_to_camera", "normals", "pointcloud", "semantic_segmentation", "motion_vectors")
SIZE = (48, 36)
CLOTH = """
def Mesh "Cloth" (prepend apiSchemas = ["PhysxDeformableSurfaceAPI"])
{
    point3f[] points = [(-2, -2, -6), (2, -2, -6), (2, 2, -6), (-2, 2, -6)]
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    vector3f physics:velocity = (0, 0, 2)
}
"""


@pytest.fixture
def casts(monkeypatch):
    """The name of each call that casts rays."""
    calls = []

    def counting(name):
        plain = getattr(TriangleScene, name)

        def call(*arguments, **options):
            calls.append(name)
            return plain(*arguments, **options)

        return call

    for name in ("cast", "blocked"):
        monkeypatch.setattr(TriangleScene, name, counting(name))
    return calls


def scene(app, *names):
    """A box before a wall, lit by a sun that throws shadows; the annotators of the camera."""
    box = add_box(app, "/World/Box", 1.0, ahead(0, 0, 5))
    wall = add_box(app, "/World/Wall", 20.0, ahead(0, 0, 18))
    for prim in (box, wall):
        UsdGeom.Gprim(prim).CreateDisplayColorAttr([(0.4, 0.3, 0.2)])
    box.AddAppliedSchema("SemanticsLabelsAPI:class")
    box.GetAttribute("semantics:labels:class").Set(["box"])
    sun = UsdLux.DistantLight.Define(app.stage, "/World/Sun")
    sun.CreateIntensityAttr(3000.0)
    UsdGeom.XformCommonAPI(sun).SetRotate(Gf.Vec3f(30, -35, 0))
    product = add_camera(app, size=SIZE, focal=16.0)
    return [get_annotator(name, app=app).attach(product) for name in names]


def shots(app, annotators):
    """The bytes of each annotator after the next update."""
    app.update()
    found = [one.get_data() for one in annotators]
    return [(one["data"] if isinstance(one, dict) else one).tobytes() for one in found]


@pytest.mark.parametrize("rolling", [False, True])
def test_a_standing_camera_casts_no_more_once_it_has_seen_all(casts, rolling):
    with weightless(physics_hz=60, loop_hz=60) as app:
        annotators = scene(app, *CHANNELS)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        if rolling:
            prim.AddAppliedSchema("OmniRtxRollingShutterAPI")
            prim.GetAttribute("omni:rtx:rollingShutter:scanOrder").Set("topToBottom")
        app.play()
        shots(app, annotators)
        first = shots(app, annotators)  # motion vectors need the frame before
        casts.clear()
        assert [shots(app, annotators) for _ in range(4)] == [first] * 4
        assert casts == []


def test_noise_of_a_standing_camera_differs_from_frame_to_frame_without_a_cast(casts):
    with weightless(physics_hz=60, loop_hz=60, camera_noise=True) as app:
        annotators = scene(app, "rgb")
        app.play()
        shots(app, annotators)
        casts.clear()
        assert len({shots(app, annotators)[0] for _ in range(3)}) == 3
        assert casts == []


def _dim(app):
    app.stage.GetPrimAtPath("/World/Sun").GetAttribute("inputs:intensity").Set(500.0)


def _turn(app):
    UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Sun")).SetRotate(Gf.Vec3f(0, 0, 0))


def _hide(app):
    UsdGeom.Imageable(app.stage.GetPrimAtPath("/World/Sun")).MakeInvisible()


def _paint(app):
    UsdGeom.Gprim(app.stage.GetPrimAtPath("/World/Box")).GetDisplayColorAttr().Set([(0.9, 0.1, 0.1)])


def _cover(app):
    shader = UsdShade.Shader.Define(app.stage, "/World/Looks/Red/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((1.0, 0.0, 0.0))
    material = UsdShade.Material.Define(app.stage, "/World/Looks/Red")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(app.stage.GetPrimAtPath("/World/Wall")).Bind(material)


def _step_aside(app):
    UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Camera")).SetTranslate(Gf.Vec3d(0.5, 0, 0))


def _push(app):
    UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Box")).SetTranslate(Gf.Vec3d(*ahead(1, 0, 5)))


def _tone(app):
    app.settings.set("/tickgraph/cameraTone", "aces")


def _stop_down(app):
    app.stage.GetPrimAtPath("/World/Camera").GetAttribute("exposure").Set(-2.0)


@pytest.mark.parametrize("change", [_dim, _turn, _hide, _paint, _cover, _step_aside, _push, _tone, _stop_down])
def test_a_change_of_the_scene_is_in_the_next_picture_and_stays(change):
    with weightless(physics_hz=60, loop_hz=60) as app:
        annotators = scene(app, "rgb")
        app.play()
        before = [shots(app, annotators) for _ in range(3)]
        change(app)
        after = [shots(app, annotators) for _ in range(3)]
        assert before == before[:1] * 3
        assert after == after[:1] * 3
        assert after[0] != before[0]


def _fly(app, path, place):
    """A body of 1 m/s and 90 deg/s at a place of the optical frame, and a prim at its origin."""
    body = add_box(app, path, 0.1, ahead(*place), velocity=(1, 0, 0), spin=(0, 90, 0))
    return f"{body.GetPath()}/Rider"


def _sun_rides(app):
    light = UsdLux.SphereLight.Define(app.stage, _fly(app, "/World/Body", (0, -2, 3)))
    light.CreateIntensityAttr(1e5)
    UsdGeom.XformCommonAPI(light).SetTranslate(Gf.Vec3d(0, 1, 0))
    return "/World/Camera"


def _camera_rides(app):
    path = _fly(app, "/World/Body", (0, 0, -1))
    add_camera(app, path, size=SIZE)
    write_exclude(app.stage.GetPrimAtPath(path), ("/World/Body",))
    return path


def _body_flies(app):
    _fly(app, "/World/Body", (0, 0, 3))
    return "/World/Camera"


@pytest.mark.parametrize("rides", [_sun_rides, _camera_rides, _body_flies])
def test_what_rides_on_a_moving_body_gives_another_picture_each_time(rides):
    with weightless(physics_hz=60, loop_hz=60) as app:
        scene(app)
        path = rides(app)
        [product] = [one for one in app.rendering.products.values() if one.camera_path == path]
        rgb = get_annotator("rgb", app=app).attach(product)
        app.play()
        assert len({shots(app, [rgb])[0] for _ in range(4)}) == 4


def test_cloth_that_flies_gives_another_picture_each_time():
    with App(None, physics_hz=60, loop_hz=60) as app:
        app.stage.GetRootLayer().ImportFromString(f'#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = "Y"\n)\n{CLOTH}')
        UsdLux.DistantLight.Define(app.stage, "/World/Sun").CreateIntensityAttr(3000.0)
        depth = get_annotator("distance_to_camera", app=app).attach(add_camera(app, size=SIZE))
        app.play()
        assert len({shots(app, [depth])[0] for _ in range(4)}) == 4


def test_what_is_kept_is_not_for_frames_to_write_on_and_what_get_data_gives_is():
    with weightless(physics_hz=60, loop_hz=60) as app:
        [rgb] = scene(app, "rgb")
        app.play()
        app.update(steps=2)
        mine, plain = rgb.get_data(), None
        plain = mine.copy()
        mine[...] = 0
        app.update()
        np.testing.assert_array_equal(rgb.get_data(), plain)
        with pytest.raises(ValueError, match="read-only"):
            rgb.product.frame.channel("rgb")[...] = 0
