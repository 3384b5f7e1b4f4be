"""AcousticSensor: an acoustic sensor at work, its render product, annotators and writers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from graph.sim.renderer.wrapper import unwrapped
from sensors.sensor import RenderedSensor, check_names, short_names

from .authoring import Acoustic

if TYPE_CHECKING:
    from graph.sim import App

    from .runtime import AcousticRuntime

RESOLUTION = (300, 300)


class AcousticSensor(RenderedSensor):
    """Renders an acoustic sensor: `AcousticSensor(acoustic_or_path, annotators=["generic-model-output"])`.

    A path makes an Acoustic on that prim, whose attributes stay as they are. The render product is 300 x 300, named
    rtx_sensor_<hash>. It exists from now on; if it was made while playing, until the stop. writers: names from the
    writer table. Raises SensorValueError (a UserError and a ValueError) for unknown names and prims.
    """

    def __init__(
        self,
        acoustic: Acoustic | str,
        *,
        annotators: str | Iterable[str] | None = None,
        writers: str | Iterable[str] | None = None,
        render_vars: Iterable[str] | None = None,
        app: App | None = None,
    ) -> None:
        annotators, writers = short_names(annotators), short_names(writers)
        check_names(annotators, writers)
        self.acoustic = acoustic if isinstance(acoustic, Acoustic) else Acoustic(acoustic, app=app)
        self.render_vars = tuple(render_vars or ())
        super().__init__(self.acoustic.app, self.acoustic.path, RESOLUTION, annotators, writers)

    @property
    def authoring_object(self) -> Acoustic:
        """The Acoustic."""
        return self.acoustic

    @property
    def runtime(self) -> AcousticRuntime:
        """The runtime behind the render product; also after the product was removed."""
        return cast("AcousticRuntime", unwrapped(self._product.sensor))
