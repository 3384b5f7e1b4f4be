"""A fidelity knob: its meaning, its values, and the check of a value."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any, Literal, get_args

from graph.base import exact
from graph.base.limits import check
from graph.base.records import dataclass

Kind = Literal["rate", "count", "number", "switch", "choice"]

_KINDS: dict[Any, Kind] = {Fraction: "rate", int: "count", float: "number", bool: "switch"}


@dataclass(frozen=True, slots=True)
class Knob:
    """The meaning of a knob.

    cost, error: how run time and error depend on it; why: the reason for its default. finer: where the error is less,
    "higher" or "lower" numbers or one of the values; "" if no value is more exact than the others, or each is in scenes
    of its own. available: the values that can be run, if not all of them, and the reason `missing` for the others.
    limit: the limit of a count (`graph.base.limits`). kind: a rate [Hz], a count from 1, a number above 0 (of `unit`),
    on/off, or one of `choices`.
    """

    doc: str
    cost: str
    error: str
    why: str
    finer: str = ""
    unit: str = ""
    available: tuple[Any, ...] | None = None
    missing: str = ""
    limit: str = ""
    kind: Kind = "number"
    choices: tuple[str, ...] = ()
    default: Any = None

    def of(self, hint: Any, default: Any) -> Knob:
        """This knob with the kind, the choices and the default of a field: `Literal["a", "b"] | None`, `int` ..."""
        plain = next((part for part in get_args(hint) if type(None) in get_args(hint)), hint)
        choices = get_args(plain)
        return replace(self, kind="choice" if choices else _KINDS[plain], choices=choices, default=default)

    def checked(self, value: Any) -> Any:
        """The value of a typed value, or of text as on the command line. Raises ValueError."""
        known: Any
        if self.kind == "choice":
            known = _choice(value, self.choices)
        elif self.kind == "switch":
            known = value if isinstance(value, bool) else _choice(value, ("on", "off")) == "on"
        else:
            known = _positive(value, self.kind)
        if self.limit:
            check(self.limit, known, f"{known:,} is too many")
        if self.available is not None and known not in self.available:
            missing = f": {self.missing}" if self.missing else " yet"
            allowed = [word(one) for one in self.available]
            advice = f"use {' or '.join(allowed)}" if allowed else "leave it out"
            raise ValueError(f"{value!r} is not available{missing}; {advice}")
        return known

    @property
    def values(self) -> str:
        """Its values in words: "frozen, update, continuous", "on, off", "a whole number from 1", "a number [m]"."""
        unit = f" [{self.unit}]" if self.unit else ""
        match self.kind:
            case "choice":
                return ", ".join(self.choices)
            case "switch":
                return "on, off"
            case "count":
                return f"a whole number from 1{unit}"
        return f"a number above 0{unit}"

    @property
    def schema(self) -> dict[str, Any]:
        """JSON Schema of its values, for editors."""
        values: dict[str, Any]
        match self.kind:
            case "choice":
                values = {"enum": [*self.choices]}
            case "switch":
                values = {"enum": [True, False, "on", "off"]}
            case "count":
                values = {"type": "integer", "minimum": 1}
            case "number":
                values = {"type": "number", "exclusiveMinimum": 0}
            case "rate":
                values = {"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string"}]}
        about = f"{self.doc}{f' [{self.unit}]' if self.unit else ''}. Cost: {self.cost}. Error: {self.error}. "
        about += f"Default: {self.why}."
        return {"description": about, **values, **({} if self.default is None else {"default": self.default})}


def word(value: Any) -> str:
    """A knob's value as text, as files and the command line have it."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, Fraction):
        return exact.shortest(value)
    if isinstance(value, float) and float(short := f"{value:g}") == value:
        return short
    return str(value)


def _choice(value: Any, choices: tuple[str, ...]) -> str:
    if value not in choices:
        raise ValueError(f"{value!r} is not one of {', '.join(choices)}")
    return str(value)


def _positive(value: Any, kind: Kind) -> Fraction | int | float:
    try:
        number = exact.rate(value)
    except (ValueError, TypeError):
        raise ValueError(f"{value!r} is not a number") from None
    if number <= 0:
        raise ValueError(f"{value!r} is not above 0")
    if kind == "count":
        if number.denominator != 1:
            raise ValueError(f"{value!r} is not a whole number")
        return int(number)
    return number if kind == "rate" else float(number)
