"""The shared runtime of sensors: demand, schedule, frames, stamps and poses. A modality adds only its model."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from graph.base.errors import RunError, UserError
from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.sim import settings as keys
from graph.sim.renderer.schedule import EveryUpdate, Tick, TickSchedule
from graph.sim.transforms import rigid_part

from .channels import CHANNELS, STABLE_IDS, AuxLevel, Demand
from .errors import SensorValueError
from .frame import Frame, FramePose
from .motion.history import History, history_of
from .prim import AUX_CHANNELS, has_sensor_api, read_aux_level, read_exclude, read_tick_rate
from .sensor_types import SensorType, sensor_type
from .surfaces.ids import has_prim

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Schedule
    from graph.sim.renderer.view import WorldView

Config = TypeVar("Config")


@dataclass(slots=True)
class Measurement:
    """The measurement of a model for one tick.

    arrays: channel -> rows, one for each element; `count` of them (None: as many as the first array has). The elements
    of an image are its pixels. ends: sensor to world, (4, 4) float64 [m], at both ends of the interval; None lets the
    runtime compute them. complete: False for a part of a scan. facts: as in `Frame`.
    """

    arrays: Mapping[str, np.ndarray]
    count: int | None = None
    ends: tuple[np.ndarray, np.ndarray] | None = None
    complete: bool = True
    facts: Mapping[str, Any] = field(default_factory=dict)


class SensorRuntime(ABC, Generic[Config]):
    """Base of sensors; implements `graph.sim.renderer.sensor.Sensor` for the prims of one type.

    A subclass sets its `type_name` and defines `read` (prim -> configuration) and `measure` (tick -> arrays of the
    requested channels). By default it renders at the ticks of its rate, or in every update at rate 0, and a frame shows
    one instant: the time of the update. `schedule_for`, `interval`, `configure`, `advance` and `reset` change that.
    Raises UserError for a prim that is not a valid sensor of this type.
    """

    type_name: ClassVar[str]
    side_axis: ClassVar[int] = 1
    """The axis of the sensor that points sideways: a parent that mirrors reverses this axis, not the viewing
    direction.
    """
    latency = Fraction(0)
    wants_updates = False
    coords = "NOT_APPLICABLE"

    def __init__(self, scene: WorldView, prim_path: str, resolution: tuple[int, int] = (1280, 720)) -> None:
        self.scene = scene
        """Its world, which a tick brings to what measures."""
        self.path = prim_path
        self.resolution = resolution
        """Width and height of its render product [px]; only image sensors use it."""
        self.demand = Demand()
        self._authored: Any = None
        self.refresh()

    # -- what a modality supplies ------------------------------------------------------------------------------------

    @abstractmethod
    def read(self, prim: Usd.Prim) -> Config:
        """The configuration that a prim describes. Raises UserError if it is not valid."""

    @abstractmethod
    def measure(self, tick: Tick) -> Measurement | None:
        """The measurement of a tick: the channels that `channels` gives, as far as the model has them."""

    @property
    def reach(self) -> float:
        """The range [m]: surfaces farther from the sensor have no effect on its frames."""
        return math.inf

    def configure(self) -> None:
        """Prepares measuring with a new `config`, `rate` and `exclude`."""

    def schedule_for(self, moment: Fraction) -> Schedule:
        """The schedule of a sensor that exists from `moment` [s] on."""
        return TickSchedule(self.rate, moment) if self.rate else EveryUpdate(moment)

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """Begin and end [s] of the interval that the frame of a tick covers."""
        return tick.time, tick.time

    def reference(self, tick: Tick) -> Fraction:
        """The time [s] for the messages of a tick's frame: the time of its pose, here that of the update."""
        return tick.time

    @property
    def rule(self) -> str:
        """The name of the rule for when frames come."""
        return "tick" if self.rate else "every update"

    def bare_rate(self) -> Fraction:
        """The tick rate [Hz] of a prim without an authored rate."""
        return Fraction(0)

    def advance(self, start: Fraction, end: Fraction, scene: WorldView) -> None:
        """Measures between ticks; called if `wants_updates`."""

    def reset(self) -> None:
        """Drops everything measured so far."""
        self._frames = 0
        self._known_demand = -1

    # -- life --------------------------------------------------------------------------------------------------------

    def refresh(self) -> bool:
        """Reads the prim again; True if it now describes another sensor, which then starts from its initial state.

        Raises UserError if the prim no longer describes a sensor.
        """
        prim = self.scene.stage.GetPrimAtPath(self.path)
        if not prim or prim.GetTypeName() != self.type_name:
            raise UserError(f"{self.path} is not a {self.type_name} prim; give the path of one")
        self._aux = read_aux_level(prim)
        self._known_demand = -1
        rate = self._read_rate(prim)
        authored = self.read(prim), rate, read_exclude(prim)
        if authored == self._authored:
            return False
        self._authored = authored
        self.config, self.rate, self.exclude = authored
        self.history: History | None = None
        self.frame_facts: Mapping[str, Any] = {}
        """Further fields of its frames, set by `configure`."""
        self._channels: frozenset[str] = frozenset()
        self._say_mirrored(prim)
        self.configure()
        self.schedule = self.schedule_for(self.scene.rendering.moment)
        self.reset()
        return True

    def render(self, tick: Tick) -> Frame | None:
        """The frame of a tick."""
        found = self.measure(tick)
        if found is None:
            return None
        start, end = self.interval(tick)
        stamp = nanoseconds(start)
        first, last = found.ends or self.ends(tick)
        count = found.count
        if count is None:
            count = len(next(iter(found.arrays.values()), ()))
        frame = Frame(
            timestamp_ns=stamp,
            frame_id=self._frames,
            start=FramePose(stamp, first),
            end=FramePose(nanoseconds(end), last),
            count=count,
            arrays=found.arrays,
            config=self.config,
            sensor_path=self.path,
            scan_complete=found.complete,
            aux_level=self._aux,
            modality=self.kind.modality,
            coords=self.coords,
            reference=self.reference(tick),
            facts=found.facts,
            **self.frame_facts,
        )
        self._frames += 1
        return frame

    def pose(self, poses: Any = None) -> np.ndarray:
        """Sensor to world, (4, 4) float64, rigid, metres, in a state (None: now). Raises RunError unless finite."""
        fabric = self.scene.fabric
        pose = rigid_part(fabric.world_matrix(self.path, poses), self.side_axis)
        pose[:3, 3] *= fabric.meters_per_unit
        if not np.isfinite(pose).all():
            raise RunError(f"{self.path}: its transform is not finite, so it sees nothing; correct its xformOps")
        return pose

    def ends(self, tick: Tick) -> tuple[np.ndarray, np.ndarray]:
        """The poses at both ends of a tick's interval: from the states of `look_back`, else from the tick's state."""
        if self.history is not None:
            return self.history.ends(self.path, *self.interval(tick))
        pose = self.pose(tick.poses)
        return pose, pose

    def look_back(self, span: Fraction) -> None:
        """Keeps the physics states of at least the last `span` [s]; see `History`."""
        self.history = history_of(self.scene)
        self.history.keep(span)

    # -- demand ------------------------------------------------------------------------------------------------------

    @property
    def kind(self) -> SensorType:
        """The registration of its prim type. Raises SensorValueError for an unregistered type."""
        kind = sensor_type(self.type_name)
        if kind is None:
            raise SensorValueError(f"{self.path}: no sensor type {self.type_name!r} is registered; register it first")
        return kind

    @property
    def aux_level(self) -> AuxLevel:
        """The auxiliary level of the prim, as read at the last `require` or reset."""
        return self._aux

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Requests channels for an owner; those above the prim's aux level stay empty, with a warning.

        Of `optional` channels it computes those that the type has and the level includes, without a warning. Raises
        ValueError for unknown channels, SensorValueError for channels of other sensor types.
        """
        channels, measures = frozenset(channels), self.kind.measures
        if foreign := sorted(channels & CHANNELS.keys() - measures):
            raise SensorValueError(
                f"{self.path}: {self.type_name} does not measure {', '.join(foreign)}; it measures "
                f"{', '.join(channel.name for channel in self.kind.channels)}"
            )
        self.demand.require(owner, channels, optional=measures.intersection(optional), ignore_aux=ignore_aux)
        self._aux = read_aux_level(self.scene.stage.GetPrimAtPath(self.path))
        for name, level in self.demand.above(self._aux, owner).items():
            self.scene.warn(
                "aux-level-too-low",
                f"{self.path}.{name}",
                f"{name} stays empty: it needs aux_output_level {level.name}, the prim has {self._aux.name} "
                f"(attribute {AUX_CHANNELS})",
            )

    def release(self, owner: object) -> None:
        """Withdraws an owner's request."""
        self.demand.release(owner)

    def channels(self) -> frozenset[str]:
        """The channels of a frame: the union of all requests, except those that the aux level or a setting excludes."""
        if self._known_demand != self.demand.version:
            self._known_demand = self.demand.version
            wanted = self.demand.channels(self._aux)
            self._channels = wanted - self._withheld(wanted)
        return self._channels

    def consumers(self) -> Mapping[str, Sequence[str]]:
        """Requested channel -> its owners as text, sorted."""
        return self.demand.consumers(self._aux)

    # -- what was seen -----------------------------------------------------------------------------------------------

    def has_stable_ids(self) -> bool:
        """Whether frames can hold object ids; if not, gives the reason once as a warning when they are requested."""
        if self.scene.settings.get(STABLE_IDS, False):
            return True
        self.scene.warn("stable-ids-off", self.path, f"object ids stay empty; switch them on with --{STABLE_IDS}=true")
        return False

    def object_ids(self, *, resolve_all: bool = False) -> dict[int, str]:
        """128-bit object id -> prim path for all objects that frames may show; empty while stable ids are off.

        Without the copies of point instancers, which have no prim, as documented; with `resolve_all` including them,
        unless the setting idMapExtension of the profile is off.
        """
        if not self.has_stable_ids():
            return {}
        from .raycast.shared import cast_world, surface_id_map

        resolve_all = resolve_all and self.scene.settings.get(keys.ID_MAP_EXTENSION)
        found = surface_id_map(cast_world(self.scene))
        return {number: path for number, path in found.items() if resolve_all or has_prim(path)}

    def packed_object_ids(self) -> np.ndarray | None:
        """The whole map as a StableIdMap buffer, uint8, read-only; None while stable ids are off."""
        if not self.has_stable_ids():
            return None
        from .raycast.shared import cast_world, packed_id_map

        return packed_id_map(cast_world(self.scene))

    def class_labels(self) -> dict[int, dict[str, str]]:
        """Number in the channel classId -> its labels, {taxonomy: label}."""
        from .raycast.shared import cast_world, surface_labels

        return surface_labels(cast_world(self.scene))

    # -- inside ------------------------------------------------------------------------------------------------------

    def _say_mirrored(self, prim: Usd.Prim) -> None:
        from graph.sim.usd import UsdGeom

        place = UsdGeom.Xformable(prim)
        if place and place.ComputeLocalToWorldTransform(0).GetDeterminant() < 0:
            self.scene.warn(
                "sensor-mirrored",
                self.path,
                f"a negative scale above it mirrors it; its local {'xyz'[self.side_axis]} axis is turned round, so "
                "that what it measures is not mirrored",
            )

    def _read_rate(self, prim: Usd.Prim) -> Fraction:
        rate = read_tick_rate(prim, self.bare_rate())
        if rate and not has_sensor_api(prim):
            self.scene.warn(
                "sensor-api-missing",
                self.path,
                "it has no OmniSensorAPI, so its tickRate does not count and it renders in every update; apply the "
                "schema (schemas: [OmniSensorAPI])",
            )
            return Fraction(0)
        return rate

    def _withheld(self, wanted: frozenset[str]) -> frozenset[str]:
        """The channels that a setting keeps empty, each with a warning."""
        withheld = set()
        for channel in (CHANNELS[name] for name in sorted(wanted)):
            if channel.setting and not self.scene.settings.get(channel.setting, False):
                self.scene.warn(
                    channel.setting_code,
                    self.path,
                    f"{channel.name} stays empty; switch it on with --{channel.setting}=true",
                )
                withheld.add(channel.name)
        return frozenset(withheld)
