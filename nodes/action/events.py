"""Event nodes: the starts of walks through an action graph."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

TIME = Attribute("double", "timeline time", unit="s", role="timeline time")
FRAME = Attribute("double", "timeline time as a frame number", unit="frames")
ONLY_PLAYBACK = Attribute("bool", "ignore events while the timeline does not play", default=True, literal_only=True)


@node_type(
    "omni.graph.action.OnPlaybackTick",
    version=2,
    event=True,
    outputs={
        "tick": Attribute("execution", "fires in every update while the timeline plays"),
        "deltaSeconds": Attribute("double", "what the timeline moved since the previous update", unit="s"),
        "time": TIME,
        "frame": FRAME,
    },
)
def on_playback_tick(db: Database) -> bool:
    """Fire in every update while the timeline plays."""
    context = db.context
    if not context.is_playing:
        return False
    outputs = db.outputs
    outputs.deltaSeconds = float(context.delta)
    outputs.time = context.time
    outputs.frame = context.frame
    db.fire("tick")
    return True


@node_type(
    "omni.graph.action.OnTick",
    version=2,
    event=True,
    inputs={
        "framePeriod": Attribute(
            "uint", "updates to leave out between two firings", default=0, literal_only=True, unit="updates"
        ),
        "onlyPlayback": ONLY_PLAYBACK,
    },
    outputs={
        "tick": Attribute("execution", "fires in every (framePeriod + 1)-th update, the first one included"),
        "deltaSeconds": Attribute("double", "update time since the previous firing, playing or not", unit="s"),
        "time": TIME,
        "frame": FRAME,
        "timeSinceStart": Attribute(
            "double", "time since the App was made, playing or not", unit="s", role="loop time"
        ),
        "absoluteSimTime": Attribute(
            "double", "time of all updates so far; a stop does not reset it", unit="s", role="loop time"
        ),
        "isPlaying": Attribute("bool", "whether the timeline plays"),
    },
    state={
        "accumulatedSeconds": Attribute(
            "double", "update time gathered since the previous firing", default=0.0, unit="s"
        ),
        "frameCount": Attribute("uint", "updates since the previous firing", default=0, unit="updates"),
    },
)
def on_tick(db: Database) -> bool:
    """Fire in the first eligible update and then in every (framePeriod + 1)-th; accumulates the time in between."""
    context, state, outputs = db.context, db.state, db.outputs
    if db.inputs.onlyPlayback and not context.is_playing:
        return False
    gathered = state.accumulatedSeconds + context.delta_seconds
    count = state.frameCount
    state.frameCount = count + 1 if count < db.inputs.framePeriod else 0
    if count:
        state.accumulatedSeconds = gathered
        return False
    state.accumulatedSeconds = 0.0
    outputs.deltaSeconds = gathered
    outputs.time = context.time
    outputs.frame = context.frame
    outputs.timeSinceStart = context.time_since_start
    outputs.absoluteSimTime = context.absolute_sim_time
    outputs.isPlaying = context.is_playing
    db.fire("tick")
    return True


@node_type(
    "omni.graph.action.OnImpulseEvent",
    version=3,
    event=True,
    inputs={"onlyPlayback": ONLY_PLAYBACK},
    outputs={"execOut": Attribute("execution", "fires once for an impulse")},
    state={"enableImpulse": Attribute("bool", "set it to fire at the next evaluation; falls back by itself")},
)
def on_impulse_event(db: Database) -> bool:
    """Fire once after `state:enableImpulse` was set, even if it was set several times."""
    if not db.state.enableImpulse or (db.inputs.onlyPlayback and not db.context.is_playing):
        return False
    db.state.enableImpulse = False
    db.fire("execOut")
    return True
