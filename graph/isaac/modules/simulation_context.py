"""`isaacsim.core.api.simulation_context`: playing, stepping and callbacks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.isaac.outcomes import inert
from graph.isaac.parameters import renamed
from graph.isaac.session import app, kit, warn
from graph.sim.usd import UsdGeom

from .physics_context import PhysicsContext

__all__ = ["SimulationContext"]


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
