"""The sensor of a render product that has no sensor prim yet."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING

from .channels import AuxLevel
from .runtime import Measurement, SensorRuntime

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.schedule import Tick
    from graph.sim.renderer.view import WorldView


class Blank(SensorRuntime[None]):
    """Renders nothing. Requests are dropped when the product gets a real sensor."""

    type_name = ""

    def __init__(self, scene: WorldView) -> None:
        super().__init__(scene, "")

    def refresh(self) -> bool:
        """Does nothing: there is no prim to read."""
        if self._authored is None:
            self._authored, self._aux, self.rate = (), AuxLevel.NONE, Fraction(0)
            self.schedule = self.schedule_for(self.scene.rendering.moment)
            self.reset()
        return False

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Does nothing: it has no channels."""

    def read(self, prim: Usd.Prim) -> None:
        """Nothing: there is no prim to read."""

    def measure(self, tick: Tick) -> Measurement | None:
        """Nothing: it cannot measure."""
        return None
