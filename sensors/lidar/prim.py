"""Lidar configurations on USD prims: what is authored is the truth, so a saved stage opens as the same lidar."""

from __future__ import annotations

import functools
import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import exact
from graph.base.errors import UserError
from sensors.channels import AuxLevel
from sensors.errors import SensorValueError

from .attributes import attribute_types, attributes_of, config_from_attributes, whole
from .config import EMITTER_FLOATS, EMITTER_INTEGERS, EmitterState, LidarConfig
from .names import (
    AUX_CHANNELS,
    EXACT,
    EXCLUDE,
    PREFIX,
    STATE_PREFIX,
    TICK_RATE,
    camel_case,
    snake_case,
)

if TYPE_CHECKING:
    from pxr import Usd

CORE_API = "OmniSensorGenericLidarCoreAPI"
STATE_API = "OmniSensorGenericLidarCoreEmitterStateAPI"


def write_config(prim: Usd.Prim, config: LidarConfig, *, tick_rate: float | Fraction | None = None) -> None:
    """Authors a whole configuration: applied schemas, core attributes, emitter states, and the tick rate.

    tick_rate: the scan rate unless given. A rate or pulse time that is no whole number does not fit the schema's
    uint: its exact value stands beside it, in `tickgraph:scanRateBaseHz` and the like.
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
    """The configuration a prim describes; attributes without a value count as the default rotary profile's.

    Raises UserError naming the prim for values no lidar can have.
    """
    values: dict[str, Any] = {}
    for name in attribute_types():
        value = _get(prim, PREFIX + name)
        if value is not None:
            values[name] = value
    for name, exact_name in EXACT.items():
        text = _get(prim, exact_name)
        if isinstance(text, str) and whole(name, exact.rate(text)) == values.get(name):
            values[name] = exact.rate(text)
    states = _read_states(prim)
    if not states:
        values.pop("numberOfEmitters", None)
        values.pop("emitterStateCount", None)
        states = _default_states()
    try:
        return config_from_attributes(values, states, name=str(prim.GetPath()), stored_as_float32=True)
    except (ValueError, TypeError) as error:
        raise UserError(f"{prim.GetPath()}: {error}") from error


def read_tick_rate(prim: Usd.Prim, bare: Fraction | int = 0) -> Fraction:
    """How often the sensor ticks [Hz]; 0 means every update, `bare` is what a prim gets that authors no rate.

    Raises UserError if negative.
    """
    attribute = prim.GetAttribute(TICK_RATE)
    value = attribute.Get() if attribute and attribute.HasAuthoredValue() else None
    if value is None:
        return Fraction(bare)
    if not math.isfinite(value) or value < 0:
        raise UserError(f"{prim.GetPath()}.{TICK_RATE} is {value}; give a rate in Hz, or 0 to render in every update")
    return exact.rate(float(value), stored_as_float32=True)


def has_sensor_api(prim: Usd.Prim) -> bool:
    """Whether a prim has OmniSensorAPI, by its type or applied; one that deletes it from its schemas has not."""
    if "OmniSensorAPI" not in prim.GetAppliedSchemas():
        return False
    for spec in prim.GetPrimStack():
        listed = spec.GetInfo("apiSchemas")
        if "OmniSensorAPI" in listed.deletedItems:
            return False
        if "OmniSensorAPI" in listed.GetAddedOrExplicitItems():
            return True
    return True


def read_aux_level(prim: Usd.Prim) -> AuxLevel:
    """The auxiliary level that the prim's GenericModelOutput channels ask for; NONE when nothing says."""
    levels = _get(prim, AUX_CHANNELS) or ()
    named = [AuxLevel[level] for level in map(str, levels) if level in AuxLevel.__members__]
    return max(named, default=AuxLevel.NONE)


def write_aux_level(prim: Usd.Prim, level: str) -> None:
    """Authors the auxiliary level, always, also for NONE; raises as `write`."""
    if prim.IsInstanceProxy() and read_aux_level(prim).name == level:
        return
    write(prim, AUX_CHANNELS, "string[]", [level])


