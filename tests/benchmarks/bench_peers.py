"""Against what people use instead, on the same work: other lidars over MuJoCo, another binding of Embree, other graphs.

The packages come with `make peers`; rows of one that is not installed are left out with a line.
Lidar: 64,000 rays at 10 Hz, read as GenericModelOutput once a frame, with 240 physics steps, 60 updates a second. The
share of the lidar is all that a user waits for in a frame, but for its 24 `mj_step`s: six updates and the reading.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, cast

import mujoco
import numpy as np
from bench_engine import REGISTRY, chain
from bench_lidar import rough_ground
from measure import Median, Row, ratio, seconds
from pxr import Gf, Sdf, UsdGeom

from graph import Context, compile_graphs
from graph.sim import App
from graph.sim.libraries import import_open3d
from graph.sim.renderer.wrapper import unwrapped
from sensors import LidarConfig, LidarSensor
from sensors.lidar.config import EmitterState
from sensors.lidar.prim import write_config

if TYPE_CHECKING:
    from sensors.lidar.runtime import LidarRuntime

TITLE = "Peers: how many times longer they take (lidar: 64,000 rays at 10 Hz, physics 240, loop 60)"
PHYSICS_HZ, LOOP_HZ, SCAN_HZ = 240, 60, 10
EMITTERS, TICKS = 32, 2000
BODIES = (20, 100, 1000)
SMALL_CHAIN = 100
NEEDS = ("embreex", "hamilton", "mujoco_lidar", "pipefunc", "warp")


def measure(quick: bool) -> Iterator[Row]:
    """Each row is the peer's time over ours."""
    rounds = 1 if quick else 15
    for _ in lidars(BODIES[0], 1):  # compiles the loops, once a machine
        pass
    for count in (0, *BODIES):
        yield from lidars(count, rounds)
    if available("embreex"):
        yield Row("embreex: casts of the same rays at 100,000 triangles", embree(rounds), None)
    if available("hamilton"):
        yield Row(f"Hamilton: {SMALL_CHAIN} functions in a row", ratio(hamilton(), ours(), 3 * rounds), 1, best="most")
    if available("pipefunc"):
        yield Row(f"pipefunc: {SMALL_CHAIN} functions in a row", ratio(pipes(), ours(), 3 * rounds), 1, best="most")


def available(module: str) -> bool:
    """Whether a peer is installed; says so where it is not."""
    if find_spec(module) is None:
        print(f"  {module} is not installed: make peers")
        return False
    return True


