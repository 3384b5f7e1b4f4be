"""The runtime of a lidar: chooses the firings of each update and tick, and makes arrays of them."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.exact import nanoseconds
from graph.base.limits import check
from graph.sim import settings as keys
from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule
from sensors.channels import CHANNELS
from sensors.motion.velocities import surface_velocities
from sensors.raycast.shared import (
    cast_world,
    present_app,
    surface_classes,
    surface_ids,
    surface_materials,
    surface_optics,
)
from sensors.runtime import Measurement, SensorRuntime

from .bins import Bins
from .config import LidarConfig
from .names import PRIM_TYPE
from .noise import Noise
from .pattern import Pattern
from .prim import read_config
from .receiver import Receiver
from .returns import Shot
from .scan import Scanner
from .turns import turns_of

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Schedule


@dataclass(slots=True)
class _Turn:
    """An unfinished full scan: slices of one turn, oldest first."""

    parts: list[dict[str, np.ndarray]] = field(default_factory=list)
    firings: int = 0
    start: np.ndarray = field(default_factory=lambda: np.eye(4))
    end: np.ndarray = field(default_factory=lambda: np.eye(4))


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

    # -- what it is --------------------------------------------------------------------------------------------------

    def read(self, prim: Usd.Prim) -> LidarConfig:
        """The configuration that the prim describes."""
        return read_config(prim)

    def bare_rate(self) -> Fraction:
        """The tick rate [Hz] of a lidar without an authored one, by the profile."""
        return self._app.settings.rate(keys.BARE_LIDAR_TICK_RATE)

    def configure(self) -> None:
        """Prepares the turns, and the data for motion within a scan."""
        app, config = self._app, self.config
        rays = config.rays_per_scan * app.fidelity.lidar_subrays
        check(
            "lidar.rays", rays, f"{self.path}: {app.fidelity.lidar_subrays:,} sub-rays a beam make {rays:,} rays a scan"
        )
        self.turns = turns_of(config)
        if not len(self.turns.pattern(0)):
            raise UserError(f"{self.path}: no firing lies in its valid azimuth window; widen validStart/EndAzimuthDeg")
        self.reach = float(self.turns.pattern(0).far_m.max())
        self._whole = self.rate == config.scan_rate_base_hz and config.accumulate_outputs
        if not self._whole:
            self._warn_partial()
        self.coords = config.elements_coords_type
        self.wants_updates = self._whole and app.fidelity.lidar_motion == "update"
        self._casts_one_state = app.fidelity.lidar_motion == "frozen" and self._whole
        self._compensates = config.output_motion_compensation_state == "COMPENSATED" and not self.wants_updates
        if self.wants_updates and config.output_motion_compensation_state == "COMPENSATED":
            app.warn(
                "motion-compensation-off",
                self.path,
                "scans of lidar.motion update are NONCOMPENSATED; use continuous, or frozen",
            )
        self.frame_facts = {
            "frame_of_reference": config.output_frame_of_reference,
            "motion_compensation": "COMPENSATED" if self._compensates else "NONCOMPENSATED",
            "azimuth_offset_deg": config.start_azimuth_offset_deg,
            "one_instant": self._casts_one_state,
        }
        self._bins = Bins(app, self.path, self.turns) if app.fidelity.lidar_motion == "continuous" else None
        if app.fidelity.lidar_motion == "update":
            self.look_back(2 * self.turns.period)
        self._scanners: OrderedDict[int, Scanner] = OrderedDict()

    def schedule_for(self, moment: Fraction) -> Schedule:
        """Whole scans, one for each tick; or in every update the firings since the last output."""
        if self._whole:
            return TickSchedule(self.rate, moment, accumulates=True)
        return EveryUpdate(moment, self.rate)

    @property
    def rule(self) -> str:
        """The name of the rule: whole scans, slices of them, or parts if the rate differs from the scan rate."""
        if self._whole:
            return "whole"
        if not self.rate:
            return "every update"
        return "slices" if self.rate == self.config.scan_rate_base_hz else "partial"

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """The time of the firings: at most one turn."""
        if self._whole:
            return tick.start, tick.end
        return max(tick.start, tick.end - self.turns.period), tick.end

    def reference(self, tick: Tick) -> Fraction:
        """The time of the state that was cast, else the end of the scan, or the update for a part of a scan.

        The setting lidarHeader may choose the scan's start, or the update, instead.
        """
        header = self._app.settings.get(keys.LIDAR_HEADER)
        if header == keys.HEADER_SCAN_START:
            return self.interval(tick)[0]
        if header == keys.HEADER_UPDATE or not self._whole:
            return tick.time
        return tick.seen if self._casts_one_state else tick.end

    # -- measuring ---------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Drops unfinished scans."""
        super().reset()
        self._turns: dict[int, _Turn] = {}

    def advance(self, start: Fraction, end: Fraction, poses: Any) -> None:
        """Casts the firings in [start, end) with the state `poses`, for the scans they belong to."""
        oldest = end // self.turns.period - 1
        pose = self.pose(poses)
        for turn, rows in self.turns.slices(start, end, whole_turns=1):
            if turn >= oldest:
                self._add(turn, rows, pose, poses)
        for turn in [turn for turn in self._turns if turn < oldest]:
            del self._turns[turn]

    def measure(self, tick: Tick) -> Measurement:
        """The scan of a tick, or a part of one; of one state without a cast, and empty, if nothing is requested."""
        unread = not self.requested() and self._bins is None and not self.wants_updates
        found = None if unread and self._app.prune else self._cast(tick)
        if found is not None and not unread:
            return found
        pose = self.pose(tick.poses)
        return self._measured(_Turn(start=pose, end=pose), tick, complete=self._whole)

    def _cast(self, tick: Tick) -> Measurement:
        if isinstance(self.schedule, EveryUpdate):
            return self._measured(self._partial_scan(tick), tick, complete=False)
        turn = tick.index - 1
        firings = len(self.turns.pattern(turn))
        if self._bins is not None:
            scan = self._continuous_scan(tick.start, tick.end, [(turn, slice(0, firings))])
        else:
            scan = self._turns.pop(turn, _Turn()) if self.wants_updates else self._frozen_scan(tick)
        return self._measured(scan, tick, complete=scan.firings == firings)

    def _measured(self, scan: _Turn, tick: Tick, *, complete: bool) -> Measurement:
        parts = scan.parts
        count = sum(int(part.pop("count")) for part in parts)
        if not parts:
            arrays = {name: CHANNELS[name].empty() for name in self.requested() if name in CHANNELS}
        elif len(parts) == 1:
            arrays = parts[0]
        else:
            names = set.intersection(*(set(part) for part in parts))
            arrays = {name: np.concatenate([part[name] for part in parts]) for name in names}
        ends = self.ends(tick) if self.history is not None else (scan.start, scan.end)
        return Measurement(arrays, count, ends, complete)

    def _scanner(self, turn: int) -> Scanner:
        """The scanner for the firings of a turn; see `Turns`."""
        number = self.turns.number(turn)
        found = self._scanners.get(number)
        if found is None:
            while len(self._scanners) >= self.turns.kept:
                self._scanners.popitem(last=False)
            found = self._scanners[number] = self._new_scanner(self.turns.pattern(turn))
        return found

    def _scan(self, shot: Shot) -> dict[str, np.ndarray]:
        """The channels of a shot that are requested now, and their "count"."""
        found = self._scanner(shot.turn).scan(shot, self.channels())
        return found if self._app.prune else {**self.kept(found), "count": found["count"]}

    def _new_scanner(self, pattern: Pattern) -> Scanner:
        app, weak, config = self._app, self._owner, self.config
        return Scanner(
            pattern,
            lambda: cast_world(present_app(weak)),
            frame=config.output_frame_of_reference,
            exclude=self.exclude,
            keep_invalid=config.skip_dropping_invalid_points,
            velocities=surface_velocities(app, self.path, config.output_frame_of_reference == "WORLD"),
            receiver=Receiver(config),
            noise=Noise(config, pattern, app.seed, self.path) if app.fidelity.lidar_noise else None,
            optics=lambda: surface_optics(present_app(weak)),
            config=config,
            subrays=app.fidelity.lidar_subrays,
            tables={
                "matId": lambda: surface_materials(present_app(weak)),
                "objId": lambda: surface_ids(present_app(weak)),
                "classId": lambda: surface_classes(present_app(weak)),
            },
        )

    def _frozen_scan(self, tick: Tick) -> _Turn:
        pose, turn = self.pose(tick.poses), tick.index - 1
        firings = len(self._scanner(turn).pattern)
        part = self._scan(Shot(slice(0, firings), pose, tick.poses, turn=turn))
        return _Turn([part], firings, pose, pose)

    def _continuous_scan(self, start: Fraction, end: Fraction, slices: list[tuple[int, slice]]) -> _Turn:
        assert self._bins is not None
        scan = _Turn()
        shots, scan.start, scan.end = self._bins.shots(start, end, slices)
        for shot in shots:
            shot.common = scan.end if self._compensates and shot.moves is not None else None
            scan.parts.append(self._scan(shot))
            scan.firings += shot.rows.stop - shot.rows.start
        return scan

    def _add(self, turn: int, rows: slice, pose: np.ndarray, poses: Any) -> None:
        scan = self._turns.setdefault(turn, _Turn())
        scan.parts.append(self._scan(Shot(rows, pose, poses, turn=turn)))
        scan.firings += rows.stop - rows.start

    def _partial_scan(self, tick: Tick) -> _Turn:
        start, end = self.interval(tick)
        slices = self.turns.slices(start, end)
        if self._bins is not None:
            return self._continuous_scan(start, end, slices)
        period, stamp, pose = self.turns.period, nanoseconds(start), self.pose(tick.poses)
        shots = [Shot(rows, pose, tick.poses, nanoseconds(turn * period) - stamp, turn=turn) for turn, rows in slices]
        return _Turn([self._scan(shot) for shot in shots], 0, pose, pose)

    def _warn_partial(self) -> None:
        config = self.config
        if self.rate != config.scan_rate_base_hz:
            self._app.warn(
                "lidar-partial-scan",
                self.path,
                f"tickRate is {float(self.rate):g} Hz, scanRateBaseHz is {float(config.scan_rate_base_hz):g} Hz: each "
                "update gives only the firings since the last; set tickRate = scanRateBaseHz for whole scans",
            )
