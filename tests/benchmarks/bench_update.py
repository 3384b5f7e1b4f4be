"""What an App update costs by itself: with nothing dynamic, with sensors that are not due, and beside raw mj_steps."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Any, cast
from unittest import mock

from measure import Row, ratio, seconds

from graph.recording.mcap_sink import McapSink
from graph.sim import App
from graph.sim.renderer.products import RenderProduct
from graph.sim.renderer.schedule import TickSchedule
from graph.sim.renderer.sensor import Sensor

TITLE = "App.update"
YARD = Path(__file__).parents[2] / "graphs" / "scenes" / "yard.usda"
PHYSICS_HZ, LOOP_HZ = 240, 60


class Idle:
    """A frozen sensor whose first tick lies 10**6 s away."""

    rate = Fraction(1, 10**6)
    wants_updates = False

    def __init__(self) -> None:
        self.schedule = TickSchedule(self.rate, accumulates=True)

    def render(self, tick: Any) -> None:
        """Never called here."""

    def reset(self) -> None:
        """Nothing to forget."""


def measure(quick: bool) -> Iterator[Row]:
    """Updates without any graph: of an empty stage in microseconds, of worlds as a multiple of their mj_steps."""
    rounds = 1 if quick else 25
    empty = nothing_dynamic(0, rounds)
    yield Row("App.update with nothing dynamic", empty, 20.0, "us")
    for count in (1, 16):
        more = nothing_dynamic(count, rounds) - empty
        yield Row(f"what {count} frozen sensor(s) not due add", more, 5.0 * count, "us")
    yield Row("App.update of 20 balls on a ground / its mj_steps", against_raw_steps(balls(), rounds), 1.2)
    yield Row("App.update of the yard / its mj_steps", against_raw_steps(YARD, rounds), 1.2)
    what = "glue of an update in the recorded yard without its radar: neither casts, compiled loops nor physics"
    yield Row(what, glue(2 * rounds) * 1e3, 12.0, "ms")
    processor, wall = recorded_yard(1 if quick else 5)
    yield Row("the recorded yard, a simulated second, all cores: processor time", processor, 1.4, "s")
    yield Row("the recorded yard: simulated over wall time", 1 / wall, 0.9, best="most")


def recorded_yard(rounds: int) -> tuple[float, float]:
    """Medians of the processor and wall seconds that a simulated second of the yard's file takes, after its first."""
    spent: list[tuple[float, float]] = []
    with TemporaryDirectory() as folder, App.from_file(YARD.parents[1] / "yard.yaml") as app:
        app.bus.subscribe(McapSink(Path(folder) / "run.mcap"))
        app.play()
        for _ in range(rounds + 1):
            processor, wall = process_time(), perf_counter()
            app.update(LOOP_HZ)
            spent.append((process_time() - processor, perf_counter() - wall))
    processors, walls = zip(*spent[1:], strict=True)
    return statistics.median(processors), statistics.median(walls)


def glue(updates: int) -> float:
    """Processor seconds of an update of the yard's file, recorded, less those of the work that is not Python's."""
    from graph.sim.physics.mujoco.engine import MujocoEngine
    from sensors.compiled import Compiled
    from sensors.raycast.triangles import TriangleScene

    spent = 0.0

    def counting(plain: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            nonlocal spent
            started = process_time()
            try:
                return plain(*arguments, **options)
            finally:
                spent += process_time() - started

        return call

    work = (TriangleScene, "cast"), (TriangleScene, "blocked"), (Compiled, "__call__"), (MujocoEngine, "step")
    with TemporaryDirectory() as folder, ExitStack() as stack:
        app = stack.enter_context(App.from_file(YARD.parents[1] / "yard.yaml"))
        app.bus.subscribe(McapSink(Path(folder) / "run.mcap"))
        app.play()
        app.update(12)
        for product in app.rendering.products.values():
            product.enabled = product.sensor.type_name != "OmniRadar"
        app.update(12)
        for owner, name in work:
            stack.enter_context(mock.patch.object(owner, name, counting(getattr(owner, name))))
        started = process_time()
        app.update(6 * updates)
        return (process_time() - started - spent) / (6 * updates)


def nothing_dynamic(sensors: int, rounds: int, updates: int = 2000) -> float:
    """Microseconds of an update of an empty stage with sensors that are not due: the median of several rounds."""
    with App(physics_hz=PHYSICS_HZ, loop_hz=LOOP_HZ) as app:
        for number in range(sensors):
            app.rendering.add(RenderProduct(f"/Render/{number}", "/World", (1, 1), cast("Sensor", Idle())))
        app.play()
        app.update(updates)
        return statistics.median(seconds(lambda: app.update(updates)) for _ in range(rounds)) / updates * 1e6


def against_raw_steps(stage: Any, rounds: int, updates: int = 60) -> float:
    """How much longer updates take than the mj_steps they contain, both starting from one state."""
    import mujoco
    import numpy as np

    from graph.sim.physics.mujoco.engine import MujocoEngine

    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    with App(stage, physics_hz=PHYSICS_HZ, loop_hz=LOOP_HZ) as app:
        app.play()
        app.update(LOOP_HZ)
        assert isinstance(app.physics, MujocoEngine)
        model, data = app.physics.model, app.physics.data
        state = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)

        def steps() -> None:
            mujoco.mj_setState(model, data, state, kind)
            for _ in range(updates * (PHYSICS_HZ // LOOP_HZ)):
                mujoco.mj_step(model, data)

        def ours() -> None:
            mujoco.mj_setState(model, data, state, kind)
            app.update(updates)

        return ratio(ours, steps, rounds)


def balls() -> Any:
    """20 balls falling on a ground plane."""
    from graph.sim.scene.stage import open_stage

    stage = open_stage()
    from pxr import Gf, UsdGeom, UsdPhysics

    ground = UsdGeom.Plane.Define(stage, "/World/Ground")
    UsdPhysics.CollisionAPI.Apply(ground.GetPrim())
    for number in range(20):
        ball = UsdGeom.Sphere.Define(stage, f"/World/Ball{number}")
        ball.GetRadiusAttr().Set(0.2)
        UsdGeom.Xformable(ball).AddTranslateOp().Set(Gf.Vec3d(number % 5, number // 5, 1 + 0.1 * number))
        UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
        UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    return stage
