"""What all sensors read from their prims, and how attributes are written on them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import exact
from graph.base.errors import UserError
from graph.base.suggest import did_you_mean
from graph.sim.scene.mechanisms import mechanisms_of

from .channels import AuxLevel
from .errors import SensorValueError

if TYPE_CHECKING:
    from pxr import Usd

TICK_RATE = "omni:sensor:tickRate"
FRAME_RATE = "omni:sensor:frameRate"
AUX_CHANNELS = "_replicator:rendervar:GenericModelOutput:channels"
EXCLUDE = "tickgraph:exclude"


def read_tick_rate(prim: Usd.Prim, bare: Fraction | int = 0) -> Fraction:
    """The tick rate [Hz]; 0 means every update. `bare`: for a prim without an authored rate.

    It is authored in `omni:sensor:tickRate`, or as in ovrtx in `omni:sensor:frameRate`, two numbers n, d for n / d Hz.
    Raises UserError if it is negative, or both are authored and disagree.
    """
    ratio = _authored(prim, FRAME_RATE)
    frames = None if ratio is None else _frame_rate(prim, ratio)
    value = _authored(prim, TICK_RATE)
    if value is None:
        return Fraction(bare) if frames is None else frames
    if not math.isfinite(value) or value < 0:
        raise UserError(f"{prim.GetPath()}.{TICK_RATE} is {value}; give a rate in Hz, or 0 to render in every update")
    ticks = exact.rate(float(value), stored_as_float32=True)
    if frames is not None and np.float32(float(frames)) != np.float32(value):
        raise UserError(
            f"{prim.GetPath()}: {TICK_RATE} is {exact.shortest(ticks)} Hz, {FRAME_RATE} {exact.shortest(frames)} Hz: "
            "two words for one rate; give one"
        )
    return ticks if frames is None else frames


def _authored(prim: Usd.Prim, name: str) -> Any:
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute and attribute.HasAuthoredValue() else None


def _frame_rate(prim: Usd.Prim, ratio: Any) -> Fraction:
    try:
        numerator, denominator = map(exact.rate, map(float, ratio))
    except (ValueError, TypeError):
        numerator = denominator = Fraction(0)
    if numerator <= 0 or denominator <= 0:
        raise UserError(f"{prim.GetPath()}.{FRAME_RATE} is {tuple(ratio)}; give n, d above 0 for n / d Hz")
    return numerator / denominator


def has_sensor_api(prim: Usd.Prim) -> bool:
    """Whether a prim has OmniSensorAPI, by its type or applied; false if the prim deletes it from its schemas."""
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
    """The auxiliary level of the prim's GenericModelOutput channels; NONE if not authored."""
    levels = value_of(prim, AUX_CHANNELS) or ()
    named = [AuxLevel[level] for level in map(str, levels) if level in AuxLevel.__members__]
    return max(named, default=AuxLevel.NONE)


def write_aux_level(prim: Usd.Prim, level: str) -> None:
    """Authors the auxiliary level, also for NONE; raises as `write`."""
    if prim.IsInstanceProxy() and read_aux_level(prim).name == level:
        return
    write(prim, AUX_CHANNELS, "string[]", [level])


def read_exclude(prim: Usd.Prim) -> frozenset[str]:
    """Paths of the prims that the sensor never hits (each with everything below it).

    An articulation root stands for all links of its articulation.
    """
    relationship = prim.GetRelationship(EXCLUDE)
    paths = [str(path) for path in relationship.GetTargets()] if relationship else []
    if not paths:
        return frozenset()
    mechanisms = mechanisms_of(prim.GetStage())
    return frozenset(paths).union(*map(mechanisms.standing_for, paths))


def write_exclude(prim: Usd.Prim, paths: tuple[str, ...]) -> None:
    """Authors the prims that the sensor never hits."""
    prim.CreateRelationship(EXCLUDE, custom=True).SetTargets(list(paths))


