"""The turns of a lidar: one firing pattern for all of them, or several that alternate with its emitter states."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from fractions import Fraction

from graph.base.sharing import Shared

from .config import LidarConfig
from .pattern import Pattern, firing_pattern

MOST_KEPT_RAYS = 8_000_000
"""Most rays of patterns that are kept; a pattern that repeats after more rays is computed again."""

_shared: Shared[LidarConfig, Turns] = Shared()


def turns_of(config: LidarConfig) -> Turns:
    """The turns of a configuration; all lidars of this process that have the same, but for its name, share them."""
    return _shared.of(replace(config, name=""), lambda: Turns(config))


class Turns:
    """The pattern of each turn of a lidar.

    Emitter states continue from turn to turn: if the ticks of a turn are not a whole number of rounds of the states,
    the next turn begins in another state, and the patterns repeat after `count` turns. period: one turn [s].
    """

    def __init__(self, config: LidarConfig) -> None:
        self.period: Fraction = 1 / config.scan_rate_base_hz
        ticks, round_ = config.ticks_per_scan, config.emitter_state_count * max(1, config.state_resolution_step)
        self.count = math.lcm(ticks, round_) // ticks
        self.kept = max(1, min(self.count, MOST_KEPT_RAYS // max(1, config.rays_per_scan)))
        """The number of turns for which data of their patterns is kept."""
        self._pattern = functools.lru_cache(self.kept)(functools.partial(firing_pattern, config))

    def number(self, turn: int) -> int:
        """Turns of the same number have the same pattern."""
        return turn % self.count

    def pattern(self, turn: int) -> Pattern:
        """The firings of a turn."""
        return self._pattern(self.number(turn))

    def slices(self, start: Fraction, end: Fraction, *, whole_turns: int = 0) -> list[tuple[int, slice]]:
        """(turn, rows) of the firings at times in [start, end) [s since play], oldest first.

        Turn t covers [t, t + 1) periods. An interval longer than a turn keeps its last turn; with `whole_turns` = n it
        keeps the last n turns that end in it, and what follows them.
        """
        kept_from = (end // self.period - whole_turns) * self.period if whole_turns else end - self.period
        start = max(start, kept_from)
        if end <= start:
            return []
        first, last = start // self.period, end // self.period
        found = []
        for turn in range(first, last + 1):
            pattern = self.pattern(turn)
            low = pattern.index_at(start - turn * self.period) if turn == first else 0
            high = pattern.index_at(end - turn * self.period) if turn == last else len(pattern)
            if high > low:
                found.append((turn, slice(low, high)))
        return found
