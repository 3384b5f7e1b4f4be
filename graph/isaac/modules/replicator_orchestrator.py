"""`orchestrator` of `omni.replicator.core`: what is captured, and when."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from itertools import count

from graph.isaac.run import RUN
from graph.isaac.session import app, kit
from graph.sim import settings as keys

from .replicator_draws import triggers


class _Status(Enum):
    NOT_STARTED = 0
    STARTING = 1
    STARTED = 2
    PAUSED = 3
    STOPPING = 4
    STOPPED = 5


class _Orchestrator:
    Status = _Status

    def __init__(self) -> None:
        self._status = _Status.NOT_STARTED
        self._looping = False
        """Whether a call of `run` is counting its frames."""

    def step(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | None = None,
        wait_for_render: bool = True,
    ) -> None:
        run = RUN.get()
        if run is not None:
            run.check()
        app().orchestrator.step(rt_subframes, pause_timeline, delta_time, wait_for_render)
        kit().turn()

    async def step_async(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | None = None,
        wait_for_render: bool = True,
    ) -> None:
        await app().orchestrator.step_async(rt_subframes, pause_timeline, delta_time, wait_for_render)

    def preview(self) -> None:
        kit().update()

    async def preview_async(self) -> None:
        await kit().next_update()

    def run(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        """Captures a frame in each update until the triggers that end are over.

        While the timeline does not play, and in a snippet, it captures all of them at once; else further updates do.
        """
        self._start(start_timeline)
        run = RUN.get()
        at_once = not app().timeline.is_playing() or (run is not None and run.from_editor)
        for _ in self._frames(num_frames, whole=at_once):
            self._capture()

    async def run_async(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames, whole=not app().timeline.is_playing()):
            await self._capture_async()

    def run_until_complete(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames):
            self._capture()
        self._turn(_Status.STOPPED)

    async def run_until_complete_async(self, num_frames: int | None = None, start_timeline: bool = False) -> None:
        self._start(start_timeline)
        for _ in self._frames(num_frames):
            await self._capture_async()
        self._turn(_Status.STOPPED)

    def _frames(self, most: int | None, *, whole: bool = True) -> Iterator[int]:
        """Counts frames: `most`; or, if `whole`, until the triggers that end are over; else one."""
        whole = whole and most is None and triggers().finite
        self._looping = True
        try:
            for number in count():
                if (triggers().over if whole else number >= (most or 1)) or not self.get_is_started():
                    return
                yield number
        finally:
            self._looping = False
            app().rendering.stepped = self.get_is_started() and not triggers().over

    def _capture(self) -> None:
        """One frame, of the world at rest unless the timeline plays."""
        if app().timeline.is_playing():
            kit().update()
        else:
            self.step(delta_time=0.0)

    async def _capture_async(self) -> None:
        if app().timeline.is_playing():
            await kit().next_update()
        else:
            await self.step_async(delta_time=0.0)

    def _end_if_over(self) -> None:
        if self._status is _Status.STARTED and triggers().over and not self._looping:
            self._turn(_Status.STOPPED)

    def _start(self, start_timeline: bool) -> None:
        if start_timeline:
            app().play()
        kit().singleton(_Orchestrator, lambda: app().on("end", self._end_if_over))
        self._turn(_Status.STARTED)

    def _turn(self, status: _Status) -> None:
        """The new status; while started, every update is a step of the orchestrator."""
        self._status, app().rendering.stepped = status, status is _Status.STARTED

    def stop(self) -> None:
        self._turn(_Status.STOPPED)

    def pause(self) -> None:
        self._turn(_Status.PAUSED)

    def resume(self) -> None:
        self._turn(_Status.STARTED)

    def wait_until_complete(self) -> None:
        app().deliver_frames()

    async def wait_until_complete_async(self) -> None:
        app().deliver_frames()

    def set_capture_on_play(self, value: bool) -> None:
        app().settings.set(keys.CAPTURE_ON_PLAY, bool(value))

    def get_status(self) -> _Status:
        return self._status

    def get_is_started(self) -> bool:
        return self._status is _Status.STARTED


orchestrator = _Orchestrator()
