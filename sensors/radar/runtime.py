"""The runtime of a radar: its configuration and its schedule; `scans` traces its rays and detects."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base.exact import shortest
from graph.base.limits import check
from graph.sim import settings as keys
from graph.sim.renderer.schedule import EveryUpdate, Tick
from sensors.prim import unknown_attributes
from sensors.runtime import Measurement, SensorRuntime

from .config import MOST_BOUNCES, RadarConfig
from .names import PREFIX, PRIM_TYPE, SCAN_API, SCAN_PREFIX
from .prim import read_config

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Schedule

    from .cube import Cube
    from .scans import Scans


class RadarRuntime(SensorRuntime[RadarConfig]):
    """The sensor of a radar prim: each frame is one of its scan configurations, which take turns.

    A frame shows the instant of its update. Its elements are detections by rising range, not ray hits; a frame without
    any is a frame. Raises UserError for a prim that is not a radar or cannot be one.
    """

    type_name = PRIM_TYPE
    _scans: Scans | None = None

    def read(self, prim: Usd.Prim) -> RadarConfig:
        """The configuration that the prim describes."""
        for name, reason in unknown_attributes(prim, PREFIX, {SCAN_PREFIX: SCAN_API}):
            self.scene.warn("sensor-attribute-unknown", f"{self.path}.{name}", reason)
        return read_config(prim)

    @property
    def reach(self) -> float:
        """The longest range of its scans [m]."""
        return max(scan.max_range_m for scan in self.config.scans)

    def configure(self) -> None:
        """Checks the rays of each scan configuration, which are made when they are first needed."""
        config, rays = self.config, self.scene.fidelity.radar_rays
        self.coords = config.elements_coords_type
        self.frame_facts = {"frame_of_reference": config.output_frame_of_reference}
        self.bounces = min(self.scene.fidelity.radar_bounces or max(1, config.trace_tree_depth), MOST_BOUNCES)
        for scan in config.scans:
            across, up = scan.grid(rays)
            check("radar.rays", across * up, f"{self.path}: scan {scan.name} casts {across * up:,} rays")
        if config.without_effect:
            self.scene.warn(
                "radar-attribute-ignored",
                self.path,
                f"{', '.join(config.without_effect)}: not modelled, and without effect (chirps and arrays count only "
                "where datacubeMode is WAVEFORM); cells follow from rangeResM, velResMps, boreAzResDeg, boreElResDeg "
                "and maxVelMpsSequence",
            )
        settings = self.scene.settings
        if settings.get(keys.RADAR_NEEDS_MOTION_BVH) and not settings.get(keys.MOTION_BVH, False):
            self.scene.warn(
                "radar-motion-bvh-off",
                self.path,
                f"Isaac Sim gives no frames of it while Motion BVH is off; set {keys.MOTION_BVH} to true",
            )
        self._scans = None

    def schedule_for(self, moment: Fraction) -> Schedule:
        """The ticks of its rate; every update where a setting, as the product does, ignores that."""
        if self.rate and self.scene.settings.get(keys.RADAR_IGNORES_TICK_RATE):
            self.scene.warn(
                "radar-tick-rate-ignored",
                self.path,
                f"it renders in every update, not at {shortest(self.rate)} Hz: the setting "
                f"{keys.RADAR_IGNORES_TICK_RATE} of the profile is on; gate what it publishes (IsaacSimulationGate)",
            )
            return EveryUpdate(moment)
        return super().schedule_for(moment)

    @property
    def rule(self) -> str:
        """One frame a tick, or in every update."""
        return "every update" if isinstance(self.schedule, EveryUpdate) else super().rule

    def measure(self, tick: Tick) -> Measurement:
        """The detections of the scan whose turn it is."""
        return self._scanning().measure(self, tick, self._frames)

    def cube(self, tick: Tick, number: int = 0, cycle: int = 0) -> Cube:
        """What a scan receives in one of its cycles, in cells, before it is detected."""
        return self._scanning().cube(tick, self.pose(tick.poses), number, cycle)

    def _scanning(self) -> Scans:
        if self._scans is None:
            from .scans import Scans  # with all that traces and detects; a check needs none of it

            self._scans = Scans(self)
        return self._scans
