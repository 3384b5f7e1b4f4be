"""The light beam sensor of PhysX: parallel beams side by side, a light curtain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph.base.limits import check
from graph.base.records import dataclass
from graph.sim.renderer.schedule import Tick
from sensors.raycast.shared import cast_world
from sensors.runtime import Measurement, SensorRuntime

from .attributes import fail, number, read_ranges, unit_axis
from .beams import fire, told
from .names import LIGHT_BEAM

if TYPE_CHECKING:
    from pxr import Usd


@dataclass(frozen=True, slots=True)
class LightBeamConfig:
    """The configuration of a light curtain.

    forward: (x, y, z) unit direction of every beam; step: from the origin of a beam to that of the next one, in stage
    units, curtainLength / numRays along curtainAxis (so the last beam is one step short of the curtain's end). Both in
    the sensor's axes. ranges: minRange, maxRange [m].
    """

    enabled: bool
    ranges: tuple[float, float]
    count: int
    forward: tuple[float, ...]
    step: tuple[float, ...]


def read_config(prim: Usd.Prim) -> LightBeamConfig:
    """What a prim describes. Raises UserError for an invalid count, axis or range."""
    count = int(prim.GetAttribute("numRays").Get())
    if count < 1:
        fail(prim, "numRays", "give 1 or more")
    check("lidar.rays", count, f"{prim.GetPath()}: numRays is {count:,}")
    step = unit_axis(prim, "curtainAxis") * float(number(prim, "curtainLength", least=0) / count)
    forward = unit_axis(prim, "forwardAxis")
    enabled = bool(prim.GetAttribute("enabled").Get())
    return LightBeamConfig(enabled, read_ranges(prim), count, tuple(forward.tolist()), tuple(step.tolist()))


class LightBeamRuntime(SensorRuntime[LightBeamConfig]):
    """The sensor of a light beam prim: all beams in each tick. A disabled one gives nothing."""

    type_name = LIGHT_BEAM

    def read(self, prim: Usd.Prim) -> LightBeamConfig:
        """The configuration that the prim describes."""
        return read_config(prim)

    def configure(self) -> None:
        """Prepares the beams."""
        config = self.config
        step = np.array(config.step) * self.scene.meters_per_unit
        self.origins = np.arange(config.count)[:, None] * step
        """Of the beams, (n, 3) float64 [m], in the sensor's axes."""
        self.directions = np.tile(np.array(config.forward), (config.count, 1))
        """Of the beams, (n, 3) float64, unit, in the sensor's axes."""

    def measure(self, tick: Tick) -> Measurement | None:
        """All beams."""
        config = self.config
        if not config.enabled:
            return None
        pose, origins, directions, ranges = self.pose(tick.poses), self.origins, self.directions, config.ranges
        depths = fire(cast_world(tick.scene), pose, origins, directions, ranges, tick.poses, self.exclude)
        return Measurement(told(self.channels(), depths, origins, directions, ranges), config.count)
