"""A case at an extreme: what is measured, the bound that it must meet, and why that bound."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from graph.base.errors import RunError, UserError

Measure = Callable[[Any], float | str]


@dataclass(frozen=True, slots=True)
class Case:
    """One row of the table.

    area, name: what is at the extreme. bound: the largest error allowed [unit], or a text: the line in which the value
    must be refused or reported contains it. why: where the bound comes from. measure: by one value of `over`, its error
    or the line. slow: needs minutes or gigabytes; it runs only on request.
    """

    area: str
    name: str
    bound: float | str
    unit: str
    why: str
    measure: Measure
    over: tuple[Any, ...] = (None,)
    slow: bool = False

    @property
    def limit(self) -> str:
        """The bound as the table shows it."""
        return f'"{self.bound}"' if isinstance(self.bound, str) else shown(self.bound, self.unit)

    def run(self) -> Outcome:
        """Measures it at every value; the outcome is that of the worst."""
        return max((self._at(value) for value in self.over), key=lambda one: (not one.ok, one.error))

    def _at(self, value: Any) -> Outcome:
        where = "" if value is None else f" at {_word(value)}"
        try:
            found = self.measure(value)
        except Exception as error:  # one defect must not end the table
            return Outcome(self, f"{type(error).__name__}: {' '.join(str(error).split())}{where}", False, math.inf)
        if isinstance(found, str):
            ok = isinstance(self.bound, str) and self.bound in found and "\n" not in found
            return Outcome(self, "reported" if ok else f"{found or 'taken without a word'}{where}", ok, 0.0)
        ok = not isinstance(self.bound, str) and found <= self.bound
        at = where if len(self.over) > 1 and found else ""
        return Outcome(self, f"{shown(found, self.unit)}{at}", ok, math.inf if math.isnan(found) else found)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a case gave: the measured value as text, whether it meets the bound, and the size of its error."""

    case: Case
    measured: str
    ok: bool
    error: float


def shown(value: float, unit: str) -> str:
    """A value with its unit."""
    return f"{value:.2g} {unit}".rstrip()


def _word(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def refusal(act: Callable[[], Any]) -> str:
    """The message with which an action is refused; empty if it is not."""
    try:
        act()
    except (UserError, RunError, ValueError) as error:
        return str(error)
    return ""


def told(warnings: Iterable[Any], code: str) -> str:
    """The first warning with this code, with its place; empty without one."""
    return next((f"{one.code}: {one.where}: {one.message}" for one in warnings if one.code == code), "")
