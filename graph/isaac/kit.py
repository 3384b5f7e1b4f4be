"""What Kit has beside the App: event streams, one asyncio loop, singletons that end with the stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakKeyDictionary

from .events import Dispatcher, EventStream
from .loops import made_loop, script_loop
from .run import RUN

if TYPE_CHECKING:
    import asyncio

    from .managers.app import App

T = TypeVar("T")
PLAY, PAUSE, STOP, TICKED = 0, 1, 2, 5
FIRST, LAST = -(1 << 29), 1 << 29


class Kit:
    """Beside one App. Held as long as the App."""

    def __init__(self, app: App) -> None:
        from .modules.own_schemas import take_own_schemas

        take_own_schemas()
        self.app = app
        self.pre_update, self.update_stream, self.post_update = EventStream(), EventStream(), EventStream()
        self.timeline_events, self.stage_events, self.messages = EventStream(), EventStream(), EventStream()
        self.other_events = EventStream()
        self.dispatcher = Dispatcher()
        self.singletons: dict[Any, Any] = {}
        """Objects of which a stage has one: World, SimulationContext."""
        self.viewports: list[Any] = []
        """The viewports that a script has asked for."""
        self.stage_url = ""
        self.stage_closed = False
        """Whether the script closed the stage and has not opened another."""
        app.on("timeline_state", self._begin, FIRST)
        app.on("end", self._end, LAST)
        for event, kind in (("play", PLAY), ("resume", PLAY), ("pause", PAUSE), ("stop", STOP)):
            app.on(event, self._timeline(kind))
        app.timeline.on_tick(lambda time, delta: self._ticked(float(time), float(delta)))
        self._of_script = RUN.get() is not None
        self._own: asyncio.AbstractEventLoop | None = None

    @property
    def loop(self) -> asyncio.AbstractEventLoop:
        """The loop in which coroutines of scripts run, one turn after each update; made at its first use."""
        if self._of_script:
            return script_loop()
        if self._own is None:
            import asyncio

            self._own = asyncio.new_event_loop()
        return self._own

    @property
    def _made(self) -> asyncio.AbstractEventLoop | None:
        """The loop, if anything has used it."""
        return made_loop() if self._of_script else self._own

    def update(self) -> None:
        """One app update, and one turn of the asyncio loop after it."""
        run = RUN.get()
        if run is not None:
            run.check()
        self.app.update()
        self.turn()

    def turn(self) -> None:
        """Runs what is ready in the asyncio loop once; nothing inside a coroutine, which waits for its own update."""
        loop = self._made
        if loop is None or loop.is_closed() or loop.is_running():
            return
        import asyncio

        try:
            asyncio.get_running_loop()
        except RuntimeError:
            loop.call_soon(loop.stop)
            loop.run_forever()

    async def next_update(self) -> float:
        """Waits for the next update."""
        run = RUN.get()
        if run is not None:
            run.check()
        return await self.app.next_update_async()

    def finish(self, coroutine: Any) -> Any:
        """Runs a coroutine to its end, with the updates that it waits for."""
        return self.loop.run_until_complete(coroutine)

    def tasks(self) -> set[asyncio.Task[Any]]:
        """The script's tasks in the loop that are not done."""
        loop = self._made
        if loop is None or loop.is_closed():
            return set()
        import asyncio

        return asyncio.all_tasks(loop)

    def singleton(self, kind: Any, make: Callable[[], T]) -> T:
        """The one object of its kind, made at first use."""
        if kind not in self.singletons:
            self.singletons[kind] = make()
        found: T = self.singletons[kind]
        return found

    def _begin(self) -> None:
        self.pre_update.push(payload={"dt": self._dt()})
        self.pre_update.pump()

    def _end(self) -> None:
        payload = {"dt": self._dt()}
        for stream, name in (
            (self.update_stream, "omni.kit.app:update"),
            (self.post_update, "omni.kit.app:post_update"),
        ):
            stream.push(payload=payload)
            stream.pump()
            self.dispatcher.dispatch_event(name, payload)
        for stream in (self.messages, self.stage_events, self.other_events):
            stream.pump()

    def _dt(self) -> float:
        return float(self.app.run_loop.dt)

    def _timeline(self, kind: int) -> Callable[[], None]:
        names = {PLAY: "omni.timeline:play", PAUSE: "omni.timeline:pause", STOP: "omni.timeline:stop"}

        def tell() -> None:
            if self.app.timeline.silent:
                return
            self.timeline_events.dispatch(kind)
            self.dispatcher.dispatch_event(names[kind], {})

        return tell

    def _ticked(self, time: float, delta: float) -> None:
        payload = {"currentTime": time, "dt": delta}
        self.timeline_events.dispatch(TICKED, payload=payload)
        self.dispatcher.dispatch_event("omni.timeline:current_time_ticked", payload)


_KITS: WeakKeyDictionary[Any, Kit] = WeakKeyDictionary()


def kit_of(app: App) -> Kit:
    """The Kit beside an App, made at first use."""
    found = _KITS.get(app)
    if found is None:
        found = _KITS[app] = Kit(app)
        app.on("close", lambda: _KITS.pop(app, None), LAST)
    return found
