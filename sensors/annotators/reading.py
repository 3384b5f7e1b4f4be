"""The input of an annotator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView
    from graph.sim.timing.time_queries import TimeQueries
    from sensors.frame import Frame
    from sensors.raycast.world import CastWorld


@dataclass(slots=True)
class Reading:
    """The input of an annotator: a frame of a render product (None before the first), and the options.

    times: the samples of simulation, monotonic and system time, which are looked up by the frame's time.
    """

    scene: WorldView
    times: TimeQueries
    product: RenderProduct
    options: Mapping[str, Any]
    frame: Frame | None = None

    @property
    def world(self) -> CastWorld:
        """The surfaces that frames show."""
        from sensors.raycast.shared import cast_world

        return cast_world(self.scene)

    @property
    def sensor(self) -> Sensor:
        """The sensor behind the product."""
        return self.product.sensor
