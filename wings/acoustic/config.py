"""What an acoustic sensor is: its mounts, firing sequence, fan and wave, as one immutable value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graph.base import exact
from graph.base.errors import UserError
from graph.base.limits import check
from graph.base.records import dataclass
from sensors.prim import value_of

from .names import FIRING_API, FIRING_PREFIX, GROUP_API, GROUP_PREFIX, MOUNT_API, MOUNT_PREFIX, PREFIX

if TYPE_CHECKING:
    from pxr import Usd

SAMPLES = 320
"""Samples of a signal way, as observed of the original: 32.8 ms and 5.6 m with the default sampleDuration."""

MOST_SECONDS = 1.0
"""The longest pulse and sample; a signal way of such samples lasts minutes."""

MOST_WAYS = 255
"""Mounts, and signal ways of a frame."""

IGNORED = (
    *("closeRange", "closeRangeDecay", "closeDirectAmplBase", "closeDirectAmpl"),
    *("closeIndirectAmplBase", "closeIndirectAmpl", "gainCoeffs", "directivityCoeffs"),
    *("enableInterference", "bandwidth", "traceTreeDepth"),
)
"""Attributes whose meaning is not public, or that this model does without."""

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Mount:
    """A place that sends and hears. position [m]; rotation [deg] about x, then y, then z: both in the sensor's axes."""

    position: Vector = (0.0, 0.0, 0.0)
    rotation: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Way:
    """A signal way: the mounts that send and hear, by number, its channel, and when the sender fires [ns]."""

    sender: int
    receiver: int
    channel: int
    time_ns: int


@dataclass(frozen=True, slots=True)
class AcousticConfig:
    """An acoustic sensor as its prim describes it.

    Angles in degrees, frequencies in Hz, times in seconds, lengths in metres. spans: the fan across and up. counts: its
    rays across and up. noise: least and largest amplitude added to a sample.
    """

    mounts: tuple[Mount, ...]
    ways: tuple[Way, ...]
    spans: tuple[float, float]
    counts: tuple[int, int]
    center_frequency: float
    pulse_duration: float
    pulse_power: float
    sample_duration: float
    membrane_diameter: float
    noise: tuple[float, float]

    @property
    def samples(self) -> int:
        """Samples of each signal way."""
        return SAMPLES

    @property
    def duration_ns(self) -> int:
        """How long the firing sequence is recorded [ns]."""
        return max(way.time_ns for way in self.ways) + round(SAMPLES * self.sample_duration * 1e9)


def read_config(prim: Usd.Prim) -> AcousticConfig:
    """The configuration a prim describes; mounts and groups come in the order of their instance names.

    Without an event in a firing sequence, mount 0 sends at 0 s on channel 0 and group 0 listens. Raises UserError
    naming the prim and the attribute for values that no acoustic sensor can have.
    """
    mounts = tuple(
        Mount(*(_vector(prim, f"{MOUNT_PREFIX}{name}:{part}") for part in ("position", "rotation")))
        for name in _instances(prim, MOUNT_API)
    ) or (Mount(),)
    if len(mounts) > MOST_WAYS:
        raise UserError(f"{prim.GetPath()}: it has {len(mounts)} mounts; {MOST_WAYS} are the most")
    spans = (_number(prim, "azSpanDeg", most=180), _number(prim, "elSpanDeg", most=180))
    density = _number(prim, "raysPerDeg")
    counts = (max(1, round(spans[0] * density)), max(1, round(spans[1] * density)))
    rays = counts[0] * counts[1]
    check("acoustic.rays", rays, f"{prim.GetPath()}: a mount casts {rays:,} rays")
    noise = _number(prim, "noiseMin", least=0), _number(prim, "noiseMax", least=0)
    if noise[1] < noise[0] and prim.GetAttribute(f"{PREFIX}noiseMax").HasAuthoredValue():
        _fail(prim, f"{PREFIX}noiseMax", f"give at least noiseMin, {noise[0]:g}")
    return AcousticConfig(
        mounts,
        _ways(prim, len(mounts)),
        spans,
        counts,
        _number(prim, "centerFrequency"),
        _number(prim, "pulseDuration", most=MOST_SECONDS),
        _number(prim, "pulsePower"),
        _number(prim, "sampleDuration", most=MOST_SECONDS),
        _number(prim, "membraneDiameter", least=0),
        (noise[0], max(noise)),
    )


