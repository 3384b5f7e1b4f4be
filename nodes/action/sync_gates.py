"""Gates that let control through once it has come over all their wires for one value."""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd

from graph.node import Attribute, Database, node_type

ARRIVAL = Attribute("execution", "one arrival; connect every branch that is to be waited for")
THROUGH = Attribute("execution", "fires when as many arrivals as there are connections had the same value")


@dataclass(slots=True)
class Arrivals:
    """The value that is being gathered, and how often it has arrived."""

    value: tuple[int, ...] | None = None
    count: int = 0


def _arrive(db: Database, value: tuple[int, ...]) -> None:
    """Counts an arrival, anew for another value, and fires when all wires have brought it."""
    memory: Arrivals = db.memory
    memory.count = memory.count + 1 if value == memory.value else 1
    memory.value = value
    if memory.count >= max(1, db.wires_into("execIn")):
        memory.count = 0
        db.fire("execOut")


@node_type(
    "omni.graph.action.SyncGate",
    version=2,
    inputs={"execIn": ARRIVAL, "syncValue": Attribute("uint64", "the value to wait for on all connections", default=0)},
    outputs={"execOut": THROUGH, "syncValue": Attribute("uint64", "the value of the last arrival")},
    memory=Arrivals,
)
def sync_gate(db: Database) -> None:
    """Let control through when it has arrived over every connection with one value; another value starts anew."""
    value = db.inputs.syncValue
    db.outputs.syncValue = value
    _arrive(db, (value,))


@node_type(
    "omni.graph.action.RationalTimeSyncGate",
    version=2,
    inputs={
        "execIn": ARRIVAL,
        "rationalTimeDenominator": Attribute("uint64", "denominator of the time", default=0),
        "rationalTimeNumerator": Attribute("int64", "numerator of the time", default=0),
    },
    outputs={
        "execOut": THROUGH,
        "rationalTimeDenominator": Attribute("uint64", "denominator of the last arrival"),
        "rationalTimeNumerator": Attribute("int64", "numerator of the last arrival"),
    },
    memory=Arrivals,
)
def rational_time_sync_gate(db: Database) -> None:
    """Let control through when it has arrived over every connection with one time: 3/6 equals 1/2, 1/0 is not 2/0."""
    numerator, denominator = db.inputs.rationalTimeNumerator, db.inputs.rationalTimeDenominator
    db.outputs.rationalTimeNumerator, db.outputs.rationalTimeDenominator = numerator, denominator
    common = gcd(numerator, denominator) if denominator else 1
    _arrive(db, (numerator // common, denominator // common))
