"""The input of an annotator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from graph.sim.renderer.sensor import Sensor
    from sensors.frame import Frame


@dataclass(slots=True)
class Reading:
    """The input of an annotator: a frame of a render product (None before the first), and the options."""

    app: App
    product: RenderProduct
    options: Mapping[str, Any]
    frame: Frame | None = None

    @property
    def sensor(self) -> Sensor:
        """The sensor behind the product."""
        return self.product.sensor
