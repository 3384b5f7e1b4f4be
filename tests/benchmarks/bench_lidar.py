"""What a lidar costs: whole App updates against the bare casts and the bare physics steps they contain.

The baseline casts the same rays against the same, already built static and moving scenes and does the same `mj_step`s;
everything the App, the scheduler, the sensor and its channels do on top is what the ratio shows.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from measure import Row, ratio, seconds
from pxr import Gf, Sdf, UsdGeom, UsdPhysics, Vt

from graph.sim import App
from graph.sim.geometry import tessellation
from graph.sim.geometry.closed_forms import closed_form
from graph.sim.geometry.surfaces import Mesh, Plane, Solid
from graph.sim.libraries import import_open3d
from graph.sim.physics.mujoco.engine import MujocoEngine
from sensors import LidarConfig, render_product
from sensors.channels import AuxLevel
from sensors.gmo import channels_for
from sensors.lidar.config import EmitterState
from sensors.lidar.pattern import firing_pattern
from sensors.lidar.prim import write_config
from sensors.prim import read_exclude, write_aux_level, write_exclude
from sensors.raycast.rays import RayBundle
from sensors.raycast.standing import excluded
from sensors.raycast.windows import RayGrid
from sensors.raycast.world import CastWorld
from sensors.sensor_types import sensor_types

Triangles = tuple[np.ndarray, np.ndarray]
TITLE = "Lidar: 32 x 1800 rays; graphs/scenes/yard.usda, and 50,000 static triangles with 20 moving boxes"
ROBOT = "/World/Robot/Chassis"
YARD = Path(__file__).parents[2] / "graphs" / "scenes" / "yard.usda"
EVERYTHING_ON = {"/app/sensors/nv/lidar/publishNormals": True, "/rtx-transient/stableIds/enabled": True}


def grid_faces(side: int) -> np.ndarray:
    """The triangles (2 (side - 1)^2, 3) of a square grid of side x side points."""
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    both = [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    return np.concatenate(both).astype(np.uint32)


def rough_ground(side: int) -> Mesh:
    """200 m x 200 m of hills."""
    axis = np.linspace(-100, 100, side)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    height = 1.5 * np.sin(x / 4) * np.cos(y / 5) - 2.0
    return Mesh("/World/Ground", None, np.stack([x, y, height], axis=-1).reshape(-1, 3), grid_faces(side))


GROUND = rough_ground(159)
"""50,000 triangles."""


def measure(quick: bool) -> Iterator[Row]:
    """The ratios that the manual quotes."""
    rounds = 1 if quick else 25
    cloud = frozenset({"xyz"})
    everything = sensor_types()["OmniLidar"].measures
    basic = channels_for(AuxLevel.BASIC, "SPHERICAL") & everything
    for scene, make in (("yard, robot turns", yard), ("boxes", boxes)):
        for what, channels, bound in (
            ("point cloud only", cloud, 1.25),
            ("all BASIC channels", basic, 1.5),
            ("everything", everything, 2.0),
        ):
            found = update_ratio(make, channels, rounds)
            yield Row(f"{scene}: one second, one lidar at 10 Hz, {what}", found, bound)
    for scene, make in (
        ("yard, robot turns", yard),
        ("yard, robot stands", standing_yard),
        ("boxes", boxes),
    ):
        crowd = update_ratio(make, cloud, rounds, 16, 240)
        yield Row(f"{scene}: one second at a 240 Hz loop, 16 lidars at 10 Hz", crowd, 1.25)
    for mount in ("/World", "/World/Box0"):
        found = continuous_ratio(mount, rounds)
        yield Row(f"boxes: lidar.motion continuous against frozen, 20 bodies turn, lidar on {mount}", found, 3.0)
    for what, count, mesh, bound in (
        ("1,000 moving boxes", 1000, box(), 5.0),
        ("100 moving meshes of 5,000 triangles", 100, ball(50), 3.0),
    ):
        yield Row(
            f"{what} and 50,000 static triangles, against the static cast", crowd_ratio(count, mesh, rounds), bound
        )
    for count in (20, 100, 1000):
        found = solids_ratio(count, rounds)
        yield Row(f"{count:,} moving boxes and spheres, against the cast of their triangles, standing", found, 2.0)
    yield Row("boxes: a frozen lidar that is not due, each update", idle_cost(rounds) * 1e6, 5.0, "us")


def update_ratio(
    make: Callable[[int], App], channels: frozenset[str], rounds: int, lidars: int = 1, loop_hz: int = 60
) -> float:
    """Time of App updates over that of the casts and steps in them."""
    app = make(loop_hz)
    mount = "/World" if make is boxes else ROBOT
    products = [add_lidar(app, number, channels, mount) for number in range(lidars)]
    app.play()
    app.update(steps=loop_hz // 10)
    casts, physics = bare_casts(app, products), bare_steps(app)
    turns = 2 if lidars > 1 else 10

    def baseline() -> None:
        for _ in range(turns):
            physics(24)
            for cast in casts:
                cast()

    found = ratio(lambda: app.update(steps=turns * loop_hz // 10), baseline, rounds)
    app.close()
    return found


def continuous_ratio(mount: str, rounds: int) -> float:
    """Time of App updates with `lidar.motion` continuous over that with frozen."""
    apps = [boxes(60, {"lidar.motion": motion}) for motion in ("continuous", "frozen")]
    for app in apps:
        add_lidar(app, 0, frozenset({"xyz"}), mount)
        app.play()
        app.update(steps=12)
    continuous, frozen = apps
    found = ratio(lambda: continuous.update(steps=60), lambda: frozen.update(steps=60), rounds)
    for app in apps:
        app.close()
    return found


def crowd_ratio(count: int, shape: Triangles, rounds: int) -> float:
    """Time of a cast at the ground and at `count` bodies that have moved, over that of the ground alone."""
    generator = np.random.default_rng(1)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :2, 3] = generator.uniform(-60, 60, (count, 2))
    poses[:, 2, 3] = generator.uniform(0, 3, count)
    bodies = [Mesh(f"/World/B{i}", f"/World/B{i}", *shape) for i in range(count)]
    still, crowd = CastWorld([GROUND]), CastWorld([GROUND, *bodies], lambda _: poses)
    pattern = firing_pattern(full_config(Fraction(10)))
    table = np.zeros((len(pattern), 6), np.float32)
    table[:, 3:6] = pattern.directions
    grid = RayGrid(pattern.directions)

    def cast(world: CastWorld) -> None:
        poses[:, 0, 3] += 1e-3
        world.cast(RayBundle(np.array([0.0, 0.0, 1.5]), table, grid=grid))

    return ratio(lambda: cast(crowd), lambda: cast(still), 2 * rounds)


def solids_ratio(count: int, rounds: int) -> float:
    """Time of a cast at boxes and spheres that have moved, over that at their triangles in one static scene."""
    generator = np.random.default_rng(2)
    side = math.ceil(math.sqrt(1.3 * count))
    step = 60.0 / side if count > 30 else 6.0  # on a grid, as bodies that do not touch
    cells = generator.permutation([(i, j) for i in range(side) for j in range(side)])[:count]
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :2, 3] = (cells - (side - 1) / 2) * step + 0.9
    ground = Plane("/World/Ground", None, np.array([0.0, 0.0, -0.45]), np.array([0.0, 0.0, 1.0]))
    kinds = [("Cube", {"size": 0.9}), ("Sphere", {"radius": 0.45})]
    parts = tessellation.sphere_parts(0.45, 1e-3)
    makers = [partial(tessellation.cube, 0.9), partial(tessellation.sphere, 0.45, parts)]
    shapes = [make() for make in makers]
    forms = [closed_form(kind, sizes, "Z") for kind, sizes in kinds]
    moving: list[Mesh | Plane] = [ground]
    standing: list[Mesh | Plane] = [ground]
    for number, pose in enumerate(poses):
        path, form, shape = f"/World/B{number}", forms[number % 2], shapes[number % 2]
        assert form is not None
        moving.append(Solid(path, path, form, makers[number % 2]))
        standing.append(Mesh(path, None, shape[0] + pose[:3, 3], shape[1]))
    table = np.zeros((64_000, 6), np.float32)
    table[:, 3:6] = firing_pattern(full_config(Fraction(10), 2000)).directions
    grid = RayGrid(table[:, 3:6].copy())
    crowd, still = CastWorld(moving, lambda _: poses), CastWorld(standing)

    def cast(world: CastWorld) -> None:
        poses[:, 0, 3] += 1e-4
        world.cast(RayBundle(np.array([0.0, 0.0, 1.05]), table, grid=grid))

    return ratio(lambda: cast(crowd), lambda: cast(still), 2 * rounds)


def box() -> Triangles:
    """A cube of 1 m: vertices (8, 3), triangles (12, 3)."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])], np.uint32)


