"""Clock nodes with an execution input, as post-render graphs use them."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .clocks import DENOMINATOR, NUMERATOR, READ_AT, read_simulation_time, read_system_time

EXEC_IN = Attribute("execution", "reads the clock")
EXEC_OUT = Attribute("execution", "follows every reading")


@node_type(
    "isaacsim.core.nodes.IsaacReadSimulationTimeAnnotator",
    version=1,
    inputs={
        "execIn": EXEC_IN,
        "resetOnStop": Attribute("bool", "time since play; if not, the time that no stop resets", default=True),
        "referenceTimeNumerator": NUMERATOR,
        "referenceTimeDenominator": DENOMINATOR,
    },
    outputs={
        "execOut": EXEC_OUT,
        "simulationTime": Attribute("double", "physics time", unit="s"),
        **READ_AT,
    },
)
def read_simulation_time_annotator(db: Database) -> None:
    """Read the physics clock at the time of a frame (its reference time), or now where none is given."""
    read_simulation_time(db)
    db.fire("execOut")


@node_type(
    "isaacsim.core.nodes.IsaacReadSystemTimeAnnotator",
    version=1,
    inputs={"execIn": EXEC_IN, "referenceTimeNumerator": NUMERATOR, "referenceTimeDenominator": DENOMINATOR},
    outputs={
        "execOut": EXEC_OUT,
        "systemTime": Attribute("double", "wall time of the physics step, UNIX seconds", unit="s"),
        **READ_AT,
    },
)
def read_system_time_annotator(db: Database) -> None:
    """Read the wall clock as it stood at the physics step of a frame (its reference time), or at the last one."""
    read_system_time(db)
    db.fire("execOut")
