"""Updates awaited from asyncio: all waiting coroutines share the next update, and waiting triggers it.

There is no background loop. The first coroutine that waits puts an update at the end of asyncio's queue; those that
wait before it runs share it, and all resume after it in the order in which they came. So an App that is driven this way
does the same in every run, as long as its coroutines wait for nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .update_loop import UpdateLoop

if TYPE_CHECKING:
    import asyncio

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
        """Resumes after the next update, called from anywhere; returns its loop dt [s].

        Raises what that update raised.
        """
        import asyncio  # a coroutine that waits has imported it; other Apps and checks need not

        loop = asyncio.get_running_loop()
        if not self._listening:
            self._listening = True
            self._updates.phases.on("end", self._updated, _LAST)
        if loop is not self._loop:  # an ended loop never runs what was scheduled on it
            self._loop, self._scheduled, self._waiting = loop, False, []
        future: asyncio.Future[float] = loop.create_future()
        self._waiting.append(future)
        if not self._scheduled:
            self._scheduled = True
            loop.call_soon(self._drive)
        return await future

    def _drive(self) -> None:
        self._scheduled = False
        if all(
            future.done() for future in self._waiting
        ):  # an update ran meanwhile, or the waiting coroutines were cancelled
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
