"""`omni.timeline`: the timeline of the App."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from graph.isaac.events import EventStream
from graph.isaac.outcomes import inert
from graph.isaac.parameters import renamed
from graph.isaac.session import app, kit

__all__ = [
    "GLOBAL_EVENT_CURRENT_TIME_TICKED",
    "GLOBAL_EVENT_PAUSE",
    "GLOBAL_EVENT_PLAY",
    "GLOBAL_EVENT_STOP",
    "ITimeline",
    "Timeline",
    "TimelineEventType",
    "acquire_timeline_interface",
    "get_timeline_interface",
]
GLOBAL_EVENT_PLAY, GLOBAL_EVENT_PAUSE = "omni.timeline:play", "omni.timeline:pause"
GLOBAL_EVENT_STOP = "omni.timeline:stop"
GLOBAL_EVENT_CURRENT_TIME_TICKED = "omni.timeline:current_time_ticked"
TimelineEventType = IntEnum(
    "TimelineEventType",
    "PLAY PAUSE STOP CURRENT_TIME_CHANGED CURRENT_TIME_TICKED_PERMANENT CURRENT_TIME_TICKED LOOP_MODE_CHANGED "
    "START_TIME_CHANGED END_TIME_CHANGED TIME_CODE_PER_SECOND_CHANGED AUTO_UPDATE_CHANGED PREROLLING_CHANGED "
    "TENTATIVE_TIME_CHANGED TICKS_PER_FRAME_CHANGED FAST_MODE_CHANGED TARGET_FRAMERATE_CHANGED "
    "TIMELINE_DIRECTION_CHANGED",
    start=0,
)


class _OfApp(type):
    """Calls that only the App's timeline has are those of its class."""

    def __getattr__(cls, name: str) -> Any:
        from graph.sim.timing.timeline import Timeline as Ours

        return getattr(Ours, name)


class Timeline(metaclass=_OfApp):
    """`app.timeline`, with what Kit has beside it; the same object for the life of a script."""

    def __getattr__(self, name: str) -> Any:
        return getattr(app().timeline, name)

    def play(self, start_timecode: float = 0, end_timecode: float = 0, looping: bool = True) -> None:
        app().timeline.play()

    def get_timeline_event_stream(self) -> EventStream:
        return kit().timeline_events

    def get_timeline_event_stream_by_type(self, _: Any = None) -> EventStream:
        return kit().timeline_events

    @inert("omni.timeline")
    def get_event_key(self) -> dict[str, Any]:
        return {}

    def time_to_time_code(self, time: float) -> float:
        return time * float(app().timeline.get_time_codes_per_second())

    def time_code_to_time(self, time_code: float) -> float:
        return time_code / float(app().timeline.get_time_codes_per_second())

    @inert("omni.timeline")
    def set_prerolling(self, _: bool) -> None:
        return None

    @inert("omni.timeline")
    def clear_tentative_time(self) -> None:
        return None

    @inert("omni.timeline")
    def set_tentative_time(self, time_in_seconds: float) -> None:
        return None


def _named() -> None:
    """Gives Timeline the setters of the App's timeline, with Kit's names of their parameters."""
    for name in (*_SETTERS, *_FLAGS):
        call = f"set_{name}"

        def setter(self: Timeline, value: Any, call: str = call) -> None:
            getattr(app().timeline, call)(value)

        setattr(Timeline, call, renamed(setter, call, "time_in_seconds" if name == "current_time" else name))


_SETTERS = ("start_time", "end_time", "current_time", "time_codes_per_second", "ticks_per_frame", "target_framerate")
_FLAGS = ("play_every_frame", "fast_mode")
_named()


class ITimeline:
    def get_timeline(self, name: str = "") -> Timeline:
        return _TIMELINE

    def __getattr__(self, name: str) -> Any:
        return getattr(_TIMELINE, name)


_TIMELINE = Timeline()


def get_timeline_interface(timeline_name: str = "") -> Timeline:
    return _TIMELINE


def acquire_timeline_interface(plugin_name: str | None = None, library_path: str | None = None) -> ITimeline:
    return ITimeline()
