"""The runtime of a camera: its configuration, its schedule and what is asked of it; `imager` makes the images."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base.limits import check
from graph.sim.renderer.schedule import Tick
from sensors.runtime import Measurement, SensorRuntime

from .channels import LIT
from .config import CameraConfig, checked_size, legacy_lens, read_config
from .names import PRIM_TYPE

if TYPE_CHECKING:
    from pxr import Usd

    from .imager import Imager
    from .tiled_sensor import TileGroup


class CameraRuntime(SensorRuntime[CameraConfig]):
    """The sensor of a Camera prim at the size of its render product.

    A frame shows the state of its update; with a rolling shutter its last line does, and each line before it an earlier
    state. Its arrays are images (height, width) or (height, width, n), the first row on top; `count` is the number of
    pixels. Raises UserError for a prim that is not a camera or cannot be one, and for a product without pixels or with
    too many.
    """

    type_name = PRIM_TYPE
    side_axis = 0
    group: TileGroup | None = None
    """The cameras whose rays are cast in one call with those of this camera; None: it casts alone."""
    _imager: Imager | None = None

    def read(self, prim: Usd.Prim) -> CameraConfig:
        """The camera that the prim describes, at the product's size."""
        legacy = legacy_lens(prim)
        if legacy:
            self.scene.warn(
                "camera-attribute-ignored",
                self.path,
                f"{', '.join(legacy)}: no effect on pictures; describe the lens with a schema OmniLensDistortion...API",
            )
        scene = self.scene
        return read_config(prim, checked_size(self.path, self.resolution), scene.meters_per_unit, scene.folders)

    def configure(self) -> None:
        """Forgets the rays of an earlier lens; those of this one are made when they are first needed."""
        if self.config.shutter is not None:
            self.look_back(2 * self.config.shutter.duration(self.config.size))
        if self._imager is not None:
            self._imager.reset()  # frees what OpenGL holds
        self._imager = None

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Requests channels, see `SensorRuntime.require`; UserError for colours of more rays than the limit allows."""
        super().require(owner, channels, optional=optional, ignore_aux=ignore_aux)
        if self.channels() & LIT:
            self.samples()

    def samples(self) -> int:
        """The rays of each pixel of a colour picture. Raises UserError for more than the limit allows."""
        samples, lens = self.scene.fidelity.camera_samples, self.config.lens
        rays = lens.width * lens.height * samples
        check("camera.rays", rays, f"{self.path}: camera.samples {samples:,} make {rays:,} rays an image")
        return samples

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """The instant of the update; of a rolling shutter the exposure of all lines, which ends then."""
        shutter = self.config.shutter
        if shutter is None:
            return super().interval(tick)
        return max(Fraction(0), tick.time - shutter.duration(self.config.size)), tick.time

    def reset(self) -> None:
        """Forgets where everything was."""
        super().reset()
        if self._imager is not None:
            self._imager.reset()

    def measure(self, tick: Tick) -> Measurement:
        """The image of a tick."""
        if self._imager is None:
            from .imager import Imager  # with all that casts and shades; a check needs none of it

            self._imager = Imager(self)
        return self._imager.measure(self, tick, self._frames)