def ball(rings: int) -> Triangles:
    """A sphere of 1 m: 2 rings^2 triangles."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, rings + 1), indexing="ij")
    points = 0.5 * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return points.reshape(-1, 3), grid_faces(rings + 1)


def idle_cost(rounds: int) -> float:
    """Seconds that a lidar of 0.5 Hz adds to an update in which it is not due."""
    with_lidar, without = boxes(60), boxes(60)
    add_lidar(with_lidar, 0, frozenset({"xyz"}), rate=Fraction(1, 2))
    costs = []
    for app in (with_lidar, without):
        app.play()
        app.update(steps=10)
    for _ in range(max(3, rounds // 5)):
        pairs = [(seconds(with_lidar.update), seconds(without.update)) for _ in range(100)]
        costs.append(statistics.median(a for a, _ in pairs) - statistics.median(b for _, b in pairs))
        for app in (with_lidar, without):
            app.update(steps=20)
            app.stop()
            app.play()
            app.update(steps=10)
    for app in (with_lidar, without):
        app.close()
    return max(0.0, statistics.median(costs))


def yard(loop_hz: int) -> App:
    """The yard of the main example, physics at 240 Hz; the robot turns on the spot, and no cast is like the last."""
    app = standing_yard(loop_hz)
    for side, speed in (("left", -60.0), ("right", 60.0)):
        joint = app.stage.GetPrimAtPath(f"/World/Robot/Joints/{side}_wheel")
        joint.GetAttribute("drive:angular:physics:targetVelocity").Set(speed)
    return app


def standing_yard(loop_hz: int) -> App:
    """The same, with the robot at rest."""
    return App(str(YARD), physics_hz=240, loop_hz=loop_hz, settings=EVERYTHING_ON)


def boxes(loop_hz: int, fidelity: dict[str, Any] | None = None) -> App:
    """Rough ground of 50,000 triangles, 20 boxes that slide without friction on a smooth floor, physics at 240 Hz."""
    app = App(None, physics_hz=240, loop_hz=loop_hz, settings=EVERYTHING_ON, fidelity=fidelity)
    stage = app.stage
    mesh = UsdGeom.Mesh.Define(stage, GROUND.path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(GROUND.vertices.astype(np.float32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(GROUND.triangles.reshape(-1).astype(np.int32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(GROUND.triangles), 3))
    for number in range(20):
        box = UsdGeom.Cube.Define(stage, f"/World/Box{number}")
        box.CreateSizeAttr(1.0)
        angle = number * 2 * np.pi / 20
        UsdGeom.XformCommonAPI(box).SetTranslate(Gf.Vec3d(10 * np.cos(angle), 10 * np.sin(angle), 1.0))
        UsdPhysics.CollisionAPI.Apply(box.GetPrim())
        body = UsdPhysics.RigidBodyAPI.Apply(box.GetPrim())
        body.CreateAngularVelocityAttr(Gf.Vec3f(0, 0, 90))
    UsdPhysics.Scene.Define(stage, "/World/Physics").CreateGravityMagnitudeAttr(1e-9)
    return app


def add_lidar(
    app: App, number: int, channels: frozenset[str], mount: str = "/World", rate: Fraction = Fraction(10)
) -> Any:
    """A lidar of 32 emitters and 1800 ticks a turn, and its render product; on the robot it does not see the robot."""
    prim = app.stage.DefinePrim(Sdf.Path(f"{mount}/BenchmarkLidar{number}"), "OmniLidar")
    write_config(prim, full_config(rate))
    write_aux_level(prim, "FULL")
    on_robot = mount == ROBOT
    place = Gf.Vec3d(-0.1, 0, 0.75) if on_robot else Gf.Vec3d(0.1 * number, 0, 1.0)
    UsdGeom.XformCommonAPI(prim).SetTranslate(place)
    if on_robot:
        write_exclude(prim, ("/World/Robot",))
    product = render_product(app, str(prim.GetPath()))
    product.sensor.require("benchmark", channels)
    return product


def full_config(rate: Fraction, ticks: int = 1800) -> LidarConfig:
    """32 emitters, so many ticks a turn."""
    state = EmitterState(azimuth_deg=np.zeros(32), elevation_deg=np.linspace(15, -16, 32))
    return LidarConfig(scan_rate_base_hz=rate, pattern_firing_rate_hz=ticks * rate, emitter_states=(state,))


def bare_casts(app: App, products: list[Any]) -> list[Callable[[], object]]:
    """For each product, calls that cast its rays at all that stands still and at all that moves."""
    open3d = import_open3d()
    static, moving = open3d.t.geometry.RaycastingScene(), open3d.t.geometry.RaycastingScene()
    hidden = read_exclude(app.stage.GetPrimAtPath(products[0].camera_path))
    for surface in app.geometry():
        if excluded(surface.path, hidden):
            continue
        assert isinstance(surface, Mesh)
        vertices = surface.vertices
        if surface.body is not None:
            pose = app.fabric.rigid_matrices([surface.body])[0]
            vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
        scene = static if surface.body is None else moving
        scene.add_triangles(vertices.astype(np.float32), surface.triangles)
    casts: list[Callable[[], object]] = []
    for product in products:
        pose = product.sensor.pose()
        directions = product.sensor.turns.pattern(0).directions @ pose[:3, :3].T.astype(np.float32)
        rays = np.concatenate([np.broadcast_to(pose[:3, 3], directions.shape), directions], axis=1).astype(np.float32)
        tensor = open3d.core.Tensor.from_numpy(np.ascontiguousarray(rays))
        casts += [partial(static.cast_rays, tensor), partial(moving.cast_rays, tensor)]
    return casts


def bare_steps(app: App) -> Callable[[int], None]:
    """`mj_step` n times on a copy of the App's physics, from the state that the App is in when they begin."""
    assert isinstance(app.physics, MujocoEngine)
    model, live = app.physics.model, app.physics.data
    data, kind = mujoco.MjData(model), mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, kind))

    def step(count: int) -> None:
        mujoco.mj_getState(model, live, state, kind)
        mujoco.mj_setState(model, data, state, kind)
        for _ in range(count):
            mujoco.mj_step(model, data)

    return step
