"""What a camera costs: whole App updates against the bare casts of the same rays at the same scenes.

The scene is that of the lidar's table, 50,000 static triangles and 20 turning boxes; the camera turns with one of them,
so that no cast can be kept. The baseline casts its rays at all that stands still and at all that moves.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from bench_lidar import boxes
from measure import Row, added, ratio, seconds
from pxr import Gf, UsdGeom, UsdLux

from graph.sim import App
from graph.sim.geometry.surfaces import Mesh
from graph.sim.libraries import import_open3d
from graph.sim.settings import CAMERA_TONE, TONE_ACES
from sensors import CameraSensor, RtxCamera, SingleViewDepthCameraSensor, TiledCameraSensor, render_product
from sensors.camera.rays import CameraRays
from sensors.prim import write_exclude

TITLE = "Camera: 640 x 480; 50,000 static triangles with 20 turning boxes, the camera on one of them"
MOUNT = "/World/Box0"
SIZE = (640, 480)
TILES, TILE = 64, (64, 64)
SEGMENTED = ("instance_id_segmentation", "instance_segmentation", "semantic_segmentation")


def measure(quick: bool) -> Iterator[Row]:
    """The ratios that the manual quotes."""
    rounds = 1 if quick else 25
    for what, channels, bound in (
        ("depth", ("distance_to_image_plane",), 1.25),
        ("depth, normals, one segmentation", ("distance_to_image_plane", "normals", SEGMENTED[2]), 1.6),
        ("colours, one sun with shadows", ("rgb",), 3.5),
        (
            "depth, normals, three segmentations, motion",
            ("distance_to_camera", "normals", *SEGMENTED, "motion_vectors"),
            None,
        ),
    ):
        yield Row(f"{what}, against its casts", update_ratio(frozenset(channels), rounds), bound)
    yield Row("a camera, sun and scene that stand: colours, against depth", standing_ratio(rounds), 1.3)
    count = 2 if quick else 16
    yield Row(
        f"{count} depth cameras at 10 Hz in a 240 Hz loop, against every update", rate_ratio(count, rounds), 1 / 20
    )
    yield Row("64 tiled depth cameras of 64 x 64, against one cast of their rays", tiled_ratio(rounds), 1.5)
    for what, value in added_to_colours(rounds):
        yield Row(f"what {what} adds to colours, in casts", value)
    yield Row("what stereo depth adds to depth, in casts", added_by_stereo(rounds))
    yield Row("a camera that is not due, each update", idle_cost(rounds) * 1e6, 5.0, "us")
    yield Row("get_data of 448 x 448 colours in every update of a 10 Hz camera", polled_cost(rounds) * 1e6, 20.0, "us")


def scene(loop_hz: int = 240, fidelity: dict[str, Any] | None = None) -> App:
    """The scene of the lidar's table with a sun."""
    app = boxes(loop_hz, fidelity)
    UsdLux.DistantLight.Define(app.stage, "/World/Sun").CreateIntensityAttr(3000.0)
    UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Sun")).SetRotate(Gf.Vec3f(30, -35, 0))
    return app


def add_camera(app: App, number: int = 0, rate: float = 0.0, mount: str = MOUNT, size: tuple[int, int] = SIZE) -> Any:
    """A camera of 60 deg on a box, which it does not see, looking outwards; and its render product."""
    camera = UsdGeom.Camera.Define(app.stage, f"{mount}/BenchmarkCamera{number}")
    camera.GetFocalLengthAttr().Set(18.147562)
    camera.GetClippingRangeAttr().Set(Gf.Vec2f(0.01, 1e4))
    prim = camera.GetPrim()
    UsdGeom.XformCommonAPI(prim).SetRotate(Gf.Vec3f(80, 0, 13 * number))
    prim.AddAppliedSchema("OmniSensorAPI")
    prim.GetAttribute("omni:sensor:tickRate").Set(rate)
    write_exclude(prim, (mount,))
    return render_product(app, str(prim.GetPath()), size)


def update_ratio(channels: frozenset[str], rounds: int) -> float:
    """Time of App updates of one physics step with an image each, over that of the casts in them."""
    app = scene()
    product = add_camera(app)
    product.sensor.require("benchmark", channels)
    app.play()
    app.update(steps=5)
    found = ratio(app.update, bare_casts(app, product), 3 * rounds)
    app.close()
    return found


def added_to_colours(rounds: int) -> Iterator[tuple[str, float]]:
    """What a sky, noise and tone cost: longer times of updates with an image each, over the bare casts."""
    plain, unit = _images(scene(), "rgb")
    sky = scene()
    UsdLux.DomeLight.Define(sky.stage, "/World/Sky").CreateIntensityAttr(500.0)
    bent = scene()
    bent.settings.set(CAMERA_TONE, TONE_ACES)
    for what, app in (("a sky", sky), ("camera.noise", scene(fidelity={"camera.noise": True})), ("ACES", bent)):
        yield what, added(_images(app, "rgb")[0].update, plain.update, unit, rounds)
        app.close()
    plain.close()


def _images(app: App, channel: str) -> tuple[App, Callable[[], None]]:
    """The App, playing, with a camera whose images of this kind are read; and its bare casts."""
    product = add_camera(app)
    product.sensor.require("benchmark", {channel})
    app.play()
    app.update(steps=5)
    return app, bare_casts(app, product)


