"""The scans of a lidar: the firings of each update and tick are cast, and what they measure is joined."""

from __future__ import annotations

from collections import OrderedDict
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.sim.devices import plugin_of
from graph.sim.renderer.schedule import EveryUpdate, Tick
from sensors.channels import CHANNELS
from sensors.motion.velocities import Velocities
from sensors.raycast.shared import cast_world, surface_classes, surface_ids, surface_materials, surface_optics
from sensors.raycast.world import CastWorld
from sensors.runtime import Measurement

from .bins import Bins
from .noise import Noise
from .pattern import Pattern
from .returns import Shot, SurfaceTable, Targets
from .scan import Scanner

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView

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


class Scans:
    """The scans of one lidar as it is configured now: unfinished ones, and the scanners of its turns."""

    def __init__(self, lidar: LidarRuntime) -> None:
        self._path, self._exclude = lidar.path, lidar.exclude
        self._config, self._history, self._turns = lidar.config, lidar.history, lidar.turns
        fidelity = lidar.scene.fidelity
        self._bins = Bins(lidar) if fidelity.lidar_motion == "continuous" else None
        self._noise_seed = lidar.scene.seed if fidelity.lidar_noise else None
        self._subrays = fidelity.lidar_subrays
        self._scanners: OrderedDict[int, Scanner] = OrderedDict()
        self._unfinished: dict[int, _Turn] = {}
        self._devices: dict[int, tuple[CastWorld, Any]] = {}

    def reset(self) -> None:
        """Drops unfinished scans."""
        self._unfinished = {}

    def advance(self, lidar: LidarRuntime, start: Fraction, end: Fraction, scene: WorldView) -> None:
        """Casts the firings in [start, end) with the present state, for the scans they belong to, if they are read."""
        wanted = lidar.channels()
        if not wanted:
            self._unfinished.clear()
            return
        oldest = end // self._turns.period - 1
        pose, targets = lidar.pose(), self._targets(scene, cast_world(scene), wanted)
        for turn, rows in self._turns.slices(start, end, whole_turns=1):
            if turn >= oldest:
                scan = self._unfinished.setdefault(turn, _Turn())
                scan.parts.append(self._scan(Shot(rows, pose, turn=turn), targets))
                scan.firings += rows.stop - rows.start
        for turn in [turn for turn in self._unfinished if turn < oldest]:
            del self._unfinished[turn]

    def measure(self, lidar: LidarRuntime, tick: Tick) -> Measurement:
        """The scan of a tick, or the part fired since the last one. Without requested channels: empty, and no cast."""
        wanted = lidar.channels()
        if wanted:
            return self._cast(lidar, tick, wanted)
        pose = lidar.pose(tick.poses)
        ends = (pose, pose) if self._bins is None or tick.held else self._bins.ends(*lidar.interval(tick))
        return self._measured(_Turn([], 0, *ends), lidar, tick, complete=lidar.whole)

    def _cast(self, lidar: LidarRuntime, tick: Tick, wanted: frozenset[str]) -> Measurement:
        scene = tick.scene
        world = cast_world(scene)
        targets = self._targets(scene, world, wanted)
        turn = tick.time // self._turns.period if tick.held else tick.index - 1
        if isinstance(lidar.schedule, EveryUpdate) and not tick.held:
            return self._measured(self._partial_scan(lidar, tick, targets), lidar, tick, complete=False)
        firings = len(self._turns.pattern(turn))
        if tick.held:
            scan = self._still_scan(lidar, tick, turn, targets)
        elif self._bins is not None:
            scan = self._continuous_scan(lidar, tick.start, tick.end, [(turn, slice(0, firings))], targets)
        elif lidar.wants_updates:
            scan = self._unfinished.pop(turn, _Turn())
        elif (device := self._on_device(scene, world, turn)) is not None:
            return self._device_scan(device, lidar, tick, wanted)
        else:
            scan = self._still_scan(lidar, tick, turn, targets)
        return self._measured(scan, lidar, tick, complete=scan.firings == firings)

    def _measured(self, scan: _Turn, lidar: LidarRuntime, tick: Tick, *, complete: bool) -> Measurement:
        parts = scan.parts
        count = sum(int(part.pop("count")) for part in parts)
        if not parts:
            arrays = {name: CHANNELS[name].empty() for name in lidar.channels() if name in CHANNELS}
        elif len(parts) == 1:
            arrays = parts[0]
        else:
            names = set.intersection(*(set(part) for part in parts))
            arrays = {name: np.concatenate([part[name] for part in parts]) for name in names}
        ends = (scan.start, scan.end) if tick.held or self._history is None else lidar.ends(tick)
        return Measurement(arrays, count, ends, complete)

    def _targets(self, scene: WorldView, world: CastWorld, wanted: frozenset[str]) -> Targets:
        """What beams may meet, for the channels that are requested now."""
        in_world = self._config.output_frame_of_reference == "WORLD"
        velocities = Velocities(scene.fabric, world, None if in_world else self._path)
        return Targets(wanted, world, surface_optics(world), velocities, _tables(world))

    def _scan(self, shot: Shot, targets: Targets) -> dict[str, np.ndarray]:
        """The channels of a shot, and their "count", by the scanner for the firings of its turn; see `Turns`."""
        number = self._turns.number(shot.turn)
        found = self._scanners.get(number)
        if found is None:
            while len(self._scanners) >= self._turns.kept:
                self._scanners.popitem(last=False)
            found = self._scanners[number] = self._new_scanner(self._turns.pattern(shot.turn))
        return found.scan(shot, targets)

    def _new_scanner(self, pattern: Pattern) -> Scanner:
        seed = self._noise_seed
        noise = None if seed is None else Noise(self._config, pattern, seed, self._path)
        return Scanner(pattern, self._config, exclude=self._exclude, noise=noise, subrays=self._subrays)

    def _on_device(self, scene: WorldView, world: CastWorld, turn: int) -> Any:
        """The lidar on the scene's device; None if whole frames of this turn are made on the processor."""
        if world.device is None:
            return None
        fidelity, config = scene.fidelity, self._config
        number = self._turns.number(turn)
        known = self._devices.get(number)
        if known is None or known[0] is not world:
            pattern, optics = self._turns.pattern(turn), surface_optics(world)
            carrier = scene.fabric.body_of(self._path)
            fits = (
                not (fidelity.lidar_noise or fidelity.lidar_subrays > 1)
                and not (config.skip_dropping_invalid_points or optics.has_glass)
                and config.output_frame_of_reference == "SENSOR"
                and pattern.origins is None
                and (carrier is None or carrier in world.bodies)
            )
            lidar = None
            if fits:
                made = plugin_of(fidelity.device).DeviceLidar
                lidar = made(world, pattern, config, optics, self._exclude, _tables(world), carrier)
            known = self._devices[number] = world, lidar
        return known[1]

    def _device_scan(self, device: Any, lidar: LidarRuntime, tick: Tick, wanted: frozenset[str]) -> Measurement:
        pose, state = lidar.pose(tick.poses), tick.poses or tick.scene.fabric.capture()
        velocities = np.array(state.velocities(device.world.bodies)).reshape(-1, 6)
        arrays, count = device.scan(pose, state, velocities, wanted)
        return Measurement(arrays, count, lidar.ends(tick) if self._history is not None else (pose, pose))

    def _still_scan(self, lidar: LidarRuntime, tick: Tick, turn: int, targets: Targets) -> _Turn:
        """A whole turn in one state of the world."""
        firings, pose = len(self._turns.pattern(turn)), lidar.pose(tick.poses)
        part = self._scan(Shot(slice(0, firings), pose, tick.poses, turn=turn), targets)
        return _Turn([part], firings, pose, pose)

    def _continuous_scan(
        self, lidar: LidarRuntime, start: Fraction, end: Fraction, slices: list[tuple[int, slice]], targets: Targets
    ) -> _Turn:
        assert self._bins is not None
        scan = _Turn()
        shots, scan.start, scan.end = self._bins.shots(targets.world, start, end, slices)
        for shot in shots:
            shot.common = scan.end if lidar.compensates and shot.moves is not None else None
            scan.parts.append(self._scan(shot, targets))
            scan.firings += shot.rows.stop - shot.rows.start
        return scan

    def _partial_scan(self, lidar: LidarRuntime, tick: Tick, targets: Targets) -> _Turn:
        start, end = lidar.interval(tick)
        slices = self._turns.slices(start, end)
        if self._bins is not None:
            return self._continuous_scan(lidar, start, end, slices, targets)
        period, stamp, pose = self._turns.period, nanoseconds(start), lidar.pose(tick.poses)
        shots = [Shot(rows, pose, tick.poses, nanoseconds(turn * period) - stamp, turn=turn) for turn, rows in slices]
        return _Turn([self._scan(shot, targets) for shot in shots], 0, pose, pose)


def _tables(world: CastWorld) -> dict[str, SurfaceTable]:
    return {
        "matId": partial(surface_materials, world),
        "objId": partial(surface_ids, world),
        "classId": partial(surface_classes, world),
    }
