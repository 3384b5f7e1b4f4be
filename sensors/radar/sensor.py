"""RadarSensor: a radar at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from graph.sim.renderer.wrapper import unwrapped
from sensors.sensor import RenderedSensor, check_names, short_names

from .authoring import Radar

if TYPE_CHECKING:
    from graph.sim import App

    from .runtime import RadarRuntime

RESOLUTION = (300, 300)


class RadarSensor(RenderedSensor):
    """Renders a radar: `RadarSensor(radar_or_path, annotators=["generic-model-output"])`.

    A path makes a Radar on that prim, whose attributes stay as they are. The render product is 300 x 300, named
    rtx_sensor_<hash>. It exists from now on; if it was made while playing, until the stop. writers: names from the
    writer table. Raises SensorValueError (a UserError and a ValueError) for unknown names and prims.
    """

    def __init__(
        self,
        radar: Radar | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        annotators, writers = short_names(annotators), short_names(writers)
        check_names(annotators, writers)
        self.radar = radar if isinstance(radar, Radar) else Radar(radar, app=app)
        self.render_vars = tuple(render_vars or ())
        super().__init__(self.radar.app, self.radar.path, RESOLUTION, annotators, writers)

    @property
    def authoring_object(self) -> Radar:
        """The Radar."""
        return self.radar

    @property
    def runtime(self) -> RadarRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("RadarRuntime", unwrapped(self._product.sensor))
