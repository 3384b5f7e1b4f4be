"""`isaacsim.core.api`: SimulationContext, World, PhysicsContext, tasks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.parameters import renamed
from graph.isaac.session import app, kit, warn
from graph.sim.usd import UsdGeom, UsdPhysics

from .prim_base import attribute
from .scenes import Scene

__all__ = [
    "BaseTask",
    "DataLogger",
    "PhysicsContext",
    "SimulationContext",
    "World",
]


class PhysicsContext:
    _gravity = 9.81

    def __init__(
        self,
        physics_dt: float | None = None,
        prim_path: str = "/physicsScene",
        sim_params: Any = None,
        set_defaults: bool = True,
    ) -> None:
        from graph.sim.scene.scene_attributes import scene_prims

        stage = app().stage
        found = next(scene_prims(stage), None)
        self.prim_path = prim_path if found is None else str(found.GetPath())
        self._scene = UsdPhysics.Scene.Define(stage, self.prim_path)
        self.device = "cpu"
        if set_defaults and found is None:
            self.set_gravity(-self._gravity / app().meters_per_unit)
        if physics_dt is not None or (set_defaults and found is None):
            self.set_physics_dt(physics_dt or 1 / 60)

    def get_current_physics_scene_prim(self) -> Any:
        return app().stage.GetPrimAtPath(self.prim_path)

    def set_physics_dt(self, dt: float = 1 / 60, substeps: int = 1) -> None:
        app().simulation.setup_simulation(dt=dt)

    def get_physics_dt(self) -> float:
        return float(app().simulation.get_physics_dt())

    def set_gravity(self, value: float) -> None:
        up = (0.0, 1.0, 0.0) if UsdGeom.GetStageUpAxis(app().stage) == "Y" else (0.0, 0.0, 1.0)
        sign = -1.0 if value <= 0 else 1.0
        self._scene.CreateGravityDirectionAttr().Set(tuple(sign * one for one in up))
        self._scene.CreateGravityMagnitudeAttr().Set(abs(float(value)))

    def get_gravity(self) -> tuple[list[float], float]:
        direction = self._scene.GetGravityDirectionAttr().Get() or (0, 0, -1)
        return list(direction), float(self._scene.GetGravityMagnitudeAttr().Get() or 0.0)

    def warm_start(self) -> None:
        app().simulation.initialize_physics()

    @property
    def use_fabric(self) -> bool:
        return bool(app().simulation.is_fabric_enabled())

    def enable_fabric(self, enable: bool) -> None:
        app().simulation.enable_fabric(enable)

    def _setting(self, name: str) -> Any:
        return self.get_current_physics_scene_prim().GetAttribute(f"physxScene:{name}")

    def set_physx_update_transformations_settings(
        self,
        update_to_usd: bool | None = None,
        update_velocities_to_usd: bool | None = None,
        output_velocities_local_space: bool | None = None,
    ) -> None:
        given = (update_to_usd, update_velocities_to_usd, output_velocities_local_space)
        for name, value in zip(_UPDATES, given, strict=True):
            if value is not None:
                app().settings.set(f"/physics/{name}", bool(value))

    def get_physx_update_transformations_settings(self) -> tuple[bool, bool, bool]:
        first, second, third = (bool(app().settings.get(f"/physics/{name}", False)) for name in _UPDATES)
        return first, second, third

    def __getattr__(self, name: str) -> Any:
        """Settings of GPUs and others that nothing here has: they do nothing."""
        word, _, rest = name.partition("_")
        if name.startswith("__") or word not in ("set", "get", "enable", "is", "use") or not rest:
            raise AttributeError(f"PhysicsContext has no {name}")

        def nothing(*_: Any, **__: Any) -> Any:
            tell_inert(f"isaacsim.core.api.PhysicsContext.{name}")
            return False if word in ("is", "get") else None

        return nothing


_UPDATES = ("updateToUsd", "updateVelocitiesToUsd", "outputVelocitiesLocalSpace")
_SCENE: dict[str, tuple[str, str, Any]] = {
    "ccd": ("enableCCD", "bool", False),
    "stablization": ("enableStabilization", "bool", False),
    "stabilization": ("enableStabilization", "bool", False),
    "gpu_dynamics": ("enableGPUDynamics", "bool", False),
    "solver_type": ("solverType", "token", "TGS"),
    "broadphase_type": ("broadphaseType", "token", "MBP"),
    "bounce_threshold": ("bounceThreshold", "float", 0.2),
    "friction_offset_threshold": ("frictionOffsetThreshold", "float", 0.04),
    "friction_correlation_distance": ("frictionCorrelationDistance", "float", 0.025),
    "enable_scene_query_support": ("enableSceneQuerySupport", "bool", True),
    "invert_collision_group_filter": ("invertCollisionGroupFilter", "bool", False),
    "solve_articulation_contact_last": ("solveArticulationContactLast", "bool", False),
}


def _scene_settings() -> None:
    """Gives PhysicsContext the calls for the settings of the scene's prim."""
    flags = ("ccd", "stablization", "stabilization", "gpu_dynamics")
    given = {"solver_type": "solver_type", "broadphase_type": "broadcast_type"}
    for word, (name, kind, default) in _SCENE.items():

        def setter(self: PhysicsContext, value: Any, name: str = name, kind: str = kind) -> None:
            attribute(self.get_current_physics_scene_prim(), f"physxScene:{name}", kind, value)

        def getter(self: PhysicsContext, name: str = name, default: Any = default) -> Any:
            found = self._setting(name)
            return found.Get() if found and found.HasAuthoredValue() else default

        parameter = "flag" if word in flags else given.get(word, word if "_" in word and kind == "bool" else "value")
        calls = (f"enable_{word}", f"is_{word}_enabled") if word in flags else (f"set_{word}", f"get_{word}")
        setattr(PhysicsContext, calls[0], renamed(setter, calls[0], parameter))
        setattr(PhysicsContext, calls[1], renamed(getter, calls[1]))


