"""How much a file may ask for: every bound by name, in one table.

An untrusted file can choose the size of loops and allocations. Each such size has a bound here and is checked before
the work begins; `--limit NAME=VALUE` (or `raised`) changes one for a run that needs more.

    with limits.raised({"scene.triangles": 100_000_000}):
        app = App.from_file("city.yaml")
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction

from .errors import UserError
from .exact import rate
from .records import dataclass
from .suggest import did_you_mean

MIB = 2**20


@dataclass(frozen=True, slots=True)
class Limit:
    """One bound: its default value, its unit, and what it limits."""

    default: int
    unit: str
    doc: str


LIMITS: dict[str, Limit] = {
    "file.yaml": Limit(1 * MIB, "bytes", "a YAML file; JSON is read several times as fast"),
    "file.json": Limit(12 * MIB, "bytes", "a JSON file"),
    "file.script": Limit(1 * MIB, "bytes", "a Python script that is checked"),
    "file.keys": Limit(600_000, "keys", "the mappings of a YAML or JSON file"),
    "file.prims": Limit(100_000, "prims", "those that a graph file writes, with those above them"),
    "graph.nodes": Limit(200_000, "nodes", "the graphs of a file, once for each prim that has the graph"),
    "graph.values": Limit(300_000, "attributes", "those that a USD scene authors on nodes"),
    "usd.text": Limit(64 * MIB, "bytes", "a text layer of a scene; binary layers (.usdc) are read as they are needed"),
    "usd.specs": Limit(1_000_000, "prims and properties", "a layer of a scene"),
    "usd.prims": Limit(200_000, "prims", "a text layer; what the references of a scene compose, instances included"),
    "physics.parts": Limit(50_000, "bodies and joints", "the physics of a stage"),
    "run.updates": Limit(1_000_000_000, "updates", "a run, by --updates, --duration or the file"),
    "campaign.runs": Limit(100_000, "runs", "a campaign"),
    "campaign.upload": Limit(256 * MIB, "bytes", "the files that a campaign sends to a cluster"),
    "campaign.table": Limit(64 * MIB, "bytes", "the table of points of a campaign"),
    "clock.steps": Limit(100_000, "steps", "physics in one update: physics_hz against loop_hz"),
    "physics.iterations": Limit(10_000, "iterations", "a solver or collision of physics, each of its counts"),
    "lidar.rays": Limit(10_000_000, "rays", "a scan, with the sub-rays of each beam"),
    "radar.rays": Limit(
        10_000_000, "rays", "the fan of a radar's scan; finer rays over what is small in it come on top"
    ),
    "radar.cells": Limit(
        20_000_000,
        "cells",
        "of range and velocity together, a scan configuration of a radar; with noise and cfarMode 4D of all four axes",
    ),
    "acoustic.rays": Limit(1_000_000, "rays", "the fan of a mount of an acoustic sensor"),
    "lidar.bins": Limit(10_000, "spans", "a scan of lidar.motion continuous"),
    "camera.rays": Limit(10_000_000, "rays", "an image, with the samples of each pixel"),
    "camera.texels": Limit(100_000_000, "pixels", "the textures of a scene together"),
    "graph.steps": Limit(5_000_000, "computes", "a graph in one evaluation, the passes of all its loops together"),
    "graph.bytes": Limit(1024 * MIB, "bytes", "the values of all graphs together"),
    "scene.triangles": Limit(10_000_000, "triangles", "what rays can hit, copies included"),
    "scene.copies": Limit(5_000_000, "copies", "what point instancers make of one prim, nested ones multiplied"),
    "mesh.corners": Limit(50_000, "corners", "a face of a mesh"),
    "usd.entries": Limit(50_000_000, "entries", "a table of a binary layer: paths, fields, texts"),
    "recording.record": Limit(64 * MIB, "bytes", "a record or an unpacked chunk of an MCAP recording that is played"),
    "recording.unpacked": Limit(2048 * MIB, "bytes", "what a recording unpacks to, beyond 255 times its size"),
    "recording.messages": Limit(1_000_000, "messages", "the records of a recording, beyond one for each of its bytes"),
    "recording.waiting": Limit(1024 * MIB, "bytes", "unpacked chunks of a played recording that overlap in time"),
    "recording.parts": Limit(5_000_000, "parts", "texts and messages in the lists of one played message"),
    "recording.definitions": Limit(2 * MIB, "bytes", "definitions of unknown types in a played recording"),
    "recording.type": Limit(1_000_000, "values", "the fixed lists and fields of a type that a recording defines"),
}
"""Every limit by name."""

_raised: ContextVar[Mapping[str, int]] = ContextVar("limits", default={})  # noqa: B039 (never changed in place)


def most(name: str) -> int:
    """The present value of a limit."""
    return _raised.get().get(name, LIMITS[name].default)


def allowed(name: str) -> str:
    """The part of a message that states a limit: its value, its unit, and how to raise it."""
    return f"the limit is {most(name):,} {LIMITS[name].unit}; raise it with --limit {name}=N"


class OverLimit(UserError, ValueError):  # noqa: N818  (named after what happened)
    """Something is larger than a limit; the message says what, the limit, and how to raise it."""


def check(name: str, amount: float | Fraction, what: str) -> None:
    """Raises OverLimit if a count exceeds the limit named `what`; the message begins with that name."""
    if amount > most(name):
        raise OverLimit(f"{what}; {allowed(name)}")


def checked(name: str, value: int | str) -> int:
    """A limit's value as an integer.

    Raises ValueError for an unknown name or if it is not a whole number >= 1 (1e9 is one).
    """
    if name not in LIMITS:
        near = did_you_mean(name, LIMITS) or f"; the limits are {', '.join(LIMITS)}"
        raise ValueError(f"there is no such limit{near}")
    number = rate(value)
    if number.denominator != 1 or number < 1:
        raise ValueError(f"{value} is not a whole number from 1")
    return int(number)


@contextmanager
def raised(values: Mapping[str, int | str]) -> Iterator[None]:
    """Changes limits within a `with` block. Raises ValueError as `checked` does."""
    changed = {name: checked(name, value) for name, value in values.items()}
    token = _raised.set({**_raised.get(), **changed})
    try:
        yield
    finally:
        _raised.reset(token)
