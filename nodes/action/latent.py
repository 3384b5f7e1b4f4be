"""Latent nodes: they sleep across updates and finish later."""

from __future__ import annotations

from fractions import Fraction

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.bounds import at_least
from nodes.durations import check_duration, finite_duration

EXEC_IN = Attribute("execution", "starts the wait")


@node_type(
    "omni.graph.action.Countdown",
    version=2,
    check=at_least(duration=0, period=1),
    latent=True,
    inputs={
        "execIn": EXEC_IN,
        "duration": Attribute("int", "updates until `finished`", default=5, unit="updates"),
        "period": Attribute("int", "updates between two `tick`s", default=1, unit="updates"),
    },
    outputs={
        "tick": Attribute("execution", "fires every `period` updates while the count runs"),
        "finished": Attribute("execution", "fires when `duration` updates have passed"),
        "tickValue": Attribute("int", "updates counted since the start", unit="updates"),
        "alpha": Attribute("float", "tickValue / duration, 0 at the start and 1 at the end"),
    },
    state={"count": Attribute("int", "-1 while idle, else updates counted so far", default=-1, unit="updates")},
)
def countdown(db: Database) -> bool:
    """Count updates from the one in which `execIn` fired (0); on the last one `tick` fires before `finished`.

    Duration 0 finishes in the next update without a `tick`.
    """
    length, period = db.inputs.duration, db.inputs.period
    if length < 0:
        db.fail(f"input duration is {length}; give it 0 or more updates")
    if period < 1:
        db.fail(f"input period is {period}; give it 1 or more updates")
    started = db.triggered("execIn")
    count = 0 if started else db.state.count + 1
    db.outputs.tickValue = min(count, length)
    db.outputs.alpha = min(count / length, 1.0) if length else float(not started)
    if started:
        db.sleep()
    elif count <= length and count % period == 0:
        db.fire("tick")
    if not started and count >= length:
        db.fire("finished")
        db.wake()
        count = -1
    db.state.count = count
    return True


@dataclass(slots=True)
class _Waiting:
    elapsed: Fraction = Fraction(0)


@node_type(
    "omni.graph.action.Delay",
    version=2,
    check=check_duration,
    latent=True,
    inputs={
        "execIn": EXEC_IN,
        "duration": Attribute("double", "shortest time to wait", default=0.0, unit="s"),
    },
    outputs={"finished": Attribute("execution", "fires in the first update at least `duration` after the start")},
    memory=_Waiting,
)
def delay(db: Database) -> bool:
    """Wait at least `duration` seconds of update time, added up exactly; 0 finishes in the next update."""
    memory = db.memory
    if db.triggered("execIn"):
        memory.elapsed = Fraction(0)
        finite_duration(db)
        db.sleep()
        return True
    memory.elapsed += db.context.loop_delta
    if memory.elapsed >= finite_duration(db):
        db.fire("finished")
        db.wake()
    return True
