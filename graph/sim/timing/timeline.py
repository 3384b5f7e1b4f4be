"""The timeline: play, pause and stop, and a time that advances once per app update.

play/pause/stop take effect in the next update, or at once through `commit()`. Variable stepping advances by the loop's
dt; fixed stepping (`/app/player/useFixedTimeStepping`, read when playing starts) by 1 / timeCodesPerSecond in every
accepted update: one in N = ceil(targetFramerate / timeCodesPerSecond), the first after play included, or all of them in
fast mode. Each advance is one tick, or `/app/player/timelineSubsampleRate` equal ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Literal

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import UserError
from graph.base.suggesting import Suggesting
from graph.sim import settings as keys
from graph.sim.settings import Settings

from .clocks import Counter

State = Literal["stopped", "playing", "paused"]
Change = Literal["play", "resume", "pause", "stop"]
Tick = Callable[[Fraction, Fraction], object]
"""Takes the time of a tick and the advance since the tick before, both in seconds."""
DEFAULT_END_TIME_CODE = 1_000_000


class Timeline(Suggesting):
    """The timeline of one App: an exact time between a start and an end, where it loops back to the start, or stops.

    `on_change` is called with each state change at the moment it takes effect, `on_stop` with each request to stop.
    """

    def __init__(self, settings: Settings, on_change: Callable[[Change], None] | None = None) -> None:
        self.delta = Fraction(0)
        """The advance of the time in the last update [s]; 0 while not playing and in updates that were skipped."""
        self.overwritten_rate_limit: Fraction | None = None
        """The user's limit [Hz] that play in fixed stepping replaced, if the settings say so."""
        self.silent = False
        """Whether the change that takes effect right now is without events (`commit_silently`)."""
        self._settings = settings
        self.on_change = on_change or _ignore
        self.on_stop: Callable[[], None] = _nothing
        self._state: State = "stopped"
        self._pending: list[State] = []
        self._rate = settings.rate(keys.TIME_CODES_PER_SECOND)
        self._start, self._end = Fraction(0), DEFAULT_END_TIME_CODE / self._rate
        self._looping = True
        self._clock = Counter(Fraction(1, 60))
        # The count of the clock's present segment beyond which the end time is passed.
        self._limit = 0
        self._limit_base: Fraction | None = None
        self._limit_step: Fraction | None = None
        self._auto_update = True
        self._fixed = False
        self._skipped = 0
        self._skips = 0
        self._frame_step = 1 / self._rate
        self._ticks: tuple[Tick, ...] = ()
        for path in (keys.FAST_MODE, keys.TARGET_FRAMERATE):
            settings.subscribe(path, lambda value: self._count_skips())
        self._count_skips()

    @property
    def current_time(self) -> Fraction:
        """The exact time [s]."""
        return self._clock.time

    def get_current_time(self) -> float:
        """The time [s]."""
        return float(self._clock.time)

    def set_current_time(self, time: float | Fraction) -> None:
        """Moves to `time` [s]. Raises ValueError below 0 and before the start."""
        moment = exact.duration(time)
        if moment < min(self._start, Fraction(0)):
            raise ValueError(f"current time {float(moment):g} s: give 0 s or more")
        self._clock.set(moment)

    @property
    def start_time(self) -> Fraction:
        """The exact time [s] to which stop and loops return."""
        return self._start

    def get_start_time(self) -> float:
        """The time [s] to which stop and loops return."""
        return float(self._start)

    def set_start_time(self, time: float | Fraction) -> None:
        """Sets the start [s]."""
        self._start = exact.duration(time)

    @property
    def end_time(self) -> Fraction:
        """The exact time [s] at which the timeline loops or stops."""
        return self._end

    def get_end_time(self) -> float:
        """The time [s] at which the timeline loops or stops."""
        return float(self._end)

    def set_end_time(self, time: float | Fraction) -> None:
        """Sets the end [s]."""
        self._end = exact.duration(time)
        self._limit_base = None

    def set_range(self, start: Fraction, end: Fraction) -> None:
        """Plays from `start` to `end` [s], and moves to the start."""
        self._start, self._end = start, end
        self._limit_base = None
        self._clock.set(start)

    def is_looping(self) -> bool:
        """Whether it returns to the start at the end; otherwise it stops."""
        return self._looping

    def set_looping(self, looping: bool) -> None:
        """Chooses what happens at the end."""
        self._looping = looping

    def play(self) -> None:
        """Requests playing from the next update (or `commit()`) on."""
        self._pending.append("playing")

    def pause(self) -> None:
        """Requests a pause: times hold, nothing resets."""
        self._pending.append("paused")

    def stop(self) -> None:
        """Requests a stop: the time returns to the start time, the world to its state before play."""
        self._pending.append("stopped")
        self.on_stop()

    def commit(self) -> None:
        """Applies the requests now, with callbacks."""
        while self._pending:
            self._enter(self._pending.pop(0))

    def close(self) -> None:
        """Ends all callbacks."""
        self.on_change, self.on_stop = _ignore, _nothing

    def commit_silently(self) -> None:
        """Applies the requests now; `silent` is True during the callbacks."""
        self.silent = True
        try:
            self.commit()
        finally:
            self.silent = False

    def is_playing(self) -> bool:
        """Whether the time advances."""
        return self._state == "playing"

    def will_play(self) -> bool:
        """Whether the time advances once the requests are applied."""
        return (self._pending or [self._state])[-1] == "playing"

    def is_stopped(self) -> bool:
        """Whether the world is in its authored state."""
        return self._state == "stopped"

    def is_paused(self) -> bool:
        """Neither playing nor stopped."""
        return self._state == "paused"

    def set_auto_update(self, auto_update: bool) -> None:
        """False: the time does not advance while playing."""
        self._auto_update = auto_update

    def is_auto_updating(self) -> bool:
        """Whether the time advances while playing."""
        return self._auto_update

    def forward_one_frame(self) -> None:
        """Advances by 1 / timeCodesPerSecond, playing or not."""
        self._move(self._frame_step)

    def rewind_one_frame(self) -> None:
        """Moves back by 1 / timeCodesPerSecond, not before the start."""
        self._clock.set(max(self._start, self._clock.time - self._frame_step))

    @property
    def time_codes_per_second(self) -> Fraction:
        """The exact rate [Hz] that turns seconds into time codes."""
        return self._rate

    def get_time_codes_per_second(self) -> float:
        """Time codes per second [Hz]."""
        return float(self._rate)

    get_time_codes_per_seconds = get_time_codes_per_second

    def set_time_codes_per_second(self, rate: float | Fraction) -> None:
        """Sets the rate [Hz]; times in seconds stay."""
        self._rate = _positive(rate, "timeCodesPerSecond")
        self._frame_step = 1 / self._rate
        self._count_skips()

    def get_target_framerate(self) -> float:
        """The target frame rate [Hz] of fixed stepping."""
        return float(self._settings.rate(keys.TARGET_FRAMERATE))

    def set_target_framerate(self, rate: float | Fraction) -> None:
        """Sets the target frame rate [Hz] of fixed stepping."""
        self._settings.set(keys.TARGET_FRAMERATE, _plain(_positive(rate, "targetFramerate")))

    def set_play_every_frame(self, every_frame: bool) -> None:
        """Fast mode: fixed stepping accepts every update."""
        self._settings.set(keys.FAST_MODE, every_frame)

    def get_play_every_frame(self) -> bool:
        """Whether fixed stepping accepts every update."""
        return bool(self._settings.get(keys.FAST_MODE))

    set_fast_mode, get_fast_mode = set_play_every_frame, get_play_every_frame

    def on_tick(self, callback: Tick) -> Callable[[], None]:
        """Calls `callback(time, delta)` [s] at each tick of each update that advances the time.

        Returns a function that ends it. An update has `get_ticks_per_frame()` ticks, each for an equal part of its
        advance.
        """
        check_callable(callback, "timeline.on_tick(callback)")
        self._ticks = (*self._ticks, callback)

        def unsubscribe() -> None:
            self._ticks = tuple(kept for kept in self._ticks if kept is not callback)

        return unsubscribe

    def set_ticks_per_frame(self, ticks: int) -> None:
        """Sets the number of tick events per frame."""
        if exact.count(ticks, "ticks per frame") < 1:
            raise ValueError(f"ticks per frame {ticks}: give 1 or more")
        self._settings.set(keys.TICKS_PER_FRAME, ticks)

    def get_ticks_per_frame(self) -> int:
        """Tick events per frame."""
        return int(self._settings.get(keys.TICKS_PER_FRAME))

    @property
    def updates_per_frame(self) -> int:
        """N of fixed stepping: one update in N is accepted."""
        return self._skips + 1

    def advance(self, dt: Fraction) -> Fraction:
        """One update whose loop dt is `dt` [s]; returns the advance of the time (0 unless playing and accepted)."""
        if self._state != "playing" or not self._auto_update:
            self.delta = _ZERO
        elif not self._fixed:
            self.delta = dt
            self._move(dt)
        elif self._skipped:
            self._skipped -= 1
            self.delta = _ZERO
        else:
            self._skipped = self._skips
            self.delta = self._frame_step
            self._move(self._frame_step)
        if self._ticks and self.delta:
            self._tell_ticks()
        return self.delta

    def _move(self, step: Fraction) -> None:
        clock = self._clock
        clock.advance(step)
        if clock.base is not self._limit_base or step is not self._limit_step:
            self._limit_base, self._limit_step = clock.base, clock.step
            self._limit = math.floor((self._end - clock.base) / clock.step)
        if clock.count > self._limit:
            self._at_end()

    def _at_end(self) -> None:
        length = self._end - self._start
        if self._looping and length > 0:
            self._clock.set(self._start + (self._clock.time - self._start) % length)
        else:
            self._clock.set(self._end)
            self.stop()

    def _tell_ticks(self) -> None:
        count = self.get_ticks_per_frame()
        step, end = self.delta / count, self._clock.time
        for left in range(count - 1, -1, -1):
            time = end - left * step
            if time <= self._start and self._looping and left:  # before the end returned it to the start
                time += self._end - self._start
            for callback in self._ticks:
                callback(time, step)

    def _count_skips(self) -> None:
        fast = self._settings.get(keys.FAST_MODE)
        self._skips = 0 if fast else math.ceil(self._settings.rate(keys.TARGET_FRAMERATE) / self._rate) - 1
        self._skipped = min(self._skipped, self._skips)

    def _enter(self, state: State) -> None:
        before = self._state
        if state == before or (state == "paused" and before == "stopped"):
            return
        self._state = state
        if state == "playing" and before == "stopped":
            self._prepare_stepping()
        if state == "stopped":
            self._clock.set(self._start)
            self.delta = _ZERO
        try:
            self.on_change(_CHANGES.get((before, state), _CHANGES[None, state]))
        except BaseException:
            if before == "stopped":  # a world that cannot be built does not play
                self._state = before
            raise

    def _prepare_stepping(self) -> None:
        self._fixed = bool(self._settings.get(keys.FIXED_STEPPING))
        self._skipped = 0
        if self._fixed and self._settings.get(keys.REWRITE_RATE_LIMIT):
            frequency = math.ceil(self._settings.rate(keys.TARGET_FRAMERATE) / self._rate) * self._rate  # N x rate
            before = self._settings.rate(keys.RATE_LIMIT_FREQUENCY)
            users = self._settings.is_authored(keys.RATE_LIMIT_FREQUENCY)
            self.overwritten_rate_limit = before if users and before != frequency else None
            write = self._settings.set if users else self._settings.set_default
            write(keys.RATE_LIMIT_FREQUENCY, _plain(frequency))


_ZERO = Fraction(0)
_CHANGES: dict[tuple[State | None, State], Change] = {
    (None, "playing"): "play",
    ("paused", "playing"): "resume",
    (None, "paused"): "pause",
    (None, "stopped"): "stop",
}


def _nothing() -> None:
    """Does nothing."""


def _ignore(change: Change) -> None:
    """Ignores a change."""


def _positive(rate: float | Fraction, what: str) -> Fraction:
    value = exact.rate(rate)
    if value <= 0:
        raise UserError(f"{what} {rate}: give a rate above 0 Hz")
    return value


def _plain(rate: Fraction) -> int | Fraction:
    return rate.numerator if rate.denominator == 1 else rate