def added_by_stereo(rounds: int) -> float:
    """The same of the depth that two imagers would give, against depth."""
    plain, unit = _images(scene(), "distance_to_image_plane")
    app = scene()
    sensor = SingleViewDepthCameraSensor(
        add_camera(app).camera_path, resolution=SIZE[::-1], annotators="depth_sensor_distance", app=app
    )
    app.play()
    app.update(steps=5)

    def read() -> None:
        app.update()
        sensor.get_data("depth_sensor_distance")

    found = added(read, plain.update, unit, rounds)
    app.close()
    plain.close()
    return found


def bare_casts(app: App, *products: Any) -> Callable[[], None]:
    """Casts the rays of cameras at all that stands still, and at all that moves; one camera does not see its mount."""
    open3d = import_open3d()
    static, moving = open3d.t.geometry.RaycastingScene(), open3d.t.geometry.RaycastingScene()
    for surface in app.geometry():
        assert isinstance(surface, Mesh)
        vertices = surface.vertices
        if surface.body is not None:
            pose = app.fabric.rigid_matrices([surface.body])[0]
            vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
        if surface.path != MOUNT or len(products) > 1:
            scene = static if surface.body is None else moving
            scene.add_triangles(vertices.astype(np.float32), surface.triangles)
    tables = []
    for product in products:
        pose = product.sensor.pose()
        bundle = CameraRays(product.sensor.config.lens).bundle(pose, frozenset(), grid=False)
        bundle.start_at(pose[:3, 3].astype(np.float32))
        tables.append(bundle.table)
    tensor = open3d.core.Tensor.from_numpy(np.concatenate(tables))

    def cast() -> None:
        static.cast_rays(tensor)
        moving.cast_rays(tensor)

    return cast


def standing_ratio(rounds: int) -> float:
    """Time of App updates with a colour image each, over those with a depth image, where nothing moves."""
    apps = []
    for channel in ("rgb", "distance_to_image_plane"):
        app = App(None, physics_hz=240, loop_hz=240)
        UsdGeom.Cube.Define(app.stage, "/World/Box").CreateSizeAttr(2.0)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Box")).SetTranslate(Gf.Vec3d(0, 0, -6))
        UsdLux.DistantLight.Define(app.stage, "/World/Sun").CreateIntensityAttr(3000.0)
        UsdGeom.Camera.Define(app.stage, "/World/Camera")
        render_product(app, "/World/Camera", SIZE).sensor.require("benchmark", {channel})
        app.play()
        app.update(steps=5)
        apps.append(app)
    colours, depth = apps
    found = ratio(colours.update, depth.update, 3 * rounds)
    for app in apps:
        app.close()
    return found


def rate_ratio(count: int, rounds: int) -> float:
    """Time of updates of so many cameras at 10 Hz in a 240 Hz loop, over that of the same at every update."""
    apps = []
    for rate in (10.0, 0.0):
        app = scene()
        for number in range(count):
            add_camera(app, number, rate, f"/World/Box{number}").sensor.require(
                "benchmark", {"distance_to_image_plane"}
            )
        app.play()
        app.update(steps=24)
        apps.append(app)
    slow, every = apps
    found = ratio(lambda: slow.update(steps=24), lambda: every.update(steps=24), max(1, rounds // 5), warm_up=1)
    for app in apps:
        app.close()
    return found


def tiled_ratio(rounds: int) -> float:
    """Time of App updates of one physics step with the images of 64 cameras, over that of casts of all their rays."""
    app = scene()
    paths = []
    for number in range(TILES):
        camera = UsdGeom.Camera.Define(app.stage, f"/World/Box{number % 20}/Tile{number // 20}")
        camera.GetFocalLengthAttr().Set(18.147562)
        camera.GetClippingRangeAttr().Set(Gf.Vec2f(0.01, 1e4))
        place = UsdGeom.XformCommonAPI(camera)
        place.SetTranslate(Gf.Vec3d(0, 0, 1.5))
        place.SetRotate(Gf.Vec3f(80, 0, 90 * (number // 20)))
        paths.append(str(camera.GetPath()))
    sensor = TiledCameraSensor(paths, resolution=TILE, annotators="distance_to_image_plane", app=app)
    app.play()
    app.update(steps=5)

    def subject() -> None:
        app.update()
        sensor.get_data("distance_to_image_plane")

    found = ratio(subject, bare_casts(app, *(one.render_product for one in sensor.sensors)), 2 * rounds)
    app.close()
    return found


def polled_cost(rounds: int) -> float:
    """Seconds of a `get_data` in each of the updates at 60 Hz, those with a new frame included."""
    with App(None, physics_hz=60, loop_hz=60) as app:
        RtxCamera("/World/Camera", tick_rate=10, app=app)
        sensor = CameraSensor("/World/Camera", resolution=(448, 448), annotators="rgb", app=app)
        app.play()
        app.update(steps=12)
        costs = []
        for _ in range(6 * rounds):
            app.update()
            costs.append(seconds(lambda: sensor.get_data("rgb")))
    return statistics.median(costs)


def idle_cost(rounds: int) -> float:
    """Seconds that a camera of 0.5 Hz adds to an update in which it is not due."""
    with_camera, without = scene(), scene()
    add_camera(with_camera, rate=0.5).sensor.require("benchmark", {"distance_to_image_plane"})
    costs = []
    for app in (with_camera, without):
        app.play()
        app.update(steps=10)
    for _ in range(max(3, rounds // 5)):
        pairs = [(seconds(with_camera.update), seconds(without.update)) for _ in range(100)]
        costs.append(statistics.median(a for a, _ in pairs) - statistics.median(b for _, b in pairs))
    for app in (with_camera, without):
        app.close()
    return max(0.0, statistics.median(costs))
