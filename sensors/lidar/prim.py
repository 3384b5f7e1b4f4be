"""Lidar configurations on USD prims.

The authored attributes are the configuration, so a saved stage gives the same lidar.
"""

from __future__ import annotations

import functools
from contextlib import suppress
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import exact
from graph.base.errors import UserError
from sensors.prim import TICK_RATE, apply_schemas, value_of, write

from .attributes import attribute_types, attributes_of, config_from_attributes, whole
from .config import EMITTER_FLOATS, EMITTER_INTEGERS, EmitterState, LidarConfig
from .names import CORE_API, EXACT, OVRTX, PREFIX, PRIM_TYPE, STATE_PREFIX, camel_case, snake_case

if TYPE_CHECKING:
    from pxr import Usd

STATE_API = "OmniSensorGenericLidarCoreEmitterStateAPI"


def is_lidar(prim: Usd.Prim) -> bool:
    """Whether a prim exists and is a lidar with its core schema."""
    return bool(prim) and prim.GetTypeName() == PRIM_TYPE and CORE_API in prim.GetAppliedSchemas()


def write_config(prim: Usd.Prim, config: LidarConfig, *, tick_rate: float | Fraction | None = None) -> None:
    """Authors a whole configuration: applied schemas, core attributes, emitter states, and the tick rate.

    tick_rate: the scan rate unless given. A rate or pulse time that is not a whole number does not fit the schema's
    uint: its exact value is stored beside it, in `tickgraph:scanRateBaseHz` and similar attributes.
    """
    from graph.sim.usd import Sdf

    instances = [f"s{number:03}" for number in range(1, config.emitter_state_count + 1)]
    apply_schemas(prim, ["OmniSensorAPI", CORE_API, *(f"{STATE_API}:{instance}" for instance in instances)])
    types = attribute_types()
    with Sdf.ChangeBlock():
        for name, value in attributes_of(config).items():
            write(prim, PREFIX + name, types[name], value)
        for instance, state in zip(instances, config.emitter_states, strict=True):
            for name in (*EMITTER_FLOATS, *EMITTER_INTEGERS):
                array = getattr(state, name)
                if len(array):
                    kind = "float[]" if name in EMITTER_FLOATS else "uint[]"
                    write(prim, f"{STATE_PREFIX}{instance}:{camel_case(name)}", kind, array)
        for name, exact_name in EXACT.items():
            value = getattr(config, snake_case(name))
            if value != int(value):
                write(prim, exact_name, "string", str(value))
        write(prim, TICK_RATE, "float", float(config.scan_rate_base_hz if tick_rate is None else tick_rate))


def read_config(prim: Usd.Prim) -> LidarConfig:
    """The configuration that a prim describes; attributes without a value have those of the default rotary profile.

    Raises UserError, which names the prim, for values that are not valid for a lidar.
    """
    values: dict[str, Any] = {}
    for name in attribute_types():
        value = value_of(prim, PREFIX + name)
        if value is not None:
            values[name] = value
    for name, exact_name in EXACT.items():
        text = value_of(prim, exact_name)
        with suppress(ValueError):  # not written by us: the number itself counts
            if isinstance(text, str) and whole(name, exact.rate(text)) == values.get(name):
                values[name] = exact.rate(text)
    values |= _ovrtx_words(prim, values)
    states = _read_states(prim)
    if not states:
        values.pop("numberOfEmitters", None)
        values.pop("emitterStateCount", None)
        states = _default_states()
    try:
        return config_from_attributes(values, states, name=str(prim.GetPath()), stored_as_float32=True)
    except (ValueError, TypeError) as error:
        raise UserError(f"{prim.GetPath()}: {error}") from error


def _ovrtx_words(prim: Usd.Prim, values: dict[str, Any]) -> dict[str, Any]:
    """Our values for the words of ovrtx that a prim authors. Raises UserError if ours differ."""
    found: dict[str, Any] = {}
    for word, (name, same) in OVRTX.items():
        value = value_of(prim, PREFIX + word)
        if value is None:
            continue
        found[name] = bool(value) == same
        ours = prim.GetAttribute(PREFIX + name)
        if ours.HasAuthoredValue() and bool(values.get(name)) != found[name]:
            raise UserError(f"{prim.GetPath()}: {name} and {word} contradict each other; give one")
    return found


def attribute_kind(name: str) -> str | None:
    """USD value type of a lidar attribute, by its full name; None for other attributes."""
    if name == TICK_RATE:
        return "float"
    if name.startswith(STATE_PREFIX):
        field = name.rsplit(":", 1)[-1]
        kinds = {"float[]": EMITTER_FLOATS, "uint[]": EMITTER_INTEGERS}
        return next((kind for kind, names in kinds.items() if field in map(camel_case, names)), None)
    return attribute_types().get(name.removeprefix(PREFIX)) if name.startswith(PREFIX) else None


def _read_states(prim: Usd.Prim) -> tuple[EmitterState, ...]:
    """The emitter states that hold arrays, in lexicographic order of their instance names."""
    names = [str(name) for name in prim.GetPropertyNames() if str(name).startswith(STATE_PREFIX)]
    states = []
    for instance in sorted({name.removeprefix(STATE_PREFIX).split(":")[0] for name in names}):
        arrays = {}
        for name in (*EMITTER_FLOATS, *EMITTER_INTEGERS):
            value = value_of(prim, f"{STATE_PREFIX}{instance}:{camel_case(name)}")
            if value is not None and len(value):
                arrays[name] = np.array(value)
        if "azimuth_deg" in arrays or "elevation_deg" in arrays:
            for name, other in (("azimuth_deg", "elevation_deg"), ("elevation_deg", "azimuth_deg")):
                arrays.setdefault(name, np.zeros(len(arrays.get(other, ()))))
            states.append(EmitterState(**arrays))
    return tuple(states)


@functools.cache
def _default_states() -> tuple[EmitterState, ...]:
    from sensors.configs.catalog import find

    return find("Example_Rotary").emitter_states
