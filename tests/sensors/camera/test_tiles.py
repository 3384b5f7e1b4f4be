"""Cameras that look together: to each the bytes that it gets alone, from one cast."""

import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from sensors import TiledCameraSensor
from sensors.camera.sensor import WIDTHS
from sensors.camera.tiled_sensor import Tile
from sensors.raycast.triangles import TriangleScene
from tests.support.camera_worlds import ahead
from tests.support.lidar_worlds import add_box, weightless

SIZE = (12, 16)
NAMES = sorted(WIDTHS)


def add_cameras(app, places, parent="/World"):
    paths = []
    for number, place in enumerate(places):
        camera = UsdGeom.Camera.Define(app.stage, f"{parent}/Eye{number}")
        camera.GetClippingRangeAttr().Set(Gf.Vec2f(1.2, 50.0))
        UsdGeom.XformCommonAPI(camera).SetTranslate(Gf.Vec3d(*place))
        UsdGeom.XformCommonAPI(camera).SetRotate(Gf.Vec3f(0, 9.0 * number, 0))
        paths.append(str(camera.GetPath()))
    return paths


def add_sphere(app, path, radius, place, velocity=None):
    sphere = UsdGeom.Sphere.Define(app.stage, path)
    sphere.CreateRadiusAttr(radius)
    UsdGeom.XformCommonAPI(sphere).SetTranslate(Gf.Vec3d(*place))
    if velocity is not None:
        UsdPhysics.RigidBodyAPI.Apply(sphere.GetPrim()).CreateVelocityAttr(Gf.Vec3f(*velocity))
        UsdPhysics.CollisionAPI.Apply(sphere.GetPrim())


def still(app, at=(0, 0, 0)):
    add_box(app, "/World/Near", 0.5, tuple(a + b for a, b in zip(ahead(0, 0, 1), at, strict=True)))
    add_sphere(app, "/World/Ball", 1.0, tuple(a + b for a, b in zip(ahead(1, 0, 5), at, strict=True)))
    plane = UsdGeom.Plane.Define(app.stage, "/World/Floor")
    plane.GetAxisAttr().Set("Y")
    UsdGeom.XformCommonAPI(plane).SetTranslate(Gf.Vec3d(0, -1.3, 0))
    app.stage.DefinePrim("/World/Sky", "DomeLight").GetAttribute("inputs:intensity").Set(900.0)


def few_move(app):
    still(app)
    add_box(app, "/World/Body", 1.0, ahead(-1, 0, 4), velocity=(2.0, 0, 0), spin=(30.0, 20.0, 10.0))


def many_triangles_move(app):
    still(app)
    add_sphere(app, "/World/Body", 1.0, ahead(-1, 0, 4), velocity=(2.0, 0, 0))


def far_away(app):
    still(app, (100_000.3, 0, 0))


ROW = [(0.1 * number, 0.05 * number, 0) for number in range(4)]
FAR = [(100_000.3 + x, y, z) for x, y, z in ROW]
APART = [(450.0 + 40 * number, 0, 0) for number in range(4)]
"""Some of them nearer to another point of the grid of scenes."""


def images(build, places, *, together, parent="/World", updates=3):
    """Bytes of every annotator of every camera after each update."""
    with weightless() as app:
        build(app)
        paths = add_cameras(app, places, parent)
        if together:
            sensors = TiledCameraSensor(paths, resolution=SIZE, annotators=NAMES, app=app).sensors
        else:
            sensors = [Tile(app, path, SIZE, NAMES) for path in paths]
        app.play()
        found = []
        for _ in range(updates):
            app.update()
            found.append([one.get_data(name)[0].tobytes() for one in sensors for name in NAMES])
        return found


@pytest.mark.parametrize(
    ("build", "places", "parent"),
    [
        (still, ROW, "/World"),
        (few_move, ROW, "/World"),
        (few_move, [(0, 0, 1.5 + number) for number in range(4)], "/World/Body"),
        (many_triangles_move, ROW, "/World"),
        (far_away, FAR, "/World"),
        (still, APART, "/World"),
    ],
    ids=["still", "few move", "carried", "many triangles move", "far away", "two scenes"],
)
def test_tiles_give_each_camera_the_bytes_that_it_gets_alone(build, places, parent):
    alone = images(build, places, together=False, parent=parent)
    assert images(build, places, together=True, parent=parent) == alone
    assert len(set(alone[0])) > 4


@pytest.mark.parametrize(("together", "casts"), [(True, 1), (False, 4)])
def test_the_rays_of_all_tiles_are_cast_at_once(monkeypatch, together, casts):
    counted, cast = [], TriangleScene.cast

    def count(scene, rays, threads, **options):
        counted.append(len(rays))
        return cast(scene, rays, threads, **options)

    monkeypatch.setattr(TriangleScene, "cast", count)
    with weightless() as app:
        add_box(app, "/World/Box", 1.0, ahead(0, 0, 5))
        paths = add_cameras(app, ROW)
        if together:
            kept = TiledCameraSensor(paths, resolution=SIZE, annotators="normals", app=app)
        else:
            kept = [Tile(app, path, SIZE, ["normals"]) for path in paths]
        app.play()
        app.update()
        assert counted == [4 * 12 * 16 // casts] * casts
        assert kept


def test_a_tile_whose_lens_is_changed_looks_alone():
    with weightless() as app:
        add_box(app, "/World/Box", 2.0, ahead(0, 0, 5))
        paths = add_cameras(app, [(0, 0, 0)] * 2)
        for path in paths:
            UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath(path)).SetRotate(Gf.Vec3f(0, 0, 0))
        tiled = TiledCameraSensor(paths, resolution=SIZE, annotators="distance_to_image_plane", app=app)
        app.stage.GetPrimAtPath(paths[1]).GetAttribute("focalLength").Set(5.0)
        app.play()
        app.update()
        near, wide = (one.get_data("distance_to_image_plane")[0] for one in tiled.sensors)
    assert (near < 4.1).sum() > 10 * (wide < 4.1).sum() > 0