def lidars(count: int, rounds: int) -> Iterator[Row]:
    """`count` moving boxes and spheres over a terrain of 100,000 triangles; mj_multiRay and the Warp backend."""
    what = f"{count:,} moving boxes and spheres" if count else "100,000 triangles, nothing moves"
    with TemporaryDirectory() as folder:
        path, graph = Path(folder) / "scene.xml", Path(folder) / "graph.yaml"
        path.write_text(model_text(count))
        clock = f"{{physics_hz: {PHYSICS_HZ}, loop_hz: {LOOP_HZ}}}"
        graph.write_text(f"tickgraph: 1\nscene: {{mjcf: scene.xml}}\nclock: {clock}\n")
        with App.from_file(str(graph)) as app:
            sensor = add_lidar(app)

            def frame() -> None:
                app.update(steps=LOOP_HZ // SCAN_HZ)
                sensor.get_data("generic-model-output")

            app.play()
            first = seconds(frame)
            frame()
            model = mujoco.MjModel.from_xml_path(str(path))
            data = mujoco.MjData(model)
            runtime = cast("LidarRuntime", unwrapped(sensor.render_product.sensor))
            directions = runtime.turns.pattern(0).directions.astype(np.float64)

            def steps() -> None:
                mujoco.mj_step(model, data, nstep=PHYSICS_HZ // SCAN_HZ)

            for name, trace in peers(model, data, directions):
                trace()
                lead = []
                for _ in range(rounds):
                    physics, whole, peer = seconds(steps), seconds(frame), seconds(trace)
                    lead.append(peer / max(whole - physics, 1e-9))
                bound = 5.0 if name.startswith("mujoco-lidar") and count else None
                yield Row(f"{name}: {what}", Median(lead), bound, best="most")
            yield Row(f"the first frame of ours: {what}", first, 1.0, "s")


def peers(model: Any, data: Any, directions: np.ndarray) -> Iterator[tuple[str, Callable[[], object]]]:
    """Each peer's name and a call that casts the rays (n, 3) at the model's state, as a fresh frame."""
    rays = len(directions)
    origin = np.array([0.0, 0.0, 1.5])
    ids, distances, vectors = np.empty(rays, np.int32), np.empty(rays), directions.reshape(-1).copy()

    def multi_ray() -> None:
        mujoco.mj_multiRay(model, data, origin, vectors, None, 1, -1, ids, distances, None, rays, 100.0)

    yield "mj_multiRay", multi_ray
    if available("mujoco_lidar") and available("warp"):
        import warp
        from mujoco_lidar import MjLidarWrapper

        warp.config.quiet = True
        lidar = MjLidarWrapper(model, site_name="lidar", backend="warp", cutoff_dist=100.0, args={"device": "cpu"})
        azimuth = np.arctan2(directions[:, 1], directions[:, 0])
        elevation = np.arcsin(np.clip(directions[:, 2], -1, 1))
        yield "mujoco-lidar (Warp)", lambda: lidar.trace_rays(data, azimuth, elevation)


def model_text(count: int) -> str:
    """An MJCF model: the terrain as a mesh, and `count` bodies that fall slowly, without contacts."""
    random = np.random.default_rng(1)
    ground = rough_ground(224)
    bodies = []
    for number in range(count):
        x, y = random.uniform(-60, 60, 2)
        kind = 'type="box" size=".5 .5 .5"' if number % 2 else 'type="sphere" size=".5"'
        bodies.append(
            f'<body pos="{x:.3f} {y:.3f} {random.uniform(0, 3):.3f}"><freejoint/>'
            f'<geom {kind} mass="1" contype="0" conaffinity="0"/></body>'
        )
    vertices = " ".join(f"{v:.4f}" for v in ground.vertices.reshape(-1))
    faces = " ".join(map(str, ground.triangles.reshape(-1)))
    return f"""<mujoco><option gravity="0 0 -.001" timestep="{1 / PHYSICS_HZ}"/>
    <asset><mesh name="ground" inertia="shell" vertex="{vertices}" face="{faces}"/></asset>
    <worldbody><geom type="mesh" mesh="ground" contype="0" conaffinity="0"/><site name="lidar" pos="0 0 1.5"/>
    {"".join(bodies)}</worldbody></mujoco>"""


def add_lidar(app: App) -> Any:
    """A lidar of 64,000 rays a turn where the model has its site, read as GenericModelOutput."""
    prim = app.stage.DefinePrim(Sdf.Path("/World/BenchmarkLidar"), "OmniLidar")
    state = EmitterState(azimuth_deg=np.zeros(EMITTERS), elevation_deg=np.linspace(15, -16, EMITTERS))
    rate = Fraction(10)
    write_config(
        prim, LidarConfig(scan_rate_base_hz=rate, pattern_firing_rate_hz=TICKS * rate, emitter_states=(state,))
    )
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(0, 0, 1.5))
    return LidarSensor(str(prim.GetPath()), annotators=["generic-model-output"], app=app)


def embree(rounds: int) -> Median:
    """Time of embreex's casts over Open3D's, which are Embree's too."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    ground = rough_ground(224)
    vertices, triangles = ground.vertices.astype(np.float32), ground.triangles
    scene = EmbreeScene()
    TriangleMesh(scene, vertices, triangles.astype(np.int32))
    open3d = import_open3d()
    raycasting = open3d.t.geometry.RaycastingScene()
    raycasting.add_triangles(vertices, triangles)
    azimuth, elevation = np.meshgrid(np.linspace(0, 2 * np.pi, TICKS), np.radians(np.linspace(15, -16, EMITTERS)))
    directions = np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=-1
    )
    rays = np.zeros((EMITTERS * TICKS, 6), np.float32)
    rays[:, 2], rays[:, 3:] = 1.5, directions.reshape(-1, 3)
    origins, vectors = rays[:, :3].copy(), rays[:, 3:].copy()
    tensor = open3d.core.Tensor.from_numpy(rays)
    return ratio(lambda: scene.run(origins, vectors, query="DISTANCE"), lambda: raycasting.cast_rays(tensor), rounds)


def ours() -> Callable[[], object]:
    """One evaluation of a push graph of the chain."""
    graph, context = compile_graphs([chain("push", SMALL_CHAIN)], REGISTRY)[0], Context.standalone()
    graph.evaluate(context)
    return lambda: graph.evaluate(context)


def hamilton() -> Callable[[], object]:
    """The chain as Hamilton's functions, each named as what it gives."""
    from hamilton import ad_hoc_utils, driver

    functions: dict[str, Any] = {}
    for number in range(SMALL_CHAIN):
        source = f"n{number - 1}" if number else "start"
        exec(
            f"def n{number}({source}: float) -> float:\n    return {source} + 1\n", functions
        )  # the names are the graph
    steps = [functions[f"n{number}"] for number in range(SMALL_CHAIN)]
    walk = driver.Builder().with_modules(ad_hoc_utils.create_temporary_module(*steps)).build()
    return lambda: walk.execute([f"n{SMALL_CHAIN - 1}"], inputs={"start": 0.0})


def pipes() -> Callable[[], object]:
    """The chain as a pipeline of pipefunc."""
    from pipefunc import PipeFunc, Pipeline

    def more(a: float) -> float:
        return a + 1

    functions: list[Any] = [
        PipeFunc(more, f"n{i}", renames={"a": f"n{i - 1}" if i else "start"}) for i in range(SMALL_CHAIN)
    ]
    pipeline = Pipeline(functions)
    return lambda: pipeline.run(f"n{SMALL_CHAIN - 1}", kwargs={"start": 0.0})
