"""The scans of a lidar: the firings of each update and tick are cast, and what they measure is joined."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.sim.devices import HOST
from graph.sim.renderer.schedule import EveryUpdate, Tick
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
from sensors.runtime import Measurement, Model

from .bins import Bins
from .noise import Noise
from .pattern import Pattern
from .returns import Shot, SurfaceTable
from .scan import Scanner

if TYPE_CHECKING:
    from sensors.device.lidar import DeviceLidar

    from .runtime import LidarRuntime


@dataclass(slots=True)
class _Turn:
    """A scan, or the part of one that is there: the channels of its slices, oldest first, and their firings.

    start, end: sensor to world, (4, 4) float64 [m], at both ends of it.
    """

    parts: list[dict[str, np.ndarray]] = field(default_factory=list)
    firings: int = 0
    start: np.ndarray = field(default_factory=lambda: np.eye(4))
    end: np.ndarray = field(default_factory=lambda: np.eye(4))


class Scans(Model["LidarRuntime"]):
    """The scans of one lidar as it is configured now: unfinished ones, and the scanners of its turns."""

    def __init__(self, lidar: LidarRuntime) -> None:
        super().__init__(lidar)
        self._config, self._history, self._turns = lidar.config, lidar.history, lidar.turns
        continuous = self._app.fidelity.lidar_motion == "continuous"
        self._bins = Bins(self._app, lidar.path, lidar.turns) if continuous else None
        self._scanners: OrderedDict[int, Scanner] = OrderedDict()
        self._unfinished: dict[int, _Turn] = {}
        self._devices: dict[int, tuple[Any, DeviceLidar | None]] = {}

    def reset(self) -> None:
        """Drops unfinished scans."""
        self._unfinished = {}

    def advance(self, start: Fraction, end: Fraction, poses: Any) -> None:
        """Casts the firings in [start, end) with the state `poses`, for the scans they belong to, if they are read."""
        if self._unread:
            self._unfinished.clear()
            return
        oldest = end // self._turns.period - 1
        pose = self._sensor.pose(poses)
        for turn, rows in self._turns.slices(start, end, whole_turns=1):
            if turn >= oldest:
                self._add(turn, rows, pose, poses)
        for turn in [turn for turn in self._unfinished if turn < oldest]:
            del self._unfinished[turn]

    def measure(self, tick: Tick) -> Measurement:
        """The scan of a tick, or the part fired since the last one. Without requested channels: empty, and no cast."""
        found = None if self._unread else self._cast(tick)
        if found is not None:
            return found
        pose = self._sensor.pose(tick.poses)
        ends = (pose, pose) if self._bins is None else self._bins.ends(*self._sensor.interval(tick))
        return self._measured(_Turn([], 0, *ends), tick, complete=self._sensor.whole)

    @property
    def _unread(self) -> bool:
        """Whether there is nothing to cast for."""
        return not self._sensor.channels()

    def _cast(self, tick: Tick) -> Measurement:
        if isinstance(self._sensor.schedule, EveryUpdate):
            return self._measured(self._partial_scan(tick), tick, complete=False)
        turn = tick.index - 1
        firings = len(self._turns.pattern(turn))
        if self._bins is not None:
            scan = self._continuous_scan(tick.start, tick.end, [(turn, slice(0, firings))])
        elif self._sensor.wants_updates:
            scan = self._unfinished.pop(turn, _Turn())
        elif (device := self._on_device(turn)) is not None:
            return self._device_scan(device, tick)
        else:
            scan = self._frozen_scan(tick)
        return self._measured(scan, tick, complete=scan.firings == firings)

    def _measured(self, scan: _Turn, tick: Tick, *, complete: bool) -> Measurement:
        parts = scan.parts
        count = sum(int(part.pop("count")) for part in parts)
        if not parts:
            arrays = {name: CHANNELS[name].empty() for name in self._sensor.channels() if name in CHANNELS}
        elif len(parts) == 1:
            arrays = parts[0]
        else:
            names = set.intersection(*(set(part) for part in parts))
            arrays = {name: np.concatenate([part[name] for part in parts]) for name in names}
        ends = self._sensor.ends(tick) if self._history is not None else (scan.start, scan.end)
        return Measurement(arrays, count, ends, complete)

    def _scanner(self, turn: int) -> Scanner:
        """The scanner for the firings of a turn; see `Turns`."""
        number = self._turns.number(turn)
        found = self._scanners.get(number)
        if found is None:
            while len(self._scanners) >= self._turns.kept:
                self._scanners.popitem(last=False)
            found = self._scanners[number] = self._new_scanner(self._turns.pattern(turn))
        return found

    def _scan(self, shot: Shot) -> dict[str, np.ndarray]:
        """The channels of a shot that are requested now, and their "count"."""
        return self._scanner(shot.turn).scan(shot, self._sensor.channels())

    def _new_scanner(self, pattern: Pattern) -> Scanner:
        app, config = self._app, self._config
        weak = weakref.ref(app)
        return Scanner(
            pattern,
            lambda: cast_world(present_app(weak)),
            config,
            exclude=self._exclude,
            velocities=surface_velocities(app, self._path, config.output_frame_of_reference == "WORLD"),
            noise=Noise(config, pattern, app.seed, self._path) if app.fidelity.lidar_noise else None,
            optics=lambda: surface_optics(present_app(weak)),
            subrays=app.fidelity.lidar_subrays,
            tables=self._tables(),
        )

    def _tables(self) -> dict[str, SurfaceTable]:
        weak = weakref.ref(self._app)
        return {
            "matId": lambda: surface_materials(present_app(weak)),
            "objId": lambda: surface_ids(present_app(weak)),
            "classId": lambda: surface_classes(present_app(weak)),
        }

    def _frozen_scan(self, tick: Tick) -> _Turn:
        pose, turn = self._sensor.pose(tick.poses), tick.index - 1
        firings = len(self._scanner(turn).pattern)
        part = self._scan(Shot(slice(0, firings), pose, tick.poses, turn=turn))
        return _Turn([part], firings, pose, pose)

    def _on_device(self, turn: int) -> DeviceLidar | None:
        """The lidar on the App's device, if it can make whole frames of this turn there."""
        app, config = self._app, self._config
        if app.fidelity.device == HOST:
            return None
        from sensors.device.lidar import DeviceLidar
        from sensors.device.world import DeviceWorld

        number, world = self._turns.number(turn), cast_world(app)
        known = self._devices.get(number)
        if known is None or known[0] is not world:
            pattern, carrier = self._turns.pattern(turn), app.fabric.body_of(self._path)
            fits = (
                isinstance(world, DeviceWorld)
                and not (app.fidelity.lidar_noise or app.fidelity.lidar_subrays > 1)
                and not (config.skip_dropping_invalid_points or surface_optics(app).has_glass)
                and config.output_frame_of_reference == "SENSOR"
                and pattern.origins is None
                and (carrier is None or carrier in world.bodies)
            )
            lidar = None
            if fits and isinstance(world, DeviceWorld):
                tables = self._tables()
                lidar = DeviceLidar(world, pattern, config, surface_optics(app), self._exclude, tables, carrier)
            known = self._devices[number] = world, lidar
        return known[1]

    def _device_scan(self, device: DeviceLidar, tick: Tick) -> Measurement:
        pose, state = self._sensor.pose(tick.poses), tick.poses or self._app.fabric.capture()
        velocities = np.array(state.velocities(device.world.bodies)).reshape(-1, 6)
        arrays, count = device.scan(pose, state, velocities, self._sensor.channels())
        return Measurement(arrays, count, self._sensor.ends(tick) if self._history is not None else (pose, pose))

    def _continuous_scan(self, start: Fraction, end: Fraction, slices: list[tuple[int, slice]]) -> _Turn:
        assert self._bins is not None
        scan = _Turn()
        shots, scan.start, scan.end = self._bins.shots(start, end, slices)
        for shot in shots:
            shot.common = scan.end if self._sensor.compensates and shot.moves is not None else None
            scan.parts.append(self._scan(shot))
            scan.firings += shot.rows.stop - shot.rows.start
        return scan

    def _add(self, turn: int, rows: slice, pose: np.ndarray, poses: Any) -> None:
        scan = self._unfinished.setdefault(turn, _Turn())
        scan.parts.append(self._scan(Shot(rows, pose, poses, turn=turn)))
        scan.firings += rows.stop - rows.start

    def _partial_scan(self, tick: Tick) -> _Turn:
        start, end = self._sensor.interval(tick)
        slices = self._turns.slices(start, end)
        if self._bins is not None:
            return self._continuous_scan(start, end, slices)
        period, stamp, pose = self._turns.period, nanoseconds(start), self._sensor.pose(tick.poses)
        shots = [Shot(rows, pose, tick.poses, nanoseconds(turn * period) - stamp, turn=turn) for turn, rows in slices]
        return _Turn([self._scan(shot) for shot in shots], 0, pose, pose)
