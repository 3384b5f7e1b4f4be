"""Small modules: `isaacsim.core.nodes.scripts.utils`, `omni.physics.core`, `omni.physx`, benchmarks, extensions."""

from __future__ import annotations

import logging
from typing import Any

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import app, kit

__all__ = [
    "BaseIsaacBenchmark",
    "IExt",
    "createJoint",
    "get_physics_simulation_interface",
    "get_physx_interface",
    "get_physx_simulation_interface",
    "get_physxunittests_interface",
    "import_module",
    "register_annotator_from_node_with_telemetry",
    "register_node_writer_with_telemetry",
    "run_coroutine",
    "set_target_prims",
]


def set_target_prims(primPath: str, targetPrimPaths: Any, inputName: str = "inputs:targetPrim") -> None:
    from graph.isaac.omnigraph.controller import Controller
    from graph.isaac.omnigraph.lookup import get_node_by_path

    paths = [str(one) for one in ([targetPrimPaths] if isinstance(targetPrimPaths, str) else targetPrimPaths)]
    node = get_node_by_path(primPath)
    try:
        if node is not None:
            Controller.set(f"{primPath}.{inputName}", paths)
            return
        prim = app().stage.GetPrimAtPath(primPath)
        (prim.GetRelationship(inputName) or prim.CreateRelationship(inputName)).SetTargets(paths)
    except Exception as error:
        print(error, primPath)


def register_annotator_from_node_with_telemetry(*_: Any, **__: Any) -> None:
    tell_inert("isaacsim.core.nodes.scripts.utils.register_annotator_from_node_with_telemetry")


def register_node_writer_with_telemetry(*_: Any, **__: Any) -> None:
    tell_inert("isaacsim.core.nodes.scripts.utils.register_node_writer_with_telemetry")


class _Subscription:
    def __init__(self, end: Any) -> None:
        self._end = end

    def unsubscribe(self) -> None:
        self._end()

    def __del__(self) -> None:
        self._end()


def _each_step(fn: Any, before: bool, order: int) -> _Subscription:
    """Calls a function with the length of each physics step [s], before or after it."""
    present = app()

    def step() -> None:
        fn(float(1 / present.simulation.steps_per_second))

    return _Subscription(present.on("physics_pre_step" if before else "physics_post_step", step, order))


class _Physics:
    def subscribe_physics_on_step_events(
        self, on_update: Any = None, pre_step: bool = False, order: int = 0, **_: Any
    ) -> _Subscription:
        return _each_step(lambda seconds: on_update(seconds, None), pre_step, order)

    def subscribe_physics_step_events(self, fn: Any) -> _Subscription:
        return _each_step(fn, True, 0)

    def simulate(self, dt: float = 0.0, time: float = 0.0) -> None:
        app().simulation.step(steps=1)

    def start_simulation(self) -> None:
        app().play()

    def fetch_results(self) -> None:
        """A step has ended when `simulate` returns."""

    def update_transformations(self, *_: Any, **__: Any) -> None:
        """Poses on the stage are those of the last step already."""

    @inert("omni.physx")
    def force_load_physics_from_usd(self, *_: Any, **__: Any) -> None: ...

    @inert("omni.physx")
    def release_physics_objects(self, *_: Any, **__: Any) -> None: ...

    @inert("omni.physx")
    def reset_simulation(self, *_: Any, **__: Any) -> None: ...


class _Physx(_Physics):
    def subscribe_physics_on_step_events(self, fn: Any, pre_step: bool = False, order: int = 0) -> _Subscription:  # type: ignore[override]
        return _each_step(fn, pre_step, order)

    def subscribe_contact_report_events(self, fn: Any, *, full: bool = False) -> _Subscription:
        from .contact_reports import Reports

        return _Subscription(app().on("physics_post_step", Reports(fn, full=full)))

    def subscribe_full_contact_report_events(self, fn: Any) -> _Subscription:
        return self.subscribe_contact_report_events(fn, full=True)

    def get_contact_report(self) -> Any:
        """Headers and contacts of the last step."""
        from .contact_reports import Reports

        physics = app().physics
        return ([], []) if physics is None else Reports(lambda *_: None).of(physics.contacts())


def get_physics_simulation_interface() -> _Physics:
    return _Physics()


def get_physx_interface() -> _Physx:
    return _Physx()


get_physx_simulation_interface = get_physx_interface
acquire_physx_interface = acquire_physx_simulation_interface = get_physx_interface


class _Statistics:
    def get_physics_stats(self) -> dict[str, int]:
        """How many bodies the playing world has, by kind."""
        physics = app().physics
        held = () if physics is None else physics.body_paths
        kinematic = sum(path in physics.kinematic for path in held) if physics is not None else 0
        return {"numDynamicRigids": len(held) - kinematic, "numKinematicBodies": kinematic}


def get_physxunittests_interface() -> _Statistics:
    return _Statistics()


def createJoint(stage: Any, joint_type: str, from_prim: Any, to_prim: Any) -> Any:
    from graph.sim.usd import UsdPhysics

    kinds = {
        "Revolute": UsdPhysics.RevoluteJoint,
        "Prismatic": UsdPhysics.PrismaticJoint,
        "Spherical": UsdPhysics.SphericalJoint,
        "Fixed": UsdPhysics.FixedJoint,
        "Distance": UsdPhysics.DistanceJoint,
    }
    to, source = (to_prim or from_prim), (from_prim if to_prim else None)
    path = f"{to.GetPath()}/{joint_type}Joint"
    made = kinds.get(joint_type, UsdPhysics.Joint).Define(stage, path)
    if source:
        made.CreateBody0Rel().SetTargets([source.GetPath()])
    made.CreateBody1Rel().SetTargets([to.GetPath()])
    return made.GetPrim()


def run_coroutine(coroutine: Any) -> Any:
    from asyncio import ensure_future

    return ensure_future(coroutine, loop=kit().loop)


def import_module(name: str) -> Any:
    from importlib import import_module as imported

    return imported(name)


class IExt:
    def on_startup(self, ext_id: str) -> None:
        return None

    def on_shutdown(self) -> None:
        return None


class BaseIsaacBenchmark:
    def __init__(self, benchmark_name: str = "BaseIsaacBenchmark", *_: Any, **__: Any) -> None:
        tell_inert("isaacsim.benchmark.services.BaseIsaacBenchmark")
        self.benchmark_name = benchmark_name
        self.recorders: list[Any] = []

    @property
    def assets_root_path(self) -> str:
        from .storage import get_assets_root_path

        return get_assets_root_path()

    def fully_load_stage(self, usd_path: str) -> None:
        from .usd import get_context

        get_context().open_stage(usd_path)

    def run_warmup(self, n_frames: int) -> None:
        for _ in range(n_frames):
            kit().update()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in _BENCHMARK:
            raise AttributeError(f"BaseIsaacBenchmark has no {name}")
        return lambda *_, **__: logging.getLogger("tickgraph").debug("%s", name)


_BENCHMARK = ("set_phase", "stop", "store_measurements", "store_custom_measurement", "start_collecting_frametime")
