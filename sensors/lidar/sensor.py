"""LidarSensor: a lidar with its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from graph.sim.renderer.wrapper import unwrapped
from sensors.sensor import PointSensor

from .authoring import Lidar

if TYPE_CHECKING:
    from graph.sim.app import App

    from .runtime import LidarRuntime


class LidarSensor(PointSensor[Lidar]):
    """Renders a lidar: `LidarSensor(lidar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Lidar

    def __init__(
        self,
        path: Lidar | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        super().__init__(path, annotators, writers, render_vars, app)

    @property
    def lidar(self) -> Lidar:
        """The Lidar."""
        return self.authoring_object

    @property
    def runtime(self) -> LidarRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("LidarRuntime", unwrapped(self._product.sensor))
