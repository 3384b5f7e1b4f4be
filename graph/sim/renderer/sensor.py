"""The sensor protocol: everything that schedulers, products, annotators, writers, nodes and commands use of a sensor.

`sensors.runtime.SensorRuntime` is the shared implementation; a `wrapper.SensorWrapper` changes parts of a sensor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Protocol

from .schedule import EveryUpdate, Tick, TickSchedule

if TYPE_CHECKING:
    import numpy as np

    from .view import WorldView

Schedule = TickSchedule | EveryUpdate


class SensorFrame(Protocol):
    """What the renderer uses of a frame; everything else is between the sensor and its readers."""

    @property
    def count(self) -> int:
        """How many elements it holds: points, pixels, samples."""

    @property
    def timestamp_ns(self) -> int:
        """Start of the interval it covers, on the simulation clock [ns]."""

    @property
    def reference(self) -> Fraction:
        """The time [s] for its messages: that of its pose, unless a setting says otherwise."""


class Sensor(Protocol):
    """One sensor of a render product.

    Poses are captured states of the world (`graph.sim.state.poses.Poses`); None means the present state.
    """

    # -- identity ----------------------------------------------------------------------------------------------------

    @property
    def path(self) -> str:
        """Its prim."""

    @property
    def type_name(self) -> str:
        """The prim type for which it is registered; "" for a product without a sensor."""

    # -- schedule ----------------------------------------------------------------------------------------------------

    @property
    def schedule(self) -> Schedule:
        """When it renders, and how many ticks were missed."""

    @property
    def rate(self) -> Fraction:
        """The tick rate [Hz]; 0 renders in every update."""

    @property
    def rule(self) -> str:
        """The name of the rule for when frames come, as in `graph explain`."""

    @property
    def wants_updates(self) -> bool:
        """Whether `advance` is called in every update in which the time advanced, before its ticks are rendered."""

    @property
    def latency(self) -> Fraction:
        """How long after the end of a tick's interval its frame is delivered [s]."""

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        """Begin and end [s] of what the frame of a tick covers; its stamp is the begin."""

    # -- demand ------------------------------------------------------------------------------------------------------

    @property
    def aux_level(self) -> IntEnum:
        """The auxiliary level of the prim."""

    @property
    def coords(self) -> str:
        """The meaning of x, y, z of its points: SPHERICAL or CARTESIAN; NOT_APPLICABLE for a sensor without points."""

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Requests channels for an owner; a second request replaces the first.

        optional: further channels, as far as the auxiliary level includes them. ignore_aux: also those above it. Raises
        ValueError for channels that the sensor does not have.
        """

    def release(self, owner: object) -> None:
        """Withdraws an owner's request, if any."""

    def channels(self) -> frozenset[str]:
        """The channels to compute: the union of all requests, except those that the auxiliary level or a setting
        excludes.
        """

    def consumers(self) -> Mapping[str, Sequence[str]]:
        """Requested channel -> its owners as text, sorted."""

    # -- life --------------------------------------------------------------------------------------------------------

    def refresh(self) -> bool:
        """Reads the prim again; True if it now describes another sensor, which then starts from its initial state.

        Raises UserError if the prim no longer describes a sensor.
        """

    def reset(self) -> None:
        """Drops everything measured so far."""

    def advance(self, start: Fraction, end: Fraction, scene: WorldView) -> None:
        """Measures what happens in [start, end) [s] with the present state, for later frames."""

    def render(self, tick: Tick) -> SensorFrame | None:
        """The frame of a tick, or None if there is nothing to deliver."""

    def pose(self, poses: Any = None) -> np.ndarray:
        """Sensor to world, (4, 4) float64, rigid, column vectors [m], in a state."""

    # -- what was seen -----------------------------------------------------------------------------------------------

    def has_stable_ids(self) -> bool:
        """Whether frames can hold object ids; warns once if not."""

    def object_ids(self, *, resolve_all: bool = False) -> dict[int, str]:
        """128-bit object id -> prim path for objects in frames; resolve_all: with copies that have no prim."""

    def packed_object_ids(self) -> np.ndarray | None:
        """The same as a StableIdMap buffer, (size,) uint8, read-only; None without object ids."""

    def class_labels(self) -> dict[int, dict[str, str]]:
        """Number in the channel classId -> its labels, {taxonomy: label}."""
