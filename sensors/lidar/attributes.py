"""Converts a LidarConfig to attribute values and back: names, types and rounding, without a stage."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from graph.base import exact
from graph.base.errors import UserError

from .config import EmitterState, LidarConfig
from .names import camel_case

_RATES = ("scan_rate_base_hz", "pattern_firing_rate_hz")
_NOT_ATTRIBUTES = ("name", "emitter_states")
_UNKNOWN_IF_ZERO = (
    *("min_azimuth_roi", "max_azimuth_roi"),
    *("focus_dist_m", "effective_aperture_size_m", "divergence_hor_deg", "divergence_ver_deg"),
)
_DERIVED = {"numberOfEmitters", "emitterStateCount", "rangeCount"}


@functools.cache
def attribute_types() -> dict[str, str]:
    """Attribute name (without prefix) -> USD value type, for everything a configuration authors."""
    types = {}
    for field in dataclasses.fields(LidarConfig):
        if field.name in _NOT_ATTRIBUTES:
            continue
        default: Any = field.default
        if field.name in _RATES or field.name == "pulse_time_ns":
            kind = "uint"
        elif field.name.startswith("origin_error"):
            kind = "float3"
        elif isinstance(default, tuple):
            kind = "uint[]" if field.name == "num_rays_per_line" else "float[]"
        else:
            kind = {bool: "bool", int: "uint", float: "float", str: "token"}[type(default)]
        types[camel_case(field.name)] = kind
    return types | dict.fromkeys(_DERIVED, "uint")


def attributes_of(config: LidarConfig) -> dict[str, Any]:
    """Attribute name (without prefix) -> value in USD's terms: rates rounded down to whole Hz, counts filled in.

    Fields whose value means "not given" (0 lines, no gates, 0 m focus) are left out.
    """
    values: dict[str, Any] = {}
    for field in dataclasses.fields(LidarConfig):
        value = getattr(config, field.name)
        optional = field.default in (0, ()) or field.name in _UNKNOWN_IF_ZERO
        if field.name in _NOT_ATTRIBUTES or (optional and value == field.default and not isinstance(value, bool)):
            continue
        if field.name in (*_RATES, "pulse_time_ns"):
            value = whole(camel_case(field.name), value)
        values[camel_case(field.name)] = list(value) if isinstance(value, tuple) else value
    values["numberOfEmitters"] = config.number_of_emitters
    values["numberOfChannels"] = config.number_of_channels or config.number_of_emitters
    values["emitterStateCount"] = config.emitter_state_count
    if config.ranges_min_m:
        values["rangeCount"] = len(config.ranges_min_m)
    return values


def whole(name: str, value: Fraction | float) -> int:
    """The whole number in the schema for a rate (rounded down) or a pulse time (rounded), at least 1."""
    return max(1, round(value) if name == "pulseTimeNs" else math.floor(value))


def config_from_attributes(
    values: Mapping[str, Any],
    states: tuple[EmitterState, ...],
    *,
    name: str = "Generic",
    stored_as_float32: bool = False,
) -> LidarConfig:
    """A configuration from attribute values (names without prefix) and emitter states; unknown names are ignored.

    stored_as_float32: floats become the shortest decimal that rounds to them (0.3, not 0.30000001192).
    Raises UserError for values that are not valid for a lidar.
    """
    fields: dict[str, Any] = {}
    for field in dataclasses.fields(LidarConfig):
        value = values.get(camel_case(field.name))
        if field.name in _NOT_ATTRIBUTES or value is None:
            continue
        fields[field.name] = _field_value(field, value, stored_as_float32)
    if "emitterStateCount" in values and states:
        states = states[: max(1, int(values["emitterStateCount"]))]
    config = LidarConfig(name=name, emitter_states=states, **fields)
    listed = values.get("numberOfEmitters")
    if listed is not None and int(listed) != config.number_of_emitters:
        raise UserError(
            f"lidar config {name}: numberOfEmitters is {listed}, emitter state s001 lists {config.number_of_emitters}; "
            "make both the same"
        )
    return config


def _field_value(field: dataclasses.Field[Any], value: Any, stored_as_float32: bool) -> Any:
    default: Any = field.default
    if field.name in _RATES:
        return value if isinstance(value, Fraction) else exact.rate(value, stored_as_float32=stored_as_float32)
    if isinstance(default, tuple):
        if field.name == "num_rays_per_line":
            return tuple(int(entry) for entry in value)
        return tuple(_float(entry, stored_as_float32) for entry in value)
    if isinstance(default, bool):
        return bool(value)
    if isinstance(default, float):
        return _float(value, stored_as_float32)
    return type(default)(value)


def _float(value: Any, stored_as_float32: bool) -> float:
    number = float(value)
    if not stored_as_float32 or not math.isfinite(number):
        return number
    return float(exact.rate(number, stored_as_float32=True))
