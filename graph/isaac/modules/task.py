"""`isaacsim.core.api.tasks.base_task`: what tasks share."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["BaseTask"]


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
