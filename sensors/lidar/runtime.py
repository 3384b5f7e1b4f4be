"""A lidar at work: which firings each update and each tick looks at, and the frames they become."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.exact import nanoseconds
from graph.sim import settings as keys
from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule
from graph.sim.transforms import rigid_part
from sensors.channels import CHANNELS, AuxLevel, Demand
from sensors.frame import Frame, FramePose
from sensors.ids import has_prim
from sensors.raycast.shared import (
    cast_world,
    packed_id_map,
    surface_classes,
    surface_id_map,
    surface_ids,
    surface_labels,
    surface_materials,
    surface_optics,
)

from .bins import Bins
from .history import History, history_of
from .motion import surface_velocities
from .names import AUX_CHANNELS
from .noise import Noise
from .pattern import Pattern
from .prim import has_sensor_api, read_aux_level, read_config, read_exclude, read_tick_rate
from .receiver import Receiver
from .returns import Shot
from .scan import Scanner
from .turns import Turns

if TYPE_CHECKING:
    from graph.sim import App

PUBLISH_NORMALS = "/app/sensors/nv/lidar/publishNormals"
STABLE_IDS = "/rtx-transient/stableIds/enabled"


@dataclass(slots=True)
class _Turn:
    """A full scan in the making: slices of one turn, oldest first."""

    parts: list[dict[str, np.ndarray]] = field(default_factory=list)
    firings: int = 0
    start: np.ndarray = field(default_factory=lambda: np.eye(4))
    end: np.ndarray = field(default_factory=lambda: np.eye(4))


class LidarRuntime:
    """Implements `graph.sim.renderer.rendering.SensorRuntime` for an OmniLidar prim.

    A lidar whose tick rate equals its scan rate, with accumulateOutputs, gives whole scans: `frozen` casts the scan
    from the state of its tick, `update` casts each update's firings from that update's state and puts them together
    (the frame's poses are those at both ends of the scan),
    `continuous` fires each ray from where the sensor then was, at bodies where they then were (see `Bins`).
    Any other gives, in every update, the firings since its last output, from the state of that update or, `continuous`,
    of their own times; rates that differ warn `lidar-partial-scan`. Raises UserError for a prim that is no lidar or
    cannot be one.
    """

    def __init__(self, app: App, prim_path: str) -> None:
        self.path = prim_path
        self.demand = Demand()
        self._app = app
        self._authored: Any = None
        self.refresh()

    def refresh(self) -> bool:
        """Reads the prim anew; whether it describes another lidar than before. Scans begin anew if so.

        Raises UserError if the prim no longer describes one.
        """
        app, prim_path = self._app, self.path
        prim = app.stage.GetPrimAtPath(prim_path)
        if not prim or prim.GetTypeName() != "OmniLidar":
            raise UserError(f"{prim_path} is no OmniLidar prim; give the path of one")
        self._aux = read_aux_level(prim)
        self._known_demand = -1
        rate = read_tick_rate(prim, app.settings.rate(keys.BARE_LIDAR_TICK_RATE))
        if rate and not has_sensor_api(prim):
            rate = Fraction(0)
            app.warn(
                "sensor-api-missing",
                prim_path,
                "it has no OmniSensorAPI, so its tickRate does not count and it renders in every update; apply the "
                "schema (schemas: [OmniSensorAPI])",
            )
        config, _, exclude = authored = read_config(prim), rate, read_exclude(prim)
        if authored == self._authored:
            return False
        self._authored = authored
        self.config, self.rate = config, rate
        self.turns = Turns(config)
        if not len(self.turns.pattern(0)):
            raise UserError(f"{prim_path}: no firing lies in its valid azimuth window; widen validStart/EndAzimuthDeg")
        whole = self.rate == config.scan_rate_base_hz and config.accumulate_outputs
        self.schedule: TickSchedule | EveryUpdate
        if whole:
            self.schedule = TickSchedule(self.rate, app.rendering.moment, accumulates=True)
        else:
            self.schedule = EveryUpdate(app.rendering.moment, self.rate)
            self._warn_partial()
        self.wants_updates = whole and app.fidelity.lidar_motion == "update"
        self._compensates = config.output_motion_compensation_state == "COMPENSATED" and not self.wants_updates
        if self.wants_updates and config.output_motion_compensation_state == "COMPENSATED":
            app.warn(
                "motion-compensation-off",
                prim_path,
                "scans of lidar.motion update are NONCOMPENSATED; use continuous, or frozen",
            )
        self._bins = Bins(app, prim_path, self.turns) if app.fidelity.lidar_motion == "continuous" else None
        self._history: History | None = None
        if app.fidelity.lidar_motion == "update":
            self._history = history_of(app)
            self._history.keep(2 * self.turns.period)
        self._exclude = exclude
        self._scanners: OrderedDict[int, Scanner] = OrderedDict()
        self._channels: frozenset[str] = frozenset()
        self.reset()
        return True

    # -- demand ------------------------------------------------------------------------------------------------------

    @property
    def aux_level(self) -> AuxLevel:
        """The auxiliary level of the prim, as of the last `require` or reset."""
        return self._aux

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Asks for channels on behalf of an owner; those above the prim's aux level stay empty, with a warning.

        Of `optional` ones it computes what the level reaches, without a word.
        """
        self.demand.require(owner, channels, optional=optional, ignore_aux=ignore_aux)
        self._aux = read_aux_level(self._app.stage.GetPrimAtPath(self.path))
        for name, level in self.demand.above(self._aux, owner).items():
            self._app.warn(
                "aux-level-too-low",
                f"{self.path}.{name}",
                f"{name} stays empty: it needs aux_output_level {level.name}, the prim has {self._aux.name} "
                f"(attribute {AUX_CHANNELS})",
            )

    def release(self, owner: object) -> None:
        """Withdraws what an owner asked for."""
        self.demand.release(owner)

    def channels(self) -> frozenset[str]:
        """What is computed: the union of all demands, less what the aux level or a setting withholds."""
        if self._known_demand != self.demand.version:
            self._known_demand = self.demand.version
            wanted = self.demand.channels(self._aux)
            self._channels = wanted - self._withheld(wanted)
        return self._channels

    def has_stable_ids(self) -> bool:
        """Whether frames can hold object ids; says once why not, where somebody asks for them."""
        if self._app.settings.get(STABLE_IDS, False):
            return True
        self._app.warn("stable-ids-off", self.path, f"object ids stay empty; switch them on with --{STABLE_IDS}=true")
        return False

    def object_ids(self, *, resolve_all: bool = False) -> dict[int, str]:
        """128-bit object id -> prim path of what frames may hold; empty while stable ids are off.

        As documented without the copies of point instancers, which have no prim; resolve_all: with them, unless the
        setting idMapExtension of the profile is off.
        """
        if not self.has_stable_ids():
            return {}
        resolve_all = resolve_all and self._app.settings.get(keys.ID_MAP_EXTENSION)
        found = surface_id_map(self._app)
        return {number: path for number, path in found.items() if resolve_all or has_prim(path)}

    def packed_object_ids(self) -> np.ndarray | None:
        """All of it as a StableIdMap buffer, uint8, read-only; None while stable ids are off."""
        return packed_id_map(self._app) if self.has_stable_ids() else None

    def class_labels(self) -> dict[int, dict[str, str]]:
        """Number in the channel classId -> its labels, {taxonomy: label}."""
        return surface_labels(self._app)

    def _withheld(self, wanted: frozenset[str]) -> frozenset[str]:
        withheld = set()
        for name, setting, code in (
            ("hitNormals", PUBLISH_NORMALS, "normals-off"),
            ("objId", STABLE_IDS, "stable-ids-off"),
        ):
            if name in wanted and not self._app.settings.get(setting, False):
                self._app.warn(code, self.path, f"{name} stays empty; switch it on with --{setting}=true")
                withheld.add(name)
        return frozenset(withheld)

    # -- SensorRuntime -----------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Forgets frames and unfinished scans."""
        self._frames = 0
        self._turns: dict[int, _Turn] = {}
        self._known_demand = -1

    def advance(self, start: Fraction, end: Fraction, poses: Any) -> None:
        """Casts the firings of [start, end) from the state `poses`, for the scans they belong to."""
        oldest = end // self.turns.period - 1
        pose = self.pose(poses)
        for turn, rows in self.turns.slices(start, end, whole_turns=1):
            if turn >= oldest:
                self._add(turn, rows, pose, poses)
        for turn in [turn for turn in self._turns if turn < oldest]:
            del self._turns[turn]

    def render(self, tick: Tick) -> Frame | None:
        """The frame of a tick."""
        if isinstance(self.schedule, EveryUpdate):
            return self._partial_scan(tick)
        turn = tick.index - 1
        firings = len(self.turns.pattern(turn))
        if self._bins is not None:
            scan = self._continuous_scan(tick.start, tick.end, [(turn, slice(0, firings))])
        else:
            scan = self._turns.pop(turn, _Turn()) if self.wants_updates else self._frozen_scan(tick)
        if self._history is not None:
            scan.start, scan.end = self._history.ends(self.path, tick.start, tick.end)
        stamp = nanoseconds(tick.start)
        poses = FramePose(stamp, scan.start), FramePose(nanoseconds(tick.end), scan.end)
        return self._frame(stamp, poses, scan.parts, complete=scan.firings == firings)

    def pose(self, poses: Any = None) -> np.ndarray:
        """Sensor to world, (4, 4) float64, rigid, metres, in a state (None: now)."""
        pose = rigid_part(self._app.fabric.world_matrix(self.path, poses))
        pose[:3, 3] *= self._app.meters_per_unit
        return pose

    # -- inside ------------------------------------------------------------------------------------------------------

    def _scanner(self, turn: int) -> Scanner:
        """What casts the firings of a turn; see `Turns`."""
        number = self.turns.number(turn)
        found = self._scanners.get(number)
        if found is None:
            while len(self._scanners) >= self.turns.kept:
                self._scanners.popitem(last=False)
            found = self._scanners[number] = self._new_scanner(self.turns.pattern(turn))
        return found

    def _new_scanner(self, pattern: Pattern) -> Scanner:
        app, config = self._app, self.config
        return Scanner(
            pattern,
            lambda: cast_world(app),
            frame=config.output_frame_of_reference,
            exclude=self._exclude,
            keep_invalid=config.skip_dropping_invalid_points,
            velocities=surface_velocities(app, self.path, config.output_frame_of_reference == "WORLD"),
            receiver=Receiver(config),
            noise=Noise(config, pattern, app.seed, self.path) if app.fidelity.lidar_noise else None,
            optics=lambda: surface_optics(app),
            config=config,
            subrays=app.fidelity.lidar_subrays,
            tables={
                "matId": lambda: surface_materials(app),
                "objId": lambda: surface_ids(app),
                "classId": lambda: surface_classes(app),
            },
        )

    def _frozen_scan(self, tick: Tick) -> _Turn:
        pose, turn = self.pose(tick.poses), tick.index - 1
        scanner = self._scanner(turn)
        firings = len(scanner.pattern)
        part = scanner.scan(Shot(slice(0, firings), pose, tick.poses, turn=turn), self.channels())
        return _Turn([part], firings, pose, pose)

    def _continuous_scan(self, start: Fraction, end: Fraction, slices: list[tuple[int, slice]]) -> _Turn:
        assert self._bins is not None
        scan = _Turn()
        shots, scan.start, scan.end = self._bins.shots(start, end, slices)
        for shot in shots:
            shot.common = scan.end if self._compensates and shot.moves is not None else None
            scan.parts.append(self._scanner(shot.turn).scan(shot, self.channels()))
            scan.firings += shot.rows.stop - shot.rows.start
        return scan

    def _add(self, turn: int, rows: slice, pose: np.ndarray, poses: Any) -> None:
        scan = self._turns.setdefault(turn, _Turn())
        scan.parts.append(self._scanner(turn).scan(Shot(rows, pose, poses, turn=turn), self.channels()))
        scan.firings += rows.stop - rows.start

    def _partial_scan(self, tick: Tick) -> Frame:
        period = self.turns.period
        start = max(tick.start, tick.end - period)
        stamp = nanoseconds(start)
        slices = self.turns.slices(start, tick.end)
        if self._bins is not None:
            scan = self._continuous_scan(start, tick.end, slices)
        else:
            pose = self.pose(tick.poses)
            shots = [
                Shot(rows, pose, tick.poses, nanoseconds(turn * period) - stamp, turn=turn) for turn, rows in slices
            ]
            scan = _Turn([self._scanner(shot.turn).scan(shot, self.channels()) for shot in shots], 0, pose, pose)
            if self._history is not None:
                scan.start, scan.end = self._history.ends(self.path, start, tick.end)
        poses = FramePose(stamp, scan.start), FramePose(nanoseconds(tick.end), scan.end)
        return self._frame(stamp, poses, scan.parts, complete=False)

    def _frame(
        self, stamp: int, poses: tuple[FramePose, FramePose], parts: list[dict[str, np.ndarray]], *, complete: bool
    ) -> Frame:
        count = sum(int(part.pop("count")) for part in parts)
        if not parts:
            arrays = {name: CHANNELS[name].empty() for name in self.channels() if name in CHANNELS}
        elif len(parts) == 1:
            arrays = parts[0]
        else:
            names = set.intersection(*(set(part) for part in parts))
            arrays = {name: np.concatenate([part[name] for part in parts]) for name in names}
        frame = Frame(
            timestamp_ns=stamp,
            frame_id=self._frames,
            start=poses[0],
            end=poses[1],
            count=count,
            arrays=arrays,
            config=self.config,
            sensor_path=self.path,
            scan_complete=complete,
            aux_level=self._aux,
            coords=self.config.elements_coords_type,
            frame_of_reference=self.config.output_frame_of_reference,
            motion_compensation="COMPENSATED" if self._compensates else "NONCOMPENSATED",
            azimuth_offset_deg=self.config.start_azimuth_offset_deg,
        )
        self._frames += 1
        return frame

    def _warn_partial(self) -> None:
        config = self.config
        if self.rate != config.scan_rate_base_hz:
            self._app.warn(
                "lidar-partial-scan",
                self.path,
                f"tickRate is {float(self.rate):g} Hz, scanRateBaseHz is {float(config.scan_rate_base_hz):g} Hz: each "
                "update gives only the firings since the last; set tickRate = scanRateBaseHz for whole scans",
            )
