"""Clock nodes: simulation time, system time, the ratio of the two, and a time split into units."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base.exact import nanoseconds
from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.values.precision import single

if TYPE_CHECKING:
    from graph.sim.app import App

NUMERATOR = Attribute(
    "int64",
    "numerator of a past moment on the simulation clock; with both at 0 the node reads the current time",
    unit="s",
)
DENOMINATOR = Attribute("uint64", "denominator of that moment")
READ_AT = {
    "referenceTimeNumerator": Attribute(
        "int64",
        "numerator of the moment that was read: the input's, else that of the frame that started the graph, else now",
        unit="s",
    ),
    "referenceTimeDenominator": Attribute("uint64", "denominator of that moment"),
}
"""Outputs of the clock nodes: the reference time of a frame, for nodes that look it up."""


def _reference(db: Database) -> Fraction | None:
    """The requested past moment, or None for the current one; both are written to the outputs."""
    numerator, denominator = db.inputs.referenceTimeNumerator, db.inputs.referenceTimeDenominator
    moment = Fraction(numerator, denominator) if denominator > 0 else None
    context = db.context
    if moment is None and context.app is not None:
        simulation = context.app.simulation
        present = context.app.rendering.time if context.frame_time is None else context.frame_time
        numerator, denominator = simulation.frame_key(present).as_integer_ratio()
    db.outputs.referenceTimeNumerator, db.outputs.referenceTimeDenominator = numerator, denominator
    return moment


@node_type(
    "isaacsim.core.nodes.IsaacReadSimulationTime",
    version=1,
    volatile=True,
    inputs={
        "resetOnStop": Attribute("bool", "time since play; if not, the time that no stop resets", default=True),
        "referenceTimeNumerator": NUMERATOR,
        "referenceTimeDenominator": DENOMINATOR,
    },
    outputs={"simulationTime": Attribute("double", "physics time", unit="s"), **READ_AT},
)
def read_simulation_time(db: Database) -> None:
    """Read the physics clock: the number of steps divided by the steps per second.

    In a graph that a frame starts (post_render) it is the time of that frame's pose, which its messages carry.
    In a test without a world it is the time of the updates.
    """
    context, moment = db.context, _reference(db)
    if context.app is None and moment is None:
        db.outputs.simulationTime = float(context.exact_time if db.inputs.resetOnStop else context.absolute)
        return
    simulation = db.app.simulation
    since = 0 if context.frame_time is None else db.app.rendering.time - context.frame_time
    if db.inputs.resetOnStop:
        time = simulation.time - since if moment is None else simulation.get_simulation_time_at_time(moment)
    else:
        now = simulation.monotonic_time - since
        time = now if moment is None else simulation.get_simulation_time_monotonic_at_time(moment)
    db.outputs.simulationTime = float(time)


@node_type(
    "isaacsim.core.nodes.IsaacReadSystemTime",
    version=1,
    volatile=True,
    inputs={"referenceTimeNumerator": NUMERATOR, "referenceTimeDenominator": DENOMINATOR},
    outputs={
        "systemTime": Attribute("double", "wall time of the last physics step, UNIX seconds", unit="s"),
        **READ_AT,
    },
)
def read_system_time(db: Database) -> None:
    """Read the wall clock as it stood at the last physics step (virtual unless the run is in real time).

    In a graph that a frame starts (post_render) it is that of the state in the frame.
    """
    simulation, moment, frame_time = db.app.simulation, _reference(db), db.context.frame_time
    if moment is not None:
        db.outputs.systemTime = simulation.get_system_time_at_time(moment)
    else:
        db.outputs.systemTime = (
            simulation.system_time if frame_time is None else simulation.of_frame(frame_time, "system")
        )


@dataclass(slots=True)
class _Last:
    simulation: Fraction | None = None
    system: Fraction = Fraction(0)


@node_type(
    "isaacsim.core.nodes.IsaacRealTimeFactor",
    version=1,
    outputs={"rtf": Attribute("float", "simulated time over wall time since the previous reading; 1 is real time")},
    memory=_Last,
)
def real_time_factor(db: Database) -> bool:
    """Divide the advance of the physics clock by that of the wall clock; the first compute only records both."""
    app, memory = db.app, db.memory
    simulation, system = app.simulation.monotonic_time, app.wall_clock.now()
    before, memory.simulation, wall = memory.simulation, simulation, system - memory.system
    if before is None:
        memory.system = system
        return False
    if simulation == before or wall <= 0:
        memory.simulation = before
        return False
    memory.system = system
    db.outputs.rtf = float((simulation - before) / wall)
    return True


@node_type(
    "isaacsim.core.nodes.IsaacTimeSplitter",
    version=1,
    inputs={
        "time": Attribute(
            ("double", "float", "half", "int", "int64", "uint", "uint64"),
            "the time to split; an integer is whole seconds",
            unit="s",
        )
    },
    outputs={
        "seconds": Attribute("int", "whole seconds, rounded down", unit="s"),
        "milliseconds": Attribute("uint", "the rest in whole milliseconds", unit="ms"),
        "microseconds": Attribute("uint", "the same rest in whole microseconds", unit="us"),
        "nanoseconds": Attribute("uint", "the same rest in whole nanoseconds", unit="ns"),
    },
)
def time_splitter(db: Database) -> None:
    """Split a time; the three smaller units each hold the whole rest (-0.25 s is -1 s and 750 ms)."""
    time = db.inputs.time
    if not math.isfinite(time):
        db.fail(f"input time is {time}; it must be finite")
    seconds, rest = split_time(float(time))
    if not -(2**31) <= seconds < 2**31:
        db.fail(f"input time is {time} s; output seconds holds less than 2^31 s (68 years)")
    outputs = db.outputs
    outputs.seconds = seconds
    outputs.milliseconds, outputs.microseconds, outputs.nanoseconds = rest // 1_000_000, rest // 1_000, rest


def split_time(seconds: float) -> tuple[int, int]:
    """Whole seconds (rounded down) and the rest in nanoseconds [0, 10**9), truncated at the decimal the float shows."""
    whole, rest = divmod(Fraction(repr(seconds)) * 10**9 // 1, 10**9)
    return int(whole), int(rest)


def stamp_ns(app: App, seconds: float) -> int:
    """A time given as a float, as exact nanoseconds.

    A float that equals one of the App's clocks (simulation, monotonic, external time) means that clock; its rational
    time gives the stamp. So does the float32 of a clock, such as the sensorTime of a reading, while a float32 tells
    physics steps apart. Any other float is rounded to the nearest nanosecond.
    """
    simulation = app.simulation
    clocks = (simulation.time, simulation.monotonic_time, app.external_time)
    for exact in clocks:
        if seconds == float(exact):
            return nanoseconds(exact)
    for exact in clocks:
        if seconds == single(float(exact)) and abs(seconds - exact) * simulation.steps_per_second < 1 / 4:
            return nanoseconds(exact)
    return nanoseconds(Fraction(seconds))


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
