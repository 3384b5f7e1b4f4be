"""Radar configurations on USD prims: what is authored is the truth, so a saved stage opens as the same radar."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from graph.base import exact
from graph.base.errors import UserError
from sensors.prim import value_of

from .config import RadarConfig, ScanConfig
from .names import ALSO_CALLED, PREFIX, SCAN_PREFIX, WAVEFORM_ONLY, WITHOUT_EFFECT, attribute_name

if TYPE_CHECKING:
    from pxr import Usd


def read_config(prim: Usd.Prim) -> RadarConfig:
    """The configuration a prim describes; attributes without a value count as `RadarConfig` and `ScanConfig` have them.

    Scan configurations come in the lexicographic order of their instance names. Raises UserError naming the prim for
    values no radar can have.
    """
    prefix = "OmniSensorGenericRadarWpmDmatScanCfgAPI:"
    names = [str(name).removeprefix(prefix) for name in prim.GetAppliedSchemas() if str(name).startswith(prefix)]
    try:
        scans = tuple(
            ScanConfig(name=name, **_values(prim, ScanConfig, f"{SCAN_PREFIX}{name}:")) for name in sorted(set(names))
        )
        return RadarConfig(
            name=str(prim.GetPath()),
            scans=scans or (ScanConfig(),),
            without_effect=tuple(_without_effect(prim, sorted(set(names)))),
            **_values(prim, RadarConfig, PREFIX),
        )
    except UserError:
        raise
    except (ValueError, TypeError) as error:
        raise UserError(f"{prim.GetPath()}: {error}") from error


def _values(prim: Usd.Prim, kind: type[Any], prefix: str) -> dict[str, Any]:
    """The values of the fields that a prim has attributes for."""
    found = {}
    for one in dataclasses.fields(kind):
        if one.name in ("name", "scans", "without_effect"):
            continue
        value = _named(prim, prefix, attribute_name(one.name))
        if value is not None:
            found[one.name] = _typed(one.default, value)
    return found


def _named(prim: Usd.Prim, prefix: str, name: str) -> Any:
    """The value of an attribute by either of its names; None if neither is there. Raises UserError if they differ."""
    value, other = value_of(prim, prefix + name), None
    if name in ALSO_CALLED:
        other = value_of(prim, prefix + ALSO_CALLED[name])
        if value and other and value != other:
            raise UserError(
                f"{prim.GetPath()}: {prefix}{name} is {value:g} and {ALSO_CALLED[name]} is {other:g}; give one of them"
            )
    return value or other if other is not None else value


def _without_effect(prim: Usd.Prim, scans: list[str]) -> Iterator[str]:
    """Attributes that are authored with a value that says something, and are not modelled."""
    offset = prim.GetAttribute(f"{PREFIX}instanceTimeOffsetUsec")
    if offset and offset.HasAuthoredValue() and offset.Get() != RadarConfig().instance_time_offset_usec:
        yield "instanceTimeOffsetUsec"
    for scan in scans:
        modes = (value_of(prim, f"{prefix}datacubeMode") for prefix in (f"{SCAN_PREFIX}{scan}:", PREFIX))
        chirps = next(filter(None, modes), "FAST") == "WAVEFORM"
        for name in WITHOUT_EFFECT if chirps else (*WAVEFORM_ONLY, *ALSO_CALLED.values(), *WITHOUT_EFFECT):
            attribute = prim.GetAttribute(f"{SCAN_PREFIX}{scan}:{name}")
            neutral = 1.0 if name == "exponentialDecayFactor" else 0.0
            if attribute and attribute.HasAuthoredValue() and _says(attribute.Get(), neutral):
                yield f"scan:{scan}:{name}"


def _says(value: Any, neutral: float) -> bool:
    try:
        return bool(value != neutral)
    except (ValueError, TypeError):
        return len(value) > 0


def _typed(default: Any, value: Any) -> Any:
    if isinstance(default, tuple):
        return tuple(_decimal(entry) for entry in value)
    return _decimal(value) if isinstance(default, float) else type(default)(value)


def _decimal(value: Any) -> float:
    """The shortest decimal that rounds to a float32: 0.4, not 0.40000000596."""
    number = float(value)
    return (
        number if number != number or abs(number) == float("inf") else float(exact.rate(number, stored_as_float32=True))
    )