_scene_settings()


class SimulationContext:
    _kind: Any = None

    def __new__(cls, *_: Any, **__: Any) -> Any:
        found = kit().singletons.get(SimulationContext)
        if found is not None:
            warn("isaac-singleton", cls.__name__, "there is one already; it is used. clear_instance() ends it")
            return found
        made = super().__new__(cls)
        kit().singletons[SimulationContext] = made
        return made

    def __init__(
        self,
        physics_dt: float | None = None,
        rendering_dt: float | None = None,
        stage_units_in_meters: float | None = None,
        physics_prim_path: str = "/physicsScene",
        sim_params: Any = None,
        set_defaults: bool = True,
        backend: str = "numpy",
        device: str | None = None,
        stage: Any = None,
    ) -> None:
        if "_context" in self.__dict__:
            return
        if backend not in ("numpy", "warp"):
            from graph.isaac.outcomes import UnsupportedError

            raise UnsupportedError(f'backend "{backend}": arrays here are NumPy\'s; use backend="numpy"')
        present = app()
        present.stop()
        UsdGeom.SetStageUpAxis(present.stage, UsdGeom.Tokens.z)
        if stage_units_in_meters is not None or set_defaults:
            UsdGeom.SetStageMetersPerUnit(present.stage, stage_units_in_meters or 1.0)
        self.backend, self.device, self.backend_utils = backend, device or "cpu", None
        self._callbacks: dict[str, dict[str, Callable[[], None]]] = {}
        self._context = PhysicsContext(physics_dt, physics_prim_path, sim_params, set_defaults)
        if rendering_dt is not None or set_defaults:
            present.rendering.set_dt(rendering_dt if rendering_dt else 1 / 60)
        kit().turn()

    @classmethod
    def instance(cls) -> Any:
        return kit().singletons.get(SimulationContext)

    @classmethod
    def clear_instance(cls) -> None:
        found = kit().singletons.pop(SimulationContext, None)
        if found is not None:
            found.clear_all_callbacks()

    # -- driving -------------------------------------------------------------------------------------------------------

    @property
    def app(self) -> Any:
        from .kit_app import get_app

        return get_app()

    @property
    def stage(self) -> Any:
        return app().stage

    @property
    def physics_sim_view(self) -> Any:
        return app().simulation.get_physics_simulation_view()

    @property
    def current_time(self) -> float:
        return float(app().simulation.time)

    @property
    def current_time_step_index(self) -> int:
        return int(app().simulation.get_num_physics_steps())

    @property
    def _physics_context(self) -> PhysicsContext:
        return self._context

    def get_physics_context(self) -> PhysicsContext:
        return self._context

    def get_physics_dt(self) -> float:
        return self._context.get_physics_dt()

    def get_rendering_dt(self) -> float:
        return float(app().rendering.get_dt())

    def set_simulation_dt(self, physics_dt: float | None = None, rendering_dt: float | None = None) -> None:
        if physics_dt:
            self._context.set_physics_dt(physics_dt)
        if rendering_dt:
            app().rendering.set_dt(rendering_dt)

    def is_playing(self) -> bool:
        return app().timeline.is_playing()

    def is_stopped(self) -> bool:
        return app().timeline.is_stopped()

    def is_simulating(self) -> bool:
        return bool(app().simulation.is_simulating())

    def play(self) -> None:
        app().play()
        self.render()

    def pause(self) -> None:
        app().pause()
        self.render()

    def stop(self) -> None:
        app().stop()
        self.render()

    def render(self) -> None:
        from graph.isaac.run import RUN

        run = RUN.get()
        if run is not None:
            run.check()
        app().rendering.render()
        kit().turn()

    def step(self, render: bool = True, update_fabric: bool = False) -> None:
        if render:
            kit().update()
        elif app().timeline.is_playing():
            app().simulation.step(steps=1)

    def initialize_physics(self) -> None:
        if app().timeline.is_stopped():
            self.play()
        app().simulation.initialize_physics()

    def reset(self, soft: bool = False) -> None:
        if not soft:
            self.stop()
        self.initialize_physics()

    async def _after(self) -> None:
        await kit().next_update()

    async def initialize_simulation_context_async(self) -> None:
        await self._after()

    async def play_async(self) -> None:
        app().play()
        await self._after()

    async def pause_async(self) -> None:
        app().pause()
        await self._after()

    async def stop_async(self) -> None:
        app().stop()
        await self._after()

    async def render_async(self) -> None:
        await self._after()

    async def reset_async(self, soft: bool = False) -> None:
        self.reset(soft)
        await self._after()

    # -- callbacks -----------------------------------------------------------------------------------------------------

    def _add(self, kind: str, name: str, begin: Callable[[], Callable[[], None]]) -> None:
        held = self._callbacks.setdefault(kind, {})
        if name in held:
            warn("isaac-callback", name, f"there is a {kind} callback of that name already; the new one is left out")
        else:
            held[name] = begin()

    def add_physics_callback(self, callback_name: str, callback_fn: Any) -> None:
        def step() -> None:
            callback_fn(float(1 / app().simulation.steps_per_second))

        self._add("physics", callback_name, lambda: app().on("physics_pre_step", step))

    def add_render_callback(self, callback_name: str, callback_fn: Any) -> None:
        held = kit().update_stream.create_subscription_to_pop(callback_fn)
        self._add("render", callback_name, lambda: held.unsubscribe)

    def add_timeline_callback(self, callback_name: str, callback_fn: Any) -> None:
        held = kit().timeline_events.create_subscription_to_pop(callback_fn)
        self._add("timeline", callback_name, lambda: held.unsubscribe)

    def add_stage_callback(self, callback_name: str, callback_fn: Any) -> None:
        held = kit().stage_events.create_subscription_to_pop(callback_fn)
        self._add("stage", callback_name, lambda: held.unsubscribe)

    def clear_all_callbacks(self) -> None:
        for kind in list(self._callbacks):
            self._clear(kind)

    def _clear(self, kind: str) -> None:
        for end in self._callbacks.pop(kind, {}).values():
            end()

    def clear(self) -> None:
        self.clear_all_callbacks()

    def get_block_on_render(self) -> bool:
        return True

    @inert("isaacsim.core.api")
    def set_block_on_render(self, block: bool) -> None:
        return None

    @inert("isaacsim.core.api")
    def skip_next_stage_open_callback(self) -> None:
        return None


