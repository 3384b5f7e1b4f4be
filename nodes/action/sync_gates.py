"""Gates that open once execution has come over all their wires for one value."""

from __future__ import annotations

from math import gcd

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

ARRIVAL = Attribute("execution", "one arrival; connect every branch that is to be waited for")
THROUGH = Attribute("execution", "fires when as many arrivals as there are connections had the same value")


@dataclass(slots=True)
class Arrivals:
    """The current value, and how often execution has arrived with it."""

    value: tuple[int, ...] | None = None
    count: int = 0


def _arrive(db: Database, value: tuple[int, ...]) -> None:
    """Counts an arrival, starting again at another value, and fires when all wires have arrived."""
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
    """Pass execution when it has arrived over every connection with one value; another value starts the count again."""
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
    """Pass execution when it has arrived over every connection with one time: 3/6 equals 1/2, 1/0 differs from 2/0."""
    numerator, denominator = db.inputs.rationalTimeNumerator, db.inputs.rationalTimeDenominator
    db.outputs.rationalTimeNumerator, db.outputs.rationalTimeDenominator = numerator, denominator
    common = gcd(numerator, denominator) if denominator else 1
    _arrive(db, (numerator // common, denominator // common))
