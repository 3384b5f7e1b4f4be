"""The loop runner: the length of an update on the loop's clock, in Isaac Sim's calls."""

from __future__ import annotations

from fractions import Fraction

from graph.base import exact
from graph.base.suggesting import Suggesting
from graph.sim import settings as keys
from graph.sim.settings import Settings
from graph.sim.timing.clocks import checked_rate
from graph.sim.timing.run_loop import RunLoop

MAIN = "main"


class LoopRunner(Suggesting):
    """Manual stepping of an App's run loop. Mode and step size are independent; both act from the next update on.

    The only loop is named "main"; the name "" means all loops. Writing the setting
    `/app/runLoops/main/manualModeEnabled` changes dt one update later than `set_manual_mode`.
    """

    def __init__(self, run_loop: RunLoop, settings: Settings) -> None:
        self._run_loop, self._settings = run_loop, settings

    def set_manual_mode(self, enabled: bool = True, name: str = "") -> None:
        """True: every update lasts the manual step size; False: as long as the last one took on the wall clock."""
        _check(name)
        self._settings.set(keys.MANUAL_MODE, bool(enabled))
        self._run_loop.manual_mode = bool(enabled)

    def get_manual_mode(self, name: str = "") -> bool:
        """Whether updates last the manual step size."""
        _check(name)
        return self._run_loop.manual_mode

    def set_manual_step_size(self, dt: float | Fraction = 0.01667, name: str = "") -> None:
        """Sets the manual step size [s]. Raises ValueError unless dt > 0."""
        _check(name)
        step = exact.duration(dt)
        if step <= 0:
            raise ValueError(f"manual step size {dt}: give a time above 0 s")
        checked_rate(1 / step, "loop")
        self._run_loop.manual_step = step

    def get_manual_step_size(self, name: str = "") -> float:
        """The manual step size [s]."""
        _check(name)
        return float(self._run_loop.manual_step)


def _check(name: str) -> None:
    if name not in ("", MAIN):
        raise ValueError(f'there is no run loop {name!r}; the one there is: "{MAIN}" ("" stands for all)')
