"""Samples that scripts subclass: `isaacsim.examples.interactive.base_sample` over World, and `isaacsim.examples.base`.

Buttons call their coroutines there; here a script awaits them, or `graph exec` runs the task that it made.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, ClassVar

from graph.isaac.session import app, kit

from . import stage
from .managers import RenderingManager, SimulationManager
from .viewport_manager import ViewportManager
from .world import World

TASKS = "tasks_step"
EYE, TARGET, CAMERA = [1.5, 1.5, 1.5], [0.01, 0.01, 0.01], "/OmniverseKit_Persp"


class _Sample:
    """What both have: the settings, and calls for a subclass to fill."""

    _settings: ClassVar[dict[str, Any]] = {"physics_dt": 1 / 60, "stage_units_in_meters": 1.0, "rendering_dt": 1 / 60}

    def __init__(self) -> None:
        self._world_settings = dict(self._settings)
        self._logging_info = ""

    def _set(self, **given: Any) -> None:
        self._world_settings.update({name: value for name, value in given.items() if value is not None})

    def log_info(self, info: Any) -> None:
        self._logging_info += f"{info}\n"

    def setup_scene(self, scene: Any = None) -> None: ...

    async def setup_post_load(self) -> None: ...

    async def setup_pre_reset(self) -> None: ...

    async def setup_post_reset(self) -> None: ...

    async def setup_post_clear(self) -> None: ...


class BaseSample(_Sample):
    """Over World: `get_world()` in `setup_scene`, paused once it is loaded and after each reset."""

    def __init__(self) -> None:
        super().__init__()
        self._world: Any = None
        self._current_tasks: dict[str, Any] = {}

    def get_world(self) -> Any:
        return self._world

    def set_world_settings(
        self,
        physics_dt: float | None = None,
        stage_units_in_meters: float | None = None,
        rendering_dt: float | None = None,
    ) -> None:
        self._set(physics_dt=physics_dt, stage_units_in_meters=stage_units_in_meters, rendering_dt=rendering_dt)

    async def load_world_async(self) -> None:
        await stage.create_new_stage_async()
        self._world = World(**self._world_settings)
        await self._world.initialize_simulation_context_async()
        self.setup_scene()
        ViewportManager.set_camera_view(eye=EYE, target=TARGET, camera=CAMERA)
        self._current_tasks = self._world.get_current_tasks()
        await self._ready()
        await self.setup_post_load()
        self._follow_tasks()

    async def reset_async(self) -> None:
        if self._current_tasks:
            self._world.remove_physics_callback(TASKS)
        await self._world.play_async()
        await kit().next_update()
        await self.setup_pre_reset()
        await self._ready()
        await self.setup_post_reset()
        self._follow_tasks()

    async def _ready(self) -> None:
        await self._world.reset_async()
        await self._world.pause_async()

    def _follow_tasks(self) -> None:
        if self._current_tasks:
            self._world.add_physics_callback(TASKS, self._world.step_async)

    def world_cleanup(self) -> None: ...

    async def clear_async(self) -> None:
        await stage.create_new_stage_async()
        if self._world is not None:
            self._world.stop()
            self._world.clear_all_callbacks()
            World.clear_instance()
        self._world, self._current_tasks = None, {}
        self.world_cleanup()
        await self.setup_post_clear()


class PresentSample(_Sample):
    """Of Isaac Sim 6: no World; it plays once it is loaded and after each reset."""

    _settings: ClassVar[dict[str, Any]] = {**_Sample._settings, "device": "cpu"}

    def set_world_settings(
        self,
        physics_dt: float | None = None,
        stage_units_in_meters: float | None = None,
        rendering_dt: float | None = None,
        device: str | None = None,
    ) -> None:
        self._set(physics_dt=physics_dt, stage_units_in_meters=stage_units_in_meters, rendering_dt=rendering_dt)
        self._set(device=device)

    async def load_world_async(self) -> None:
        await stage.create_new_stage_async()
        settings = self._world_settings
        stage.set_stage_up_axis("Z")
        stage.set_stage_units(meters_per_unit=settings["stage_units_in_meters"])
        self.setup_scene()
        ViewportManager.set_camera_view(eye=EYE, target=TARGET, camera=CAMERA)
        await kit().next_update()
        SimulationManager.setup_simulation(dt=settings["physics_dt"], device=settings["device"])
        RenderingManager.set_dt(settings["rendering_dt"])
        await self._play()
        await self.setup_post_load()

    async def reset_async(self) -> None:
        await self.setup_pre_reset()
        app().stop()
        await self._play()
        await self.setup_post_reset()

    async def _play(self) -> None:
        await kit().next_update()
        app().play()
        await kit().next_update()

    def physics_cleanup(self) -> None: ...

    async def clear_async(self) -> None:
        await stage.create_new_stage_async()
        if app().timeline.is_playing():
            app().stop()
        self.physics_cleanup()
        await self.setup_post_clear()


interactive = SimpleNamespace(BaseSample=BaseSample)
present = SimpleNamespace(BaseSample=PresentSample)
PresentSample.__name__ = PresentSample.__qualname__ = "BaseSample"