def _callback_calls() -> None:
    """`remove_physics_callback`, `physics_callback_exists`, `clear_physics_callbacks` and those of other kinds."""
    for kind in ("physics", "render", "timeline", "stage"):

        def remove(self: SimulationContext, name: str, kind: str = kind) -> None:
            self._callbacks.get(kind, {}).pop(name, lambda: None)()

        def exists(self: SimulationContext, name: str, kind: str = kind) -> bool:
            return name in self._callbacks.get(kind, {})

        def clear(self: SimulationContext, kind: str = kind) -> None:
            self._clear(kind)

        for call, function, parameters in (
            (f"remove_{kind}_callback", remove, ("callback_name",)),
            (f"{kind}_callback_exists", exists, ("callback_name",)),
            (f"clear_{kind}_callbacks", clear, ()),
        ):
            setattr(SimulationContext, call, renamed(function, call, *parameters))


_callback_calls()


class DataLogger:
    def __init__(self) -> None:
        self._frames: list[dict[str, Any]] = []
        self._function: Any = None
        self._on = False

    def add_data_frame_logging_func(self, func: Any) -> None:
        self._function = func

    def start(self) -> None:
        self._on = True

    def pause(self) -> None:
        self._on = False

    def is_started(self) -> bool:
        return self._on

    def reset(self) -> None:
        self._frames.clear()

    def get_num_of_data_frames(self) -> int:
        return len(self._frames)

    def get_data_frame(self, data_frame_index: int) -> Any:
        from .values import DataFrame

        one = self._frames[data_frame_index]
        return DataFrame(one["current_time_step"], one["current_time"], one["data"])

    def add_data(self, data: Any, current_time_step: float, current_time: float) -> None:
        self._frames.append({"current_time": current_time, "current_time_step": current_time_step, "data": data})

    def save(self, log_path: str) -> None:
        import json
        from pathlib import Path

        from graph.base.outputs import write

        write(Path(log_path), json.dumps({"Isaac Sim Data": self._frames}, default=_listed))

    def load(self, log_path: str) -> None:
        import json

        from graph.base.inputs import read_text

        self._frames = json.loads(read_text(log_path, "file.bytes"))["Isaac Sim Data"]

    def take(self, world: Any) -> None:
        """Logs a frame, if it is on."""
        if self._on and self._function is not None:
            data = self._function(world.get_current_tasks(), world.scene)
            self.add_data(data, world.current_time_step_index, world.current_time)


