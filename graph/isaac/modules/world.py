"""`isaacsim.core.api.world`: a simulation context with a scene, tasks and a logger."""

from __future__ import annotations

from typing import Any

from .data_logger import DataLogger
from .scenes import Scene
from .simulation_context import SimulationContext

__all__ = ["World"]


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
