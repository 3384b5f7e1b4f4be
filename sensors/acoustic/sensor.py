"""AcousticSensor: an acoustic sensor at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from graph.sim.renderer.wrapper import unwrapped
from sensors.sensor import PointSensor

from .authoring import Acoustic

if TYPE_CHECKING:
    from graph.sim.app import App

    from .runtime import AcousticRuntime


class AcousticSensor(PointSensor[Acoustic]):
    """Renders an acoustic sensor: `AcousticSensor(acoustic_or_path, annotators=["generic-model-output"])`."""

    authored_by = Acoustic

    def __init__(
        self,
        path: Acoustic | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        super().__init__(path, annotators, writers, render_vars, app)

    @property
    def acoustic(self) -> Acoustic:
        """The Acoustic."""
        return self.authoring_object

    @property
    def runtime(self) -> AcousticRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("AcousticRuntime", unwrapped(self._product.sensor))
