"""Expands the short forms of the data files to emitter tables: fans, layers, scanning mirrors and arrays of numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from sensors.lidar.config import EMITTER_INTEGERS, EmitterState
from sensors.lidar.names import snake_case

NANOSECONDS = 10**9


def emitter_states(document: Mapping[str, Any]) -> tuple[tuple[EmitterState, ...], dict[str, Any]]:
    """The emitter states that a document describes, and the core attributes that depend on them.

    One of `fan`, `layers`, `mirror` or `emitterStates` (lists, or the short forms of `expand`).
    """
    period = 1 / Fraction(str(document["core"]["scanRateBaseHz"]))
    if "fan" in document:
        return _fan(document["fan"], period)
    if "layers" in document:
        return _layers(document["layers"], period)
    if "mirror" in document:
        return _mirror(document["mirror"])
    columns_hz = Fraction(str(document["core"]["patternFiringRateHz"]))
    return tuple(_state(arrays, columns_hz) for arrays in document["emitterStates"]), {}


def expand(spec: Any) -> list[Fraction]:
    """A list of numbers, or {first, step, count[, modulo][, decimals]}, {each, times}, {repeat, times}, {parts}."""
    if not isinstance(spec, Mapping):
        return [Fraction(str(value)) for value in spec]
    if "each" in spec:
        return [value for value in expand(spec["each"]) for _ in range(spec["times"])]
    if "repeat" in spec:
        return expand(spec["repeat"]) * int(spec["times"])
    if "parts" in spec:
        return [value for part in spec["parts"] for value in expand(part)]
    first, step = Fraction(str(spec["first"])), Fraction(str(spec["step"]))
    values = [first + step * index for index in range(spec["count"])]
    if "decimals" in spec:
        values = [Fraction(str(round(float(value), spec["decimals"]))) for value in values]
    return [value % spec["modulo"] for value in values] if "modulo" in spec else values


def _state(arrays: Mapping[str, Any], columns_hz: Fraction) -> EmitterState:
    fields: dict[str, np.ndarray] = {}
    for key, spec in arrays.items():
        name = snake_case(key)
        if isinstance(spec, Mapping) and "evenly" in spec:
            # Emitters fire one after another at equal intervals over a column, each in the middle of its interval.
            share = math.floor(NANOSECONDS / (columns_hz * spec["evenly"]))
            spec = {"first": share // 2, "step": share, "count": spec["evenly"]}
        fields[name] = _array(expand(spec), whole=name in EMITTER_INTEGERS)
    return EmitterState(**fields)


def _array(values: Sequence[Fraction], *, whole: bool) -> np.ndarray:
    return np.array([math.floor(value) if whole else float(value) for value in values])


def _multiples(start: Fraction, step: Fraction, number: np.ndarray, modulo: Fraction | int = 0) -> np.ndarray:
    """start + number x step (modulo), float64 (n,): each the correctly rounded quotient of whole numbers."""
    modulo = Fraction(modulo)
    unit = math.lcm(start.denominator, step.denominator, modulo.denominator)
    values = int(start * unit) + number * int(step * unit)
    return np.asarray((values % int(modulo * unit) if modulo else values) / unit)


def _fan(fan: Mapping[str, Any], period: Fraction) -> tuple[tuple[EmitterState, ...], dict[str, Any]]:
    """Beams from azimuth `start` clockwise in steps of `step`, for each of the `elevations` (one: 0).

    `modulo`: 360 if the public profile counts azimuths from 0 to 360 deg; otherwise they become negative. `timing`:
    "scan" fires the beams at equal intervals over the scan; "rotor" fires each at the time at which a mirror with one
    turn per scan points there; a number is a firing rate [Hz]. Planes follow one another at equal parts of the scan.
    """
    step, elevations = Fraction(str(fan["step"])), fan.get("elevations", [0])
    count = fan["count"] if "count" in fan else math.floor(Fraction(str(fan["angle"])) / step) + 1
    start = Fraction(str(fan["start"])) if "start" in fan else (count - 1) * step / 2
    timing = fan["timing"]
    between = {"scan": period / count, "rotor": period * step / 360}.get(timing) or 1 / Fraction(str(timing))
    beam, planes = np.arange(count), len(elevations)
    azimuth = _multiples(start, -step, beam, modulo=fan.get("modulo", 0))
    fire = [
        _multiples(number * period / planes * NANOSECONDS, between * NANOSECONDS, beam, modulo=period * NANOSECONDS)
        for number in range(planes)
    ]
    state = EmitterState(
        np.tile(azimuth, planes), np.repeat(np.array(elevations, float), count), np.floor(np.concatenate(fire))
    )
    return (state,), {"numLines": planes, "numRaysPerLine": [count] * planes}


def _layers(spec: Mapping[str, Any], period: Fraction) -> tuple[tuple[EmitterState, ...], dict[str, Any]]:
    """Layers of a rotating head that fires `ticks` times a turn, one direction after the other.

    Each layer is [elevation, azimuth at tick 0, first tick, interval in ticks]; firings are ordered by tick, then by
    layer.
    """
    ticks, step = spec["ticks"], Fraction(360, spec["ticks"])
    fired = [np.arange(first, ticks, every) for _, _, first, every in spec["layers"]]
    tick, layer = np.concatenate(fired), np.repeat(np.arange(len(fired)), [len(ticked) for ticked in fired])
    azimuth = np.concatenate(
        [
            _multiples(Fraction(str(start)), -step, ticked, modulo=360)
            for (_, start, _, _), ticked in zip(spec["layers"], fired, strict=True)
        ]
    )
    elevation = np.array([elevation for elevation, _, _, _ in spec["layers"]])[layer]
    fire = np.floor(_multiples(Fraction(0), period / ticks * NANOSECONDS, tick))
    order = np.lexsort((layer, tick))
    state = EmitterState(azimuth[order], elevation[order], fire[order])
    return (state,), {"numLines": 1, "numRaysPerLine": [len(order)]}


def _mirror(spec: Mapping[str, Any]) -> tuple[tuple[EmitterState, ...], dict[str, Any]]:
    """Lasers on one mirror that oscillates fast about one axis and slowly about the other.

    At time t the fast angle is x = cos(2 pi fastHz t + phase), the slow one y follows `slow`, its values every
    `slowStepNs`, along lines; a laser's azimuth and elevation [deg] are polynomials in both: coefficients of x^i y^j
    with i + j <= order, i first. The lasers fire in turn, every `betweenNs`, or (`together`) all at once.
    """
    lasers, rays = len(spec["azimuthDeg"]), spec["lines"] * spec["raysPerLine"]
    number, laser = np.arange(rays), np.arange(rays) % lasers
    firing = number // lasers if spec["together"] else number
    fire = np.floor(firing * float(Fraction(str(spec["betweenNs"])))).astype(np.int64)
    x = np.cos(2 * np.pi * spec["fastHz"] * fire * 1e-9 + spec["phase"])
    y = np.interp(fire, np.arange(len(spec["slow"])) * spec["slowStepNs"], spec["slow"])
    order = spec["order"]
    terms = [x**i * y**j for i in range(order + 1) for j in range(order + 1 - i)]
    angles = []
    for name in ("azimuthDeg", "elevationDeg"):
        table = np.array(spec[name])
        angles.append(np.round(sum(table[laser, index] * term for index, term in enumerate(terms)), 2))
    state = EmitterState(angles[0], angles[1], fire)
    return (state,), {"numLines": spec["lines"], "numRaysPerLine": [spec["raysPerLine"]] * spec["lines"]}
