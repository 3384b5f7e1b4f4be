"""What the sensors of a run saw: of each frame the channels that errors are computed from.

Readings are matched by identity, not by their place in an array: lidar returns by turn, tick, emitter and echo; frames
by the time of their tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.exact import nanoseconds
from graph.sim.renderer.wrapper import unwrapped
from sensors.camera import names as cameras
from sensors.camera.channels import INSTANCE
from sensors.channels import Consumer
from sensors.gmo import ElementFlags
from sensors.lidar import names as lidars
from sensors.radar import names as radars

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from sensors.frame import Frame

MOST_READINGS = 4_000_000
"""Returns or pixels kept of a sensor; of more only every n-th tick or pixel is."""
BEFORE_RENDERING = -1000

LIDAR, RADAR, CAMERA, OTHER = "lidar", "radar", "camera", "other"
SORTS = {lidars.PRIM_TYPE: LIDAR, radars.PRIM_TYPE: RADAR, cameras.PRIM_TYPE: CAMERA}
"""The kind of a sensor by the type of its prim."""
_NEEDED = {
    LIDAR: ("distance", "scalar", "flags", "timeOffsetNs", "tickId", "emitterId", "echoId", "objId"),
    RADAR: ("distance", "azimuth", "elevation", "rv_ms"),
    CAMERA: ("distance_to_image_plane", INSTANCE),
    OTHER: (),
}
_IF_COMPUTED = {LIDAR: ("velocities", "xyz"), CAMERA: ("rgb",)}
"""Channels that are kept too if something in the run reads them."""


@dataclass(slots=True)
class Reading:
    """One frame. key: the time [s] of its tick, the same in every run. until_ns: the latest state it shows.

    stamp_ns: of its messages. arrays: by channel; of lidars also `firing`, the identity of each return, and `prim`,
    that of what it hit, both int64.
    """

    key: Fraction
    until_ns: int
    stamp_ns: int
    arrays: dict[str, NDArray[Any]]


@dataclass(slots=True)
class Readings:
    """The frames of one sensor. gates: of radars, the size of a cell: range [m], velocity [m/s], azimuth [rad].

    rate: of its ticks [Hz]; 0: one an update. pattern: of lidars, the turns a second and the rays of a turn: returns of
    other patterns have other identities.
    """

    path: str
    kind: str
    frames: list[Reading] = field(default_factory=list)
    gates: tuple[float, float, float] = (1.0, 1.0, 0.1)
    rate: Fraction = Fraction(0)
    pattern: tuple[Fraction, int] | None = None

    def before(self, horizon: float) -> list[Reading]:
        """The frames that show nothing after `horizon` [s]."""
        return [frame for frame in self.frames if frame.until_ns <= horizon * 1e9 + 1]


class ReadingLog:
    """Records the frames of every render product of an App whose sensor has readers; created products join.

    duration: about how long it will run [s].
    """

    def __init__(self, app: App, duration: float) -> None:
        self.sensors: dict[str, Readings] = {}
        """What was recorded, by the path of the render product."""
        self._app, self._duration = app, duration
        app.on("render", self._follow_new, BEFORE_RENDERING)

    def _follow_new(self) -> None:
        for product in self._app.rendering.products.values():
            if product.path not in self.sensors and product.camera_path and product.sensor.channels():
                self._follow(product)

    def _follow(self, product: RenderProduct) -> None:
        sensor: Any = unwrapped(product.sensor)
        sort = SORTS.get(sensor.type_name, OTHER)
        kept = self.sensors[product.path] = Readings(product.camera_path, sort)
        names = {*_NEEDED[sort], *(set(_IF_COMPUTED.get(sort, ())) & sensor.channels())}
        if names:
            sensor.require(Consumer("graph trade"), names, ignore_aux=True)
        if sort == RADAR:
            scan = sensor.config.scans[0]
            velocity = scan.velocities(scan.cycles[0]).width
            kept.gates = scan.ranges().width, velocity, math.asin(min(1.0, scan.azimuths().width))
        if sort == LIDAR:
            kept.pattern = sensor.config.scan_rate_base_hz, sensor.config.rays_per_scan
        rate = kept.rate = Fraction(sensor.rate)
        on_grid = rate and (sort != LIDAR or product.sensor.schedule.accumulates)
        reduce = _REDUCERS[sort](sensor, self._duration)

        def keep(frame: Frame) -> None:
            stamp = nanoseconds(frame.reference)
            shown = stamp if sort == OTHER or frame.one_instant else frame.end.timestamp_ns
            key = Fraction(frame.timestamp_ns, 10**9)
            if on_grid:  # a turn of a lidar begins a period before its tick
                begun = (frame.timestamp_ns + 2) * rate.numerator // (rate.denominator * 10**9)
                key = (begun + (sort == LIDAR)) / rate
            kept.frames.append(Reading(key, shown, stamp, reduce(frame)))

        product.writers.append(keep)


Reduce = Callable[["Frame"], dict[str, NDArray[Any]]]


def _of_lidar(sensor: Any, duration: float) -> Reduce:
    turns: Fraction = sensor.config.scan_rate_base_hz
    total = sensor.config.rays_per_scan * float(turns) * duration
    every = max(1, math.ceil(total / MOST_READINGS))

    def reduce(frame: Frame) -> dict[str, NDArray[Any]]:
        kept = (frame.channel("flags") & int(ElementFlags.VALID)) != 0
        ticks = frame.channel("tickId").astype(np.int64)
        if every > 1:
            kept &= ticks % every == 0
        # Two ns against rounding: the first firing of a turn belongs to it.
        fired = frame.timestamp_ns + 2 + frame.channel("timeOffsetNs").astype(np.int64)
        turn = fired * turns.numerator // (turns.denominator * 10**9)
        emitter, echo = frame.channel("emitterId").astype(np.int64), frame.channel("echoId").astype(np.int64)
        arrays: dict[str, NDArray[Any]] = {
            "firing": (turn << 44 | ticks << 24 | emitter << 4 | echo)[kept],
            "distance": frame.channel("distance")[kept],
            "scalar": frame.channel("scalar")[kept],
            "prim": np.bitwise_xor.reduce(np.ascontiguousarray(frame.channel("objId")).view(np.int64), axis=1)[kept],
        }
        if frame.has("velocities"):
            points = frame.xyz
            lengths = np.maximum(np.sqrt((points * points).sum(axis=1)), 1e-9)
            arrays["radial"] = ((frame.channel("velocities") * points).sum(axis=1) / lengths)[kept]
        return arrays

    return reduce


def _of_radar(sensor: Any, duration: float) -> Reduce:
    return lambda frame: {name: frame.channel(name) for name in _NEEDED[RADAR]}


def _of_camera(sensor: Any, duration: float) -> Reduce:
    width, height = sensor.config.size
    rate = float(sensor.rate) or 60.0
    every = max(1, math.ceil(math.sqrt(width * height * rate * duration / MOST_READINGS)))
    names = (*_NEEDED[CAMERA], *_IF_COMPUTED[CAMERA])
    return lambda frame: {name: frame.channel(name)[::every, ::every].copy() for name in names if frame.has(name)}


def _of_other(sensor: Any, duration: float) -> Reduce:
    return lambda frame: {}


_REDUCERS: dict[str, Callable[[Any, float], Reduce]] = {
    LIDAR: _of_lidar,
    RADAR: _of_radar,
    CAMERA: _of_camera,
    OTHER: _of_other,
}
