"""Every per-element channel that a sensor can compute: dtype, width, unit, and the auxiliary level that includes it.

`CHANNELS` holds the channels of point sensors; a sensor type adds its own (`sensors.sensor_types`).
"""

from __future__ import annotations

import enum
from collections.abc import Iterable

import numpy as np

from graph.base.records import dataclass


class AuxLevel(enum.IntEnum):
    """How much auxiliary data a sensor gives; each level includes the ones below it."""

    NONE = 0
    BASIC = 1
    EXTRA = 2
    FULL = 3


PUBLISH_NORMALS = "/app/sensors/nv/lidar/publishNormals"
STABLE_IDS = "/rtx-transient/stableIds/enabled"


@dataclass(frozen=True, slots=True)
class Channel:
    """One array of a frame: `width` values of `dtype` per element, available from aux level `level` on.

    setting: a setting that must be true, otherwise the channel stays empty, with the warning `setting_code`. image: the
    array is (height, width) or (height, width, n), with the first row at the top.
    """

    name: str
    dtype: np.dtype[np.generic]
    width: int = 1
    level: AuxLevel = AuxLevel.NONE
    unit: str = ""
    doc: str = ""
    setting: str = ""
    setting_code: str = ""
    image: bool = False

    def empty(self) -> np.ndarray:
        """An array of no elements, with the channel's dtype and shape."""
        none = (0, 0) if self.image else (0,)
        return np.empty((*none, self.width) if self.width > 1 else none, self.dtype)


def _channel(
    name: str, dtype: str, level: AuxLevel, unit: str, doc: str, width: int = 1, setting: str = "", code: str = ""
) -> tuple[str, Channel]:
    return name, Channel(name, np.dtype(dtype), width, level, unit, doc, setting, code)


CHANNELS: dict[str, Channel] = dict(
    (
        _channel("xyz", "<f4", AuxLevel.NONE, "m", "hit point, Cartesian, in the frame of reference of the output", 3),
        _channel("azimuth", "<f4", AuxLevel.NONE, "deg", "azimuth of the point, -180 to 180, left of +x positive"),
        _channel("elevation", "<f4", AuxLevel.NONE, "deg", "elevation of the point, up from the xy plane"),
        _channel("distance", "<f4", AuxLevel.NONE, "m", "distance of the point"),
        _channel("scalar", "<f4", AuxLevel.NONE, "", "normalised intensity: reflectance times cosine of incidence"),
        _channel("timeOffsetNs", "<i4", AuxLevel.NONE, "ns", "firing time after the frame's timestamp"),
        _channel("flags", "u1", AuxLevel.NONE, "", "ElementFlags; VALID marks an element with a return"),
        _channel("emitterId", "<u4", AuxLevel.BASIC, "", "index of the emitter"),
        _channel("channelId", "<u4", AuxLevel.BASIC, "", "channel of the emitter"),
        _channel("tickId", "<u4", AuxLevel.BASIC, "", "index of the firing tick within the scan"),
        _channel("echoId", "u1", AuxLevel.BASIC, "", "0 for the first return of a ray, 1 for the second"),
        _channel("tickStates", "u1", AuxLevel.BASIC, "", "index of the emitter state fired on the tick"),
        _channel("matId", "<u4", AuxLevel.EXTRA, "", "encoded non-visual material"),
        _channel(
            "objId", "u1", AuxLevel.EXTRA, "", "128-bit stable id, little-endian", 16, STABLE_IDS, "stable-ids-off"
        ),
        _channel(
            *("hitNormals", "<f4", AuxLevel.FULL, "", "unit surface normal, facing the sensor", 3),
            *(PUBLISH_NORMALS, "normals-off"),
        ),
        _channel("velocities", "<f4", AuxLevel.FULL, "m/s", "velocity of the hit point", 3),
        _channel("ring", "<u2", AuxLevel.NONE, "", "line of the emitter, from 0 upwards by elevation; ours"),
        _channel("column", "<u4", AuxLevel.NONE, "", "place along its line, tick by tick; ours"),
        _channel("beamAzimuth", "<f4", AuxLevel.NONE, "deg", "azimuth in the sensor's frame at the firing; ours"),
        _channel("beamDistance", "<f4", AuxLevel.NONE, "m", "distance in the sensor's frame at the firing; ours"),
        _channel("classId", "<u4", AuxLevel.NONE, "", "semantic class of what was hit: 0 nothing, 1 no label; ours"),
    )
)

POINT_CHANNELS = tuple(CHANNELS.values())
"""The channels of point sensors."""

RADIAL_VELOCITY = Channel(
    "rv_ms", np.dtype("<f4"), level=AuxLevel.BASIC, unit="m/s", doc="rate of the range: positive recedes"
)
CHANNELS[RADIAL_VELOCITY.name] = RADIAL_VELOCITY

AUXILIARY = frozenset(name for name, channel in CHANNELS.items() if channel.level > AuxLevel.NONE)
"""The point channels that need an auxiliary level."""


def check_channels(names: Iterable[str]) -> frozenset[str]:
    """The names as a set. Raises ValueError with the unknown ones."""
    wanted = frozenset(names)
    if unknown := sorted(wanted - CHANNELS.keys()):
        raise ValueError(f"no channel {', '.join(unknown)}; there are {', '.join(CHANNELS)}")
    return wanted


class Consumer:
    """A consumer of channels; every instance is another owner, also under the same name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class _Request:
    channels: frozenset[str]
    optional: frozenset[str]
    ignore_aux: bool

    def granted(self, level: AuxLevel) -> frozenset[str]:
        """The channels that are computed for it at this auxiliary level."""
        wanted = self.channels | self.optional
        return wanted if self.ignore_aux else frozenset(name for name in wanted if CHANNELS[name].level <= level)


class Demand:
    """The requests of one sensor's consumers; the sensor computes the union over all owners."""

    def __init__(self) -> None:
        self._owners: dict[object, _Request] = {}
        self.version = 0

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        """Requests channels for an owner (any hashable); a second request replaces the first.

        optional: further channels, as far as the prim's auxiliary level includes them. ignore_aux: also channels above
        that level. Raises ValueError for unknown channel names.
        """
        self._owners[owner] = _Request(check_channels(channels), check_channels(optional), ignore_aux)
        self.version += 1

    def release(self, owner: object) -> None:
        """Withdraws an owner's request, if any."""
        if self._owners.pop(owner, None) is not None:
            self.version += 1

    def channels(self, level: AuxLevel) -> frozenset[str]:
        """The channels to compute at this auxiliary level: the union, without those above the level."""
        return frozenset().union(*(request.granted(level) for request in self._owners.values()))

    def above(self, level: AuxLevel, owner: object = None) -> dict[str, AuxLevel]:
        """Required channels (of all owners, or of one) above the level: each with the level it needs."""
        return {
            name: CHANNELS[name].level
            for asking, request in self._owners.items()
            if owner is None or asking == owner
            for name in sorted(request.channels)
            if not request.ignore_aux and CHANNELS[name].level > level
        }

    def consumers(self, level: AuxLevel = AuxLevel.NONE) -> dict[str, list[str]]:
        """Channel -> its owners as text, sorted, for `graph explain`; optional channels only up to the level."""
        listing: dict[str, list[str]] = {}
        for owner, request in self._owners.items():
            for name in request.channels | request.granted(level):
                listing.setdefault(name, []).append(str(owner))
        return {name: sorted(listing[name]) for name in CHANNELS if name in listing}
