"""Events of the stage and the session: play, stop, the first evaluation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

from .events import ONLY_PLAYBACK
from .inboxes import Listening, close_inbox, ignored, inbox_of
from .notices import StageWatch

HIERARCHY = "Hierarchy Changed"
STAGE_EVENTS = (
    "Saved",
    "Selection Changed",
    HIERARCHY,
    "OmniGraph Start Play",
    "OmniGraph Stop Play",
    "Simulation Start Play",
    "Simulation Stop Play",
    "Animation Start Play",
    "Animation Stop Play",
)


@node_type(
    "omni.graph.action.OnLoaded",
    version=2,
    event=-2,
    outputs={"execOut": Attribute("execution", "fires once, ahead of all other events")},
)
def on_loaded(db: Database) -> bool:
    """Fire in the first evaluation of the graph and never again, not even after a stop."""
    if db.node.computes > 1:
        return False
    db.fire("execOut")
    return True


@dataclass(slots=True)
class StageListening(Listening):
    """An inbox, and, for changes of the hierarchy, the function that ends the watch of the stage."""

    stop: Callable[[], None] | None = None


def _release(db: Database) -> None:
    close_inbox(db)
    if db.memory.stop is not None:
        db.memory.stop()
        db.memory.stop = None


@node_type(
    "omni.graph.action.OnStageEvent",
    version=4,
    event=True,
    inputs={
        "eventName": Attribute("token", "which event", default="", literal_only=True, allowed_tokens=STAGE_EVENTS),
        "onlyPlayback": ONLY_PLAYBACK,
    },
    outputs={"execOut": Attribute("execution", "fires once per evaluation, however often the event came")},
    memory=StageListening,
    release=_release,
)
def on_stage_event(db: Database) -> bool:
    """Fire after an event of the stage: play, stop, prims added or removed. Pause and resume do not fire.

    Events of stopping come when the timeline no longer plays: they need `onlyPlayback` false. "Saved" and "Selection
    Changed" come only from a script (`stage:Saved` on the event bus).
    """
    name = db.inputs.eventName
    if not name:
        return False
    inbox = inbox_of(db, f"stage:{name}")
    if name == HIERARCHY and db.memory.stop is None and db.context.app is not None:
        db.memory.stop = _watch_hierarchy(db.context.app.stage, db.context.events)
    if not inbox.take_all(db.context.update) or ignored(db):
        return False
    db.fire("execOut")
    return True


def _watch_hierarchy(stage: Any, events: Any) -> Callable[[], None]:
    """Sends an event whenever prims are added or removed or change their type; returns the function that ends this."""

    def told(notice: Any) -> None:
        if any(path.IsPrimPath() for path in notice.GetResyncedPaths()):
            events.send(f"stage:{HIERARCHY}")

    return StageWatch(stage, told)
