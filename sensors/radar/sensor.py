"""RadarSensor: a radar at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from graph.sim.renderer.wrapper import unwrapped
from sensors.sensor import PointSensor

from .authoring import Radar

if TYPE_CHECKING:
    from graph.sim.app import App

    from .runtime import RadarRuntime


class RadarSensor(PointSensor[Radar]):
    """Renders a radar: `RadarSensor(radar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Radar

    def __init__(
        self,
        path: Radar | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        super().__init__(path, annotators, writers, render_vars, app)

    @property
    def radar(self) -> Radar:
        """The Radar."""
        return self.authoring_object

    @property
    def runtime(self) -> RadarRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("RadarRuntime", unwrapped(self._product.sensor))
