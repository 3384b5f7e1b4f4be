"""Distributions and triggers of `omni.replicator.core`: what is drawn, and in which captured frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import accumulate
from math import floor
from typing import Any, ClassVar

import numpy as np

from graph.isaac.outcomes import Refusing
from graph.isaac.session import app, kit, warn
from graph.spec.distributions import Stream, parse

CORE = "omni.replicator.core"
MISSING_DRAW = "this distribution is not here; use uniform, normal, log_uniform, choice, sequence or combine"
MISSING_TRIGGER = "this trigger is not here; use on_frame, on_time or on_custom_event"


class Draw:
    """A distribution: each draw is the next value of its own stream, which the seeds and the script's order decide."""

    def __init__(self, draw: Callable[[Stream], Any], seed: int | None) -> None:
        self._draw, self._seed = draw, seed
        self._number = triggers().count_draw()
        self._stream: Stream | None = None

    def next(self) -> Any:
        """The next value."""
        if self._stream is None:
            own = self._seed is not None and self._seed >= 0
            seed = self._seed if own else triggers().seed
            self._stream = Stream(int(seed or 0), "replicator" if own else f"replicator {self._number}")
        return self._draw(self._stream)


def drawn(value: Any) -> Any:
    """A value to set: a distribution's next one, or the value itself."""
    return value.next() if isinstance(value, Draw) else value


def is_random(values: Iterable[Any]) -> bool:
    """Whether one of them is a distribution."""
    return any(isinstance(one, Draw) for one in values)


def _numbers(value: Any) -> Any:
    return value if np.ndim(value) == 0 else np.asarray(value, float).tolist()


class Distributions(Refusing):
    """`distribution.uniform((0, 0, 0), (1, 1, 1))`: a number, or one for each element."""

    def uniform(self, lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: Any = None) -> Draw:
        return _between("uniform", np.minimum(lower, upper), np.maximum(lower, upper), seed)

    def log_uniform(
        self, lower: Any, upper: Any, num_samples: int = 1, seed: int | None = None, name: Any = None
    ) -> Draw:
        return _between("loguniform", np.minimum(lower, upper), np.maximum(lower, upper), seed)

    def normal(self, mean: Any, std: Any, num_samples: int = 1, seed: int | None = None, name: Any = None) -> Draw:
        return _between("normal", mean, std, seed)

    def choice(
        self,
        choices: Any,
        weights: Any = None,
        num_samples: int = 1,
        seed: int | None = None,
        with_replacements: bool = True,
        name: Any = None,
    ) -> Draw:
        items = list(choices)
        if not items or (weights is not None and len(weights) != len(items)):
            raise ValueError(f"{CORE}.distribution.choice: give choices, and one weight for each or none")
        ends = list(accumulate(map(float, weights or [1.0] * len(items))))

        def draw(stream: Stream) -> Any:
            at = stream.unit() * ends[-1]
            return items[next(index for index, end in enumerate(ends) if at < end)]

        return Draw(draw, seed)

    def sequence(self, items: Any, ordered: bool = True, seed: int | None = None, name: Any = None) -> Draw:
        if not ordered:
            return self.choice(items, seed=seed)
        listed, places = list(items), iter(range(2**62))
        return Draw(lambda _: listed[next(places) % len(listed)], seed)

    def combine(self, distributions: Any, name: Any = None) -> Draw:
        parts = list(distributions)
        return Draw(lambda _: [one for part in parts for one in np.ravel(drawn(part)).tolist()], None)


def _between(kind: str, first: Any, second: Any, seed: int | None) -> Draw:
    return Draw(parse(f"{kind}({_numbers(first)}, {_numbers(second)})").draw, seed)


class Trigger:
    """What happens in captured frames: the calls inside its `with` block, each with its next values.

    due: whether it acts in a frame, from the number of captured frames so far. most: how often it acts; 0: no limit.
    """

    opened: ClassVar[list[Trigger]] = []

    def __init__(self, due: Callable[[int], bool], most: int = 0) -> None:
        self._due, self._most, self._done = due, most, 0
        self.actions: list[Callable[[], None]] = []
        triggers().add(self)

    def __enter__(self) -> Trigger:
        Trigger.opened.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        Trigger.opened.pop()

    @property
    def over(self) -> bool:
        """Whether it has acted as often as it may."""
        return 0 < self._most <= self._done

    @property
    def finite(self) -> bool:
        """Whether it ends by itself."""
        return self._most > 0

    def fire(self, frame: int) -> None:
        """Acts in a captured frame, if it is due."""
        if not self.over and self._due(frame):
            self._done += 1
            for act in self.actions:
                act()


def each_frame(act: Callable[[], None], *, now: bool = True) -> None:
    """Runs an action in the frames of the trigger whose `with` block is open; without one at once, if `now`."""
    if Trigger.opened:
        Trigger.opened[-1].actions.append(act)
    elif now:
        act()


class Triggers:
    """The triggers of an App: they act at the start of each update whose frames are captured."""

    def __init__(self) -> None:
        self.seed = app().seed
        self.events: set[str] = set()
        """Custom events sent since the last captured frame."""
        self._all: list[Trigger] = []
        self._draws = self._frame = 0
        app().on("timeline_state", self._fire, 1)
        app().on("stage_closing", self._all.clear)

    def count_draw(self) -> int:
        """The number of a new distribution."""
        self._draws += 1
        return self._draws

    def add(self, trigger: Trigger) -> None:
        """Takes in a trigger."""
        self._all.append(trigger)

    @property
    def finite(self) -> bool:
        """Whether there are triggers that end by themselves."""
        return any(one.finite for one in self._all)

    @property
    def over(self) -> bool:
        """Whether all triggers that end by themselves are over, and there is one."""
        return self.finite and all(one.over for one in self._all if one.finite)

    def _fire(self) -> None:
        if app().rendering.stepped:
            for one in self._all:
                one.fire(self._frame)
            self._frame += 1
            self.events.clear()


def triggers() -> Triggers:
    """Those of the present App."""
    return kit().singleton(Triggers, Triggers)


class TriggerMakers(Refusing):
    """`with trigger.on_frame(num_frames=10):`."""

    def on_frame(
        self,
        max_execs: int = 0,
        interval: int = 1,
        num_frames: int | None = None,
        rt_subframes: int = 1,
        name: Any = None,
    ) -> Trigger:
        if rt_subframes > 1:
            warn("rt-subframes-ignored", f"{CORE}.trigger", "ideal sensors have nothing to converge")
        return Trigger(
            lambda frame: frame % max(int(interval), 1) == 0, max_execs if num_frames is None else num_frames
        )

    def on_time(
        self, interval: float, max_execs: int = 0, num: int | None = None, rt_subframes: int = 1, name: Any = None
    ) -> Trigger:
        """Acts whenever another interval [s] of the timeline is over."""
        if interval <= 0:
            raise ValueError(f"{CORE}.trigger.on_time: interval {interval} s; give a time above 0")
        period, last = Fraction(str(interval)), [-1]

        def due(_: int) -> bool:
            passed = floor(Fraction(app().timeline.current_time) / period)
            before, last[0] = last[0], passed
            return passed != before

        return Trigger(due, max_execs if num is None else num)

    def on_custom_event(self, event_name: str, max_execs: int = 0) -> Trigger:
        return Trigger(lambda _: event_name in triggers().events, max_execs)


distribution = Distributions(f"{CORE}.distribution", MISSING_DRAW)
trigger = TriggerMakers(f"{CORE}.trigger", MISSING_TRIGGER)
