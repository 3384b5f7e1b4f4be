"""The question of a trade: file, what to vary, reference, budget; and the settings that answer it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

from graph.base.errors import Problem, UserError
from graph.base.suggest import did_you_mean
from graph.session.varied import read_varied as varied_values
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.knob import word

Setting = Mapping[str, Any]
"""Values by name: of knobs as `Knob.checked` gives them, of attributes their text; all others are as in the file.

An attribute is named as for `--set`: NODE.ATTR or /PRIM/PATH.ATTR. Some that take the same value are joined by `+`.
"""

JOIN = "+"
Nodes = Callable[[], Sequence[str]]

MOST_SETTINGS = 1000


@dataclass(frozen=True, slots=True)
class Scene:
    """What every run has in common: the file and the options with which it is opened, as `graph run` takes them.

    prepare: called first in each process, such as to register node types; a function that can be pickled.
    """

    file: Path
    allow: tuple[Path, ...] = ()
    skip_outside: bool = False
    skip_unknown: bool = False
    allow_scripts: bool = False
    settings: Mapping[str, Any] = field(default_factory=dict)
    fidelity: Mapping[str, str] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    play: tuple[Path, ...] = ()
    limits: Mapping[str, int] = field(default_factory=dict)
    seed: int = 0
    prepare: Callable[[], object] = tuple


@dataclass(frozen=True, slots=True)
class Study:
    """A trade to measure.

    varied: the values of each knob, in the order given. settings: all that are run, each with a value of every varied
    knob. reference: the setting whose results are taken as exact; others: settings of which `conduct` takes the one
    that converges best instead (`references`). budget: bounds by metric. duration: simulated time [s]. repeat: timed
    runs of each setting. refined: the reference refined once more, which `conduct` works out; None if none of its knobs
    can be refined. one_at_a_time: whether `settings` are those that differ from the reference in one knob.
    """

    scene: Scene
    varied: Mapping[str, tuple[Any, ...]]
    settings: tuple[Setting, ...]
    reference: Setting
    budget: Mapping[str, float]
    duration: Fraction = Fraction(1)
    repeat: int = 3
    refined: Setting | None = None
    others: tuple[Setting, ...] = ()
    one_at_a_time: bool = False

    def referring_to(self, reference: Setting, finer: Setting | None) -> Study:
        """The same with that reference and its refinement."""
        base = {name: reference[name] for name in self.varied}
        settings = plan_settings(self.varied, base) if self.one_at_a_time else self.settings
        return replace(self, reference=reference, refined=finer, settings=settings)


def plan_settings(varied: Mapping[str, Sequence[Any]], base: Setting | None = None) -> tuple[Setting, ...]:
    """Every combination of values (a grid); with `base`, only the base and what differs from it in one knob.

    base: a value for each varied knob. Raises UserError for more than `MOST_SETTINGS`.
    """
    number = math.prod(map(len, varied.values())) if base is None else 1 + sum(map(len, varied.values()))
    if number > MOST_SETTINGS:
        hint = ", or --one-at-a-time" if base is None and len(varied) > 1 else ""
        raise UserError(f"--vary: {number:,} settings are too many (most: {MOST_SETTINGS:,}); give fewer values{hint}")
    if base is None:
        return tuple(dict(zip(varied, values, strict=True)) for values in product(*varied.values()))
    found = [dict(base)]
    for name, values in varied.items():
        found += [{**base, name: value} for value in values if value != base[name]]
    return tuple(found)


def read_varied(options: Iterable[str], nodes: Nodes = tuple) -> dict[str, tuple[Any, ...]]:
    """The values of `KEY=V1,V2,...` options by key; nodes: as in `read_value`. Raises UserError with every problem."""
    varied: dict[str, tuple[Any, ...]] = {}
    problems: list[Problem] = []
    for option in options:
        name, equals, text = option.partition("=")
        try:
            if not equals or not text.strip(", "):
                raise ValueError("write it as KEY=V1,V2,...")
            if name in varied:
                raise ValueError("the knob is varied twice; give all its values in one --vary")
            asked = varied_values(name, text)
            if asked.draw:
                raise ValueError("say how many values are drawn, such as uniform(0, 1)*5")
            values = [read_value(name, one, nodes) for one in asked.values]
            varied[name] = tuple(dict.fromkeys(values))
        except ValueError as error:
            problems.append(Problem(f"--vary {option}: {error}"))
    if problems:
        raise UserError(problems)
    return varied


def read_values(options: Iterable[str], flag: str, nodes: Nodes = tuple) -> dict[str, Any]:
    """The values of `KEY=V` options by key; nodes: as in `read_value`. Raises UserError with every problem."""
    found: dict[str, Any] = {}
    problems: list[Problem] = []
    for option in options:
        name, equals, text = option.partition("=")
        try:
            if not equals or not text:
                raise ValueError("write it as KEY=VALUE")
            if name in found:
                raise ValueError("the knob is given twice; leave one of them out")
            found[name] = read_value(name, text, nodes)
        except ValueError as error:
            problems.append(Problem(f"{flag} {option}: {error}"))
    if problems:
        raise UserError(problems)
    return found


def read_value(name: str, text: str, nodes: Nodes = tuple) -> Any:
    """The value of a knob from text; of an attribute the text itself, which is checked when a file is opened with it.

    nodes: gives the names of the file's nodes. Raises ValueError for an unknown knob or an invalid value.
    """
    if name in KNOBS:
        return KNOBS[name].checked(text)
    if all(_is_attribute(one, nodes) for one in name.split(JOIN)):
        return text
    lists = "; graph trade --list lists them; an attribute is /PRIM/PATH.ATTR (/World/Lidar.omni:sensor:tickRate)"
    raise ValueError(f"there is no such knob{did_you_mean(name, KNOBS) or f'{lists} or NODE.ATTR'}")


def _is_attribute(name: str, nodes: Nodes) -> bool:
    owner, dot, attribute = name.rpartition(".")
    return bool(dot and owner and attribute) and (owner.startswith("/") or owner in nodes())


def overrides_of(setting: Setting) -> dict[str, str]:
    """The attributes of a setting, each by its own name."""
    return {one: value for name, value in setting.items() if name not in KNOBS for one in name.split(JOIN)}


def label(name: str) -> str:
    """A short form of a knob's or an attribute's name: `Lidar.tickRate` for `/World/Lidar.omni:sensor:tickRate`."""
    if name in KNOBS:
        return name
    parts = [one.rpartition(".") for one in name.split(JOIN)]
    owners = dict.fromkeys(owner.rpartition("/")[2] for owner, _, _ in parts)
    ends = dict.fromkeys(attribute.rpartition(":")[2] for _, _, attribute in parts)
    return f"{JOIN.join(owners)}.{JOIN.join(ends)}"


def finest(name: str, values: Sequence[Any]) -> Any:
    """The value with the least error: the largest or smallest number, or the choice nearest to the finest one.

    Of a knob without a finest value its default, if it is one of them, else the first, which stands for all of them
    (`references`); of an attribute the first, of a rate the highest.
    """
    if name not in KNOBS:
        numbers = [_number(value) for value in values]
        is_rate = _RATE.search(name) and None not in numbers
        return values[max(range(len(values)), key=lambda n: numbers[n] or 0.0)] if is_rate else values[0]
    knob = KNOBS[name]
    if knob.finer in ("higher", "lower") and knob.kind not in ("choice", "switch"):
        return (max if knob.finer == "higher" else min)(values)
    if not knob.finer:
        return knob.default if knob.default in values else values[0]
    if knob.kind == "switch":
        return next((value for value in values if value == (knob.finer == "on")), values[0])
    best = knob.choices.index(knob.finer)
    return min(values, key=lambda value: abs(knob.choices.index(value) - best))


def references(varied: Mapping[str, Sequence[Any]], given: Setting) -> tuple[Setting, ...]:
    """The candidates for the reference, of which the best converging is taken; one if the table of knobs decides.

    given: what the reference is asked to be. It decides nothing about `physics.integrator`: which one is best depends
    on the scene.
    """
    finest_of = {name: finest(name, values) for name, values in varied.items()}
    undecided = [name for name, values in varied.items() if name not in given and is_open(name) and len(values) > 1]
    found = product(*(varied[name] for name in undecided))
    return tuple({**finest_of, **dict(zip(undecided, one, strict=True)), **given} for one in found)


def is_open(name: str) -> bool:
    """Whether the table of knobs says neither which choice is the finest nor which is the default."""
    knob = KNOBS.get(name)
    return knob is not None and knob.kind == "choice" and not knob.finer and knob.default is None


_RATE = re.compile(r"(rate|hz|fps|frequency)$", re.IGNORECASE)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def refined(setting: Setting, present: Fidelity) -> Setting | None:
    """The setting with each of its knobs one step finer; None if none of them can be refined.

    Numbers are doubled or halved, a choice becomes the finest one. `lidar.motion=continuous` is refined by twice the
    `lidar.bins`, a choice of physics without a finest one by twice the `physics.hz`. Attributes stay as they are.
    present: the knobs of the file, for those that the setting does not have.
    """
    finer: dict[str, Any] = dict(setting)
    if "lidar.motion" in setting and setting["lidar.motion"] == "continuous":
        finer.setdefault("lidar.bins", present["lidar.bins"])
    if present["physics.hz"] and any(is_open(name) for name in setting if name.startswith("physics.")):
        finer.setdefault("physics.hz", present["physics.hz"])
    for name, value in list(finer.items()):
        if name not in KNOBS:
            continue
        knob = KNOBS[name]
        if knob.kind == "choice":
            finer[name] = knob.finer or value
        elif knob.kind == "switch":
            finer[name] = knob.finer == "on" if knob.finer else value
        elif knob.finer:
            finer[name] = value * 2 if knob.finer == "higher" else value / 2
    return finer if finer != {**setting, **{key: present[key] for key in finer if key not in setting}} else None


def text_of(setting: Setting) -> str:
    """A setting as `KEY=V KEY=V`."""
    return " ".join(f"{name}={word(value)}" for name, value in setting.items())