def _listed(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


class World(SimulationContext):
    def __init__(self, *args: Any, **named: Any) -> None:
        if "scene" in self.__dict__:
            return
        super().__init__(*args, **named)
        self.scene = Scene()
        self._tasks: dict[str, Any] = {}
        self._built = False
        self._logger = DataLogger()

    def add_task(self, task: Any) -> None:
        if task.name in self._tasks:
            raise Exception(f"Task name should be unique in the world: {task.name}")
        self._tasks[task.name] = task

    def get_task(self, name: str) -> Any:
        if name not in self._tasks:
            raise Exception(f"task name {name} doesn't exist in the current world tasks.")
        return self._tasks[name]

    def get_current_tasks(self) -> dict[str, Any]:
        return self._tasks

    def is_tasks_scene_built(self) -> bool:
        return self._built

    def get_observations(self, task_name: str | None = None) -> dict[str, Any]:
        if task_name is not None:
            return dict(self.get_task(task_name).get_observations())
        out: dict[str, Any] = {}
        for task in self._tasks.values():
            out.update(task.get_observations())
        return out

    def calculate_metrics(self, task_name: str | None = None) -> dict[str, Any]:
        if task_name is not None:
            return dict(self.get_task(task_name).calculate_metrics())
        out: dict[str, Any] = {}
        for task in self._tasks.values():
            out.update(task.calculate_metrics())
        return out

    def is_done(self, task_name: str | None = None) -> bool:
        if task_name is not None:
            return bool(self.get_task(task_name).is_done())
        return all(task.is_done() for task in self._tasks.values())

    def get_data_logger(self) -> DataLogger:
        return self._logger

    def reset(self, soft: bool = False) -> None:
        if not self._built:
            for task in self._tasks.values():
                task.set_up_scene(self.scene)
            self._built = True
        if not soft:
            self.stop()
        for task in self._tasks.values():
            task.cleanup()
        self.initialize_physics()
        self.scene.initialize()
        self.scene.post_reset()
        for task in self._tasks.values():
            task.post_reset()

    async def reset_async_set_up_scene(self, soft: bool = False) -> None:
        await self.reset_async(soft)

    async def reset_async_no_set_up_scene(self, soft: bool = False) -> None:
        await self.reset_async(soft)

    def step(  # type: ignore[override]
        self, render: bool = True, step_sim: bool = True, update_fabric: bool = False
    ) -> None:
        if step_sim:
            self._before_step()
            super().step(render)
            self._logger.take(self)
        elif render:
            self.render()

    def _before_step(self) -> None:
        for task in self._tasks.values() if self._built else ():
            task.pre_step(self.current_time_step_index, self.current_time)

    def step_async(self, step_size: float | None = None) -> None:
        """What tasks and the logger do at a physics step: a physics callback, not a coroutine."""
        self._before_step()
        self._logger.take(self)

    def clear(self) -> None:
        self.scene.clear()
        self._tasks.clear()
        super().clear()


class BaseTask:
    def __init__(self, name: str, offset: Any = None) -> None:
        self._name, self._scene = name, None
        self._offset = np.zeros(3) if offset is None else np.asarray(offset)
        self._task_objects: dict[str, Any] = {}

    @property
    def name(self) -> str:
        return self._name

    @property
    def scene(self) -> Any:
        return self._scene

    @property
    def device(self) -> str:
        return "cpu"

    def set_up_scene(self, scene: Any) -> None:
        self._scene = scene

    def _move_task_objects_to_their_frame(self) -> None:
        for one in self._task_objects.values():
            position, orientation = one.get_world_pose()
            if self._offset.any():
                one.set_world_pose(position + self._offset, orientation)
            one.set_default_state(position + self._offset, orientation)

    def get_task_objects(self) -> dict[str, Any]:
        return self._task_objects

    def get_observations(self) -> dict[str, Any]:
        raise NotImplementedError

    def calculate_metrics(self) -> dict[str, Any]:
        raise NotImplementedError

    def is_done(self) -> bool:
        raise NotImplementedError

    def pre_step(self, time_step_index: int, simulation_time: float) -> None:
        return None

    def post_reset(self) -> None:
        return None

    def get_description(self) -> str:
        return ""

    def cleanup(self) -> None:
        return None

    def set_params(self, *args: Any, **kwargs: Any) -> None:
        raise NotImplementedError

    def get_params(self) -> dict[str, Any]:
        raise NotImplementedError
