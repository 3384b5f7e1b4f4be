"""The runtime of a lidar: its configuration and its schedule; `scans` casts its firings and makes arrays of them."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.base.limits import check
from graph.sim import settings as keys
from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule
from sensors.motion.history import history_of
from sensors.runtime import Measurement, SensorRuntime

from .config import TOKENS, LidarConfig
from .names import PRIM_TYPE, camel_case
from .pattern import turns_of, windowed
from .prim import read_config

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Schedule
    from graph.sim.renderer.view import WorldView

    from .scans import Scans


class LidarRuntime(SensorRuntime[LidarConfig]):
    """The sensor of a lidar prim.

    A lidar whose tick rate equals its scan rate, with accumulateOutputs, gives whole scans. `frozen` casts the scan
    with the state of its tick. `update` casts each update's firings with that update's state and joins them (the
    frame's poses are those at both ends of the scan). `continuous` fires each ray from the sensor's pose at its firing
    time, at bodies in their poses at that time (see `Bins`). Any other lidar gives, in every update, the firings since
    its last output, with the state of that update or, for `continuous`, of their own times; different rates give the
    warning `lidar-partial-scan`. Raises UserError for a prim that is not a valid lidar.
    """

    type_name = PRIM_TYPE
    _scans: Scans | None = None

    # -- what it is --------------------------------------------------------------------------------------------------

    def read(self, prim: Usd.Prim) -> LidarConfig:
        """The configuration that the prim describes."""
        return read_config(prim)

    def bare_rate(self) -> Fraction:
        """The tick rate [Hz] of a lidar without an authored one, by the profile."""
        return self.scene.settings.rate(keys.BARE_LIDAR_TICK_RATE)

    @property
    def reach(self) -> float:
        """The farthest range of its beams [m]."""
        return float(self.turns.pattern(0).far_m.max())

    def configure(self) -> None:
        """Prepares the turns, and the data for motion within a scan."""
        scene, config = self.scene, self.config
        subrays = scene.fidelity.lidar_subrays
        rays = config.rays_per_scan * subrays
        check("lidar.rays", rays, f"{self.path}: {subrays:,} sub-rays a beam make {rays:,} rays a scan")
        self.turns = turns_of(config)
        if windowed(config) and not len(self.turns.pattern(0)):
            raise UserError(f"{self.path}: no firing lies in its valid azimuth window; widen validStart/EndAzimuthDeg")
        self.whole = self.rate == config.scan_rate_base_hz and config.accumulate_outputs
        if not self.whole:
            self._warn_partial()
        self.coords = config.elements_coords_type
        self.wants_updates = self.whole and scene.fidelity.lidar_motion == "update"
        self._casts_one_state = scene.fidelity.lidar_motion == "frozen" and self.whole
        self.compensates = config.output_motion_compensation_state == "COMPENSATED" and not self.wants_updates
        if self.wants_updates and config.output_motion_compensation_state == "COMPENSATED":
            scene.warn(
                "motion-compensation-off",
                self.path,
                "scans of lidar.motion update are NONCOMPENSATED; use continuous, or frozen",
            )
        for name in ("ray_type", "intensity_processing"):
            chosen, modelled = getattr(config, name), TOKENS[name][0]
            if chosen != modelled:
                said = f"{camel_case(name)} {chosen} is not modelled; it acts as {modelled}"
                scene.warn("lidar-attribute-ignored", self.path, said)
        self.frame_facts = {
            "frame_of_reference": config.output_frame_of_reference,
            "motion_compensation": "COMPENSATED" if self.compensates else "NONCOMPENSATED",
            "azimuth_offset_deg": config.start_azimuth_offset_deg,
            "one_instant": self._casts_one_state,
        }
        if scene.fidelity.lidar_motion == "update":
            self.look_back(2 * self.turns.period)
        elif scene.fidelity.lidar_motion == "continuous":
            history_of(scene).keep(2 * self.turns.period)
        self._scans = None

    def schedule_for(self, moment: Fraction) -> Schedule:
        """Whole scans, one for each tick; or in every update the firings since the last output."""
        if self.whole:
            return TickSchedule(self.rate, moment, accumulates=True)
        return EveryUpdate(moment, self.rate)

    @property
    def rule(self) -> str:
        """The name of the rule: whole scans, slices of them, or parts if the rate differs from the scan rate."""
        if self.whole:
            return "whole"
        if not self.rate:
            return "every update"
        return "slices" if self.rate == self.config.scan_rate_base_hz else "partial"

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """The time of the firings: at most one turn."""
        if self.whole:
            return tick.start, tick.end
        return max(tick.start, tick.end - self.turns.period), tick.end

    def reference(self, tick: Tick) -> Fraction:
        """The time of the state that was cast, else the end of the scan, or the update for a part of a scan.

        The setting lidarHeader may choose the scan's start, or the update, instead.
        """
        header = tick.scene.settings.get(keys.LIDAR_HEADER)
        if header == keys.HEADER_SCAN_START:
            return self.interval(tick)[0]
        if header == keys.HEADER_UPDATE or not self.whole:
            return tick.time
        return tick.seen if self._casts_one_state else tick.end

    # -- measuring ---------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Drops unfinished scans."""
        super().reset()
        if self._scans is not None:
            self._scans.reset()

    def advance(self, start: Fraction, end: Fraction, scene: WorldView) -> None:
        """Casts the firings in [start, end) with the present state, for the scans they belong to."""
        self._scanning().advance(self, start, end, scene)

    def measure(self, tick: Tick) -> Measurement:
        """The scan of a tick, or the part of a scan that was fired since the last tick.

        If no channel is requested, no ray is cast: the result has the poses of one state and no returns.
        """
        return self._scanning().measure(self, tick)

    def _scanning(self) -> Scans:
        if self._scans is None:
            from .scans import Scans  # with all that casts and measures; a check needs none of it

            self._scans = Scans(self)
        return self._scans

    def _warn_partial(self) -> None:
        config = self.config
        if self.rate != config.scan_rate_base_hz:
            self.scene.warn(
                "lidar-partial-scan",
                self.path,
                f"tickRate is {float(self.rate):g} Hz, scanRateBaseHz is {float(config.scan_rate_base_hz):g} Hz: each "
                "update gives only the firings since the last; set tickRate = scanRateBaseHz for whole scans",
            )
