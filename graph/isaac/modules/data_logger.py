"""`isaacsim.core.api.loggers`: frames of data that a function gives."""

from __future__ import annotations

from typing import Any

__all__ = ["DataLogger"]


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

        self._frames = json.loads(read_text(log_path, "file.json"))["Isaac Sim Data"]

    def take(self, world: Any) -> None:
        """Logs a frame, if it is on."""
        if self._on and self._function is not None:
            data = self._function(world.get_current_tasks(), world.scene)
            self.add_data(data, world.current_time_step_index, world.current_time)


def _listed(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)