def apply_schemas(prim: Usd.Prim, names: list[str]) -> None:
    """Applies the API schemas ("Name" or "Name:instance") that the prim does not have yet."""
    present = set(prim.GetAppliedSchemas())
    for name in names:
        if name not in present:
            prim.AddAppliedSchema(name)


def check_instances(path: str, names: list[str]) -> None:
    """Raises SensorValueError for a multiple-apply schema without an instance, or another with one."""
    from graph.sim.usd import Usd

    for name in names:
        base, _, instance = name.rpartition(":")
        base = base or name
        if Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(base):
            several = Usd.SchemaRegistry.IsMultipleApplyAPISchema(base)
            if several and base == name:
                raise SensorValueError(f"{path}: the schema {name} comes in instances; give one, such as {name}:s002")
            if base != name and not several:
                raise SensorValueError(f"{path}: the schema {base} has no instances; leave :{instance} out")


def unknown_schemas(names: list[str]) -> list[str]:
    """The names ("Name" or "Name:instance") that are not API schemas."""
    from graph.sim.usd import Usd

    registry = Usd.SchemaRegistry()
    return [name for name in names if not registry.FindAppliedAPIPrimDefinition(name.rpartition(":")[0] or name)]


def write(prim: Usd.Prim, name: str, kind: str, value: Any) -> None:
    """Sets an attribute, numpy's numbers included; creates it with the USD type `kind` if neither the schema nor the
    prim has it.

    Raises SensorValueError for a fraction if the type is a whole number, because USD would truncate it silently, and
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
    attribute = prim.GetAttribute(name)
    if attribute:
        kind = str(attribute.GetTypeName())
    if isinstance(value, np.generic):
        value = value.item()
    if kind in ("int", "uint") and value != int(value):
        raise SensorValueError(f"{prim.GetPath()}.{name} is a whole number; {value} does not fit")
    if not attribute:
        attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=not name.startswith("omni:"))
    if kind == "float[]":
        value = Vt.FloatArray.FromNumpy(np.ascontiguousarray(value, np.float32)) if len(value) else Vt.FloatArray()
    elif kind == "float3":
        value = Gf.Vec3f(*map(float, value))
    elif kind == "uint[]":
        value = Vt.UIntArray.FromNumpy(np.ascontiguousarray(value, np.uint32)) if len(value) else Vt.UIntArray()
    attribute.Set(value)


def value_of(prim: Usd.Prim, name: str) -> Any:
    """The value of an attribute; None if the prim does not have it."""
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def path_number(path: str) -> int:
    """A number of 64 bits that follows from a prim path alone, for the seeds of random numbers."""
    return int.from_bytes(hashlib.blake2b(path.encode(), digest_size=8).digest(), "little")


def unknown_attributes(prim: Usd.Prim, prefix: str, families: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Attributes under a prefix that a prim authors and that have no effect, each with the reason.

    families: prefix -> API schema, of those that have instances.
    """
    known = [str(name) for name in prim.GetPrimDefinition().GetPropertyNames() if str(name).startswith(prefix)]
    applied, there = set(map(str, prim.GetAppliedSchemas())), set(known)
    for name in map(str, prim.GetAuthoredPropertyNames()):
        if not name.startswith(prefix) or name in there:
            continue
        family = next((each for each in families if name.startswith(each)), "")
        schema = f"{families[family]}:{name.removeprefix(family).split(':')[0]}" if family else ""
        if schema and schema not in applied:
            yield name, f"no effect: it counts only with the schema {schema}"
        else:
            yield name, f"no effect: no schema of the prim has it{did_you_mean(name, known)}"


def reading_problems(prim: Usd.Prim, *reads: Callable[[Usd.Prim], object]) -> Iterator[str]:
    """Calls each function with the prim; the messages of those that raise UserError, one line each."""
    for read in reads:
        try:
            read(prim)
        except UserError as error:
            yield str(error)