def read_exclude(prim: Usd.Prim) -> frozenset[str]:
    """Paths of the prims that the sensor never hits (each with everything below it)."""
    relationship = prim.GetRelationship(EXCLUDE)
    return frozenset(str(path) for path in relationship.GetTargets()) if relationship else frozenset()


def write_exclude(prim: Usd.Prim, paths: tuple[str, ...]) -> None:
    """Authors what the sensor never hits."""
    prim.CreateRelationship(EXCLUDE, custom=True).SetTargets(list(paths))


def apply_schemas(prim: Usd.Prim, names: list[str]) -> None:
    """Applies API schemas by name ("Name" or "Name:instance") that the prim does not have yet."""
    present = set(prim.GetAppliedSchemas())
    for name in names:
        if name not in present:
            prim.AddAppliedSchema(name)


def unknown_schemas(names: list[str]) -> list[str]:
    """Those of the names ("Name" or "Name:instance") that no API schema has."""
    from graph.sim.usd import Usd

    registry = Usd.SchemaRegistry()
    return [name for name in names if not registry.FindAppliedAPIPrimDefinition(name.rpartition(":")[0] or name)]


def write(prim: Usd.Prim, name: str, kind: str, value: Any) -> None:
    """Sets an attribute, creating it with the USD type `kind` where neither the schema nor the prim has it.

    Raises SensorValueError for a fraction where the type is a whole number, which USD would cut off without a word, and
    for another value on a prim of an instance, which cannot be edited.
    """
    from graph.sim.usd import Gf, Sdf, Vt

    if prim.IsInstanceProxy():
        if prim.GetAttribute(name) and prim.GetAttribute(name).Get() == value:
            return
        raise SensorValueError(
            f"{prim.GetPath()}: {name} cannot be set, the prim is part of an instance; set it in the instance's asset, "
            "or make the instance instanceable = false"
        )
    if kind in ("int", "uint") and value != int(value):
        raise SensorValueError(f"{prim.GetPath()}.{name} is a whole number; {value} does not fit")
    attribute = prim.GetAttribute(name)
    if not attribute:
        attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=not name.startswith("omni:"))
    if kind == "float[]":
        value = Vt.FloatArray.FromNumpy(np.ascontiguousarray(value, np.float32)) if len(value) else Vt.FloatArray()
    elif kind == "float3":
        value = Gf.Vec3f(*map(float, value))
    elif kind == "uint[]":
        value = Vt.UIntArray.FromNumpy(np.ascontiguousarray(value, np.uint32)) if len(value) else Vt.UIntArray()
    attribute.Set(value)


def attribute_kind(name: str) -> str | None:
    """USD value type of an attribute that lidars have, by its full name; None for others."""
    if name == TICK_RATE:
        return "float"
    if name.startswith(STATE_PREFIX):
        field = name.rsplit(":", 1)[-1]
        kinds = {"float[]": EMITTER_FLOATS, "uint[]": EMITTER_INTEGERS}
        return next((kind for kind, names in kinds.items() if field in map(camel_case, names)), None)
    return attribute_types().get(name.removeprefix(PREFIX)) if name.startswith(PREFIX) else None


def _get(prim: Usd.Prim, name: str) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def _read_states(prim: Usd.Prim) -> tuple[EmitterState, ...]:
    """The emitter states that hold arrays, in lexicographic order of their instance names."""
    names = [str(name) for name in prim.GetPropertyNames() if str(name).startswith(STATE_PREFIX)]
    states = []
    for instance in sorted({name.removeprefix(STATE_PREFIX).split(":")[0] for name in names}):
        arrays = {}
        for name in (*EMITTER_FLOATS, *EMITTER_INTEGERS):
            value = _get(prim, f"{STATE_PREFIX}{instance}:{camel_case(name)}")
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