def _ways(prim: Usd.Prim, mounts: int) -> tuple[Way, ...]:
    groups = []
    for name in _instances(prim, GROUP_API):
        attribute = f"{GROUP_PREFIX}{name}:receiverIndices"
        groups.append(_integers(prim, attribute))
        if any(index >= mounts for index in groups[-1]):
            _fail(prim, attribute, f"mounts are numbered from 0 to {mounts - 1}")
    groups = groups or [(0,)]
    ways = []
    for time, sender, group, channel in _events(prim):
        where = f"{FIRING_PREFIX}*"
        if sender >= mounts:
            raise UserError(f"{prim.GetPath()}.{where}:txSensorId names mount {sender}; it has 0 to {mounts - 1}")
        if group >= len(groups):
            raise UserError(f"{prim.GetPath()}.{where}:rxGroupId names group {group}; it has 0 to {len(groups) - 1}")
        ways += [Way(sender, receiver, channel, time) for receiver in groups[group]]
    if not ways:
        raise UserError(f"{prim.GetPath()}: no mount listens; give its rxGroup receiverIndices")
    if len(ways) > MOST_WAYS:
        raise UserError(f"{prim.GetPath()}: its firing sequence has {len(ways)} signal ways; {MOST_WAYS} are the most")
    return tuple(ways)


def _events(prim: Usd.Prim) -> list[tuple[int, int, int, int]]:
    """(time [ns], sender, group, channel) of each event, by time."""
    found: list[tuple[int, int, int, int]] = []
    for name in _instances(prim, FIRING_API):
        names = [f"{FIRING_PREFIX}{name}:{part}" for part in ("eventTimeNs", "txSensorId", "rxGroupId", "channel")]
        columns = [_integers(prim, one) for one in names]
        if len({len(column) for column in columns}) > 1:
            sizes = ", ".join(str(len(column)) for column in columns)
            raise UserError(
                f"{prim.GetPath()}.{FIRING_PREFIX}{name}: eventTimeNs, txSensorId, rxGroupId and channel have {sizes} "
                "elements; give one of each for every event"
            )
        late = [time for time in columns[0] if time >= 2**31]
        if late:
            _fail(prim, names[0], f"{late[0]:,} ns does not fit, it has 31 bits: 2.147 s")
        found += zip(*columns, strict=True)
    return sorted(found) or [(0, 0, 0, 0)]


def _instances(prim: Usd.Prim, schema: str) -> list[str]:
    prefix = f"{schema}:"
    names = {str(name).removeprefix(prefix) for name in prim.GetAppliedSchemas() if str(name).startswith(prefix)}
    return sorted(names)


def _integers(prim: Usd.Prim, name: str) -> tuple[int, ...]:
    return tuple(int(one) for one in value_of(prim, name) or ())


def _vector(prim: Usd.Prim, name: str) -> Vector:
    x, y, z = (_decimal(one) for one in value_of(prim, name) or (0.0, 0.0, 0.0))
    if not all(map(math.isfinite, (x, y, z))):
        _fail(prim, name, "give finite numbers")
    return x, y, z


_DEFAULTS = {
    **{"azSpanDeg": 90.0, "elSpanDeg": 90.0, "raysPerDeg": 4.0, "centerFrequency": 51200.0, "pulseDuration": 2.5e-3},
    **{"pulsePower": 1.0, "sampleDuration": 1.024e-4, "membraneDiameter": 0.0, "noiseMin": 0.0, "noiseMax": 0.0},
}


def _number(prim: Usd.Prim, name: str, *, least: float | None = None, most: float | None = None) -> float:
    """A number above 0, or from `least` on. Raises UserError for others."""
    value = value_of(prim, PREFIX + name)
    number = _decimal(_DEFAULTS[name] if value is None else value)
    if not math.isfinite(number):
        _fail(prim, PREFIX + name, "give a finite number")
    if number < least if least is not None else number <= 0:
        _fail(prim, PREFIX + name, f"give a number {f'from {least:g} on' if least is not None else 'above 0'}")
    if most is not None and number > most:
        _fail(prim, PREFIX + name, f"give at most {most:g}")
    return number


def _decimal(value: Any) -> float:
    """The shortest decimal that rounds to a float32: 0.0025, not 0.002499999944."""
    number = float(value)
    return float(exact.rate(number, stored_as_float32=True)) if math.isfinite(number) else number


def _fail(prim: Usd.Prim, name: str, problem: str) -> None:
    value: Any = value_of(prim, name)
    shown = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else value
    raise UserError(f"{prim.GetPath()}.{name} is {shown}; {problem}")
