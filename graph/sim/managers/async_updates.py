"""Updates awaited from asyncio: all who wait share the next update, and waiting is what makes it run.

No loop of ours runs in the background. The first one to wait puts an update at the end of asyncio's queue; whoever
waits before it runs joins in, and all resume after it in the order in which they came. An App that is driven this way
therefore does the same in every run, as long as its coroutines wait for nothing outside it.
"""

from __future__ import annotations

import asyncio

from graph.sim.update_loop import UpdateLoop

_LAST = 1 << 30


class AsyncUpdates:
    """The coroutines that wait for an App's next update."""

    def __init__(self, updates: UpdateLoop) -> None:
        self._updates = updates
        self._waiting: list[asyncio.Future[float]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._scheduled = False
        self._listening = False

    async def next(self) -> float:
        """Resumes after the next update, whoever runs it; its loop dt [s]. Raises what that update raised."""
        loop = asyncio.get_running_loop()
        if not self._listening:
            self._listening = True
            self._updates.phases.on("end", self._updated, _LAST)
        if loop is not self._loop:  # what an ended loop had scheduled never runs
            self._loop, self._scheduled, self._waiting = loop, False, []
        future: asyncio.Future[float] = loop.create_future()
        self._waiting.append(future)
        if not self._scheduled:
            self._scheduled = True
            loop.call_soon(self._drive)
        return await future

    def _drive(self) -> None:
        self._scheduled = False
        if all(future.done() for future in self._waiting):  # somebody ran an update meanwhile, or they gave up
            self._waiting.clear()
            return
        try:
            self._updates.update()
        except BaseException as error:
            waiting, self._waiting = self._waiting, []
            for future in waiting:
                if not future.done():
                    future.set_exception(error)
            if not isinstance(error, Exception):
                raise

    def _updated(self) -> None:
        if not self._waiting:
            return
        waiting, self._waiting = self._waiting, []
        dt = float(self._updates.run_loop.dt)
        for future in waiting:
            if not future.done():
                future.set_result(dt)
