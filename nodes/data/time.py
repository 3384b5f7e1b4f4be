"""The clocks of a run, and a value that changes with one of them."""

from __future__ import annotations

from fractions import Fraction

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.durations import check_length, finite_duration


@node_type(
    "omni.graph.nodes.ReadTime",
    version=1,
    volatile=True,
    outputs={
        "absoluteSimTime": Attribute(
            "double", "time of all updates so far; a stop does not reset it", unit="s", role="loop time"
        ),
        "deltaSeconds": Attribute("double", "length of this update", unit="s"),
        "frame": Attribute("double", "timeline time as a frame number", unit="frames"),
        "isPlaying": Attribute("bool", "whether the timeline plays"),
        "time": Attribute("double", "timeline time", unit="s", role="timeline time"),
        "timeSinceStart": Attribute(
            "double", "time since the App was made, playing or not", unit="s", role="loop time"
        ),
    },
)
def read_time(db: Database) -> None:
    """Read the clocks of this update."""
    context, outputs = db.context, db.outputs
    outputs.absoluteSimTime = context.absolute_sim_time
    outputs.deltaSeconds = context.delta_seconds
    outputs.frame = context.frame
    outputs.isPlaying = context.is_playing
    outputs.time = context.time
    outputs.timeSinceStart = context.time_since_start


@dataclass(slots=True)
class _Running:
    elapsed: Fraction = Fraction(0)


@node_type(
    "omni.graph.nodes.Timer",
    version=2,
    check=check_length,
    latent=True,
    inputs={
        "duration": Attribute("double", "how long the value runs", default=1.0, unit="s"),
        "endValue": Attribute("double", "value at the end", default=1.0),
        "play": Attribute("execution", "starts it; ignored while it runs"),
        "startValue": Attribute("double", "value at the start", default=0.0),
    },
    outputs={
        "finished": Attribute("execution", "fires in the first update at least `duration` after the start"),
        "updated": Attribute("execution", "fires in every update after the start, the last one included"),
        "value": Attribute("double", "startValue to endValue, in proportion to the time that has passed", default=0.0),
    },
    memory=_Running,
)
def timer(db: Database) -> None:
    """Change a value from start to end over some seconds of update time; duration 0 finishes in the next update."""
    inputs, memory = db.inputs, db.memory
    if db.triggered("play"):
        _whole(db)
        memory.elapsed = Fraction(0)
        db.outputs.value = inputs.startValue
        db.sleep()
        return
    whole = _whole(db)
    memory.elapsed += db.context.loop_delta
    done = memory.elapsed >= whole
    share = 1.0 if done else float(memory.elapsed / whole)
    db.outputs.value = inputs.endValue if done else inputs.startValue + share * (inputs.endValue - inputs.startValue)
    db.fire("updated")
    if done:
        db.fire("finished")
        db.wake()


def _whole(db: Database) -> Fraction:
    whole = finite_duration(db)
    if whole < 0:
        db.fail(f"input duration is {db.inputs.duration}; give it 0 or more seconds")
    return whole
