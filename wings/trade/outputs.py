"""A trade as data: `trade.json`, and `trade.csv` with a row for each setting."""

from __future__ import annotations

import csv
import io
import math
import os
import platform
import shlex
from typing import Any

from graph.session.meter import PARTS, Cost
from graph.sim.fidelity import KNOBS
from graph.sim.knob import word

from .float32 import POINTS, Float32
from .metrics import METRICS
from .outcome import Outcome, Row, columns_of
from .study import Setting, overrides_of


def as_dict(outcome: Outcome) -> dict[str, Any]:
    """Everything as JSON data: times in seconds, settings as texts, an error that a setting does not have as null.

    Settings that are the same run (`same_as`) have the same figures.
    """
    study, recommended, nearest = outcome.study, outcome.recommended, outcome.nearest
    names = columns_of(outcome)
    fronts = {name: outcome.front(name) for name in outcome.shown}
    return {
        "file": str(study.scene.file),
        "seed": study.scene.seed,
        "duration": float(study.duration),
        "repeat": study.repeat,
        "timed": float(outcome.timed),
        "complete": outcome.complete,
        "knobs": {name: [word(value) for value in values] for name, values in study.varied.items()},
        "reference": {
            "setting": _words(study.reference),
            "refined": _words(study.refined) if study.refined is not None and outcome.refined else None,
            "moved": {name: _number(value) for name, value in outcome.moved.items()},
            "own_error": {name: _number(outcome.doubt(name)) for name in outcome.moved},
            "horizon": outcome.horizon.time,
            "why": outcome.horizon.why,
        },
        "metrics": {
            name: {
                "unit": METRICS[name].unit,
                "doc": METRICS[name].doc,
                "better": "more" if METRICS[name].more else "less",
            }
            for name in names
        },
        "settings": [
            {
                "setting": _words(setting),
                "same_as": None if setting is row.setting else _words(row.setting),
                "status": row.status,
                "why": row.why,
                "cost": _costs(row),
                "frames": row.frames,
                "errors": {name: _number(row.errors.get(name)) for name in names},
                "front": [name for name, front in fronts.items() if row in front],
                "unresolved": [name for name in names if outcome.unresolved(row, name)],
                "warnings": list(row.warnings),
                **({} if row.float32 is None else {"float32": _growth(row.float32)}),
            }
            for row in outcome.rows
            for setting in row.settings
        ],
        "leverage": outcome.leverage,
        "no_effect": [*outcome.idle],
        "budget": dict(study.budget),
        "least": outcome.sought if study.budget else None,
        "recommended": _words(recommended.setting) if recommended else None,
        "nearest": _words(nearest.setting) if study.budget and not recommended and nearest else None,
        "machine": {
            "system": platform.platform(),
            "processor": platform.processor() or platform.machine(),
            "cores": os.cpu_count(),
            "python": platform.python_version(),
        },
    }


def as_csv(outcome: Outcome) -> str:
    """A row for each setting: its knobs, costs and errors."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names, knobs = columns_of(outcome), tuple(outcome.study.varied)
    parts = [f"cost.{part}" for part in PARTS]
    costs = ["cost.wall", "cost.cpu", *parts, "cost.frames", "cost.start"]
    writer.writerow([*knobs, "status", *costs, "spread.wall", "spread.cpu", *names])
    for row in outcome.rows:
        spread = (row.spread.wall, row.spread.cpu) if row.spread else (None, None)
        values = [*(row.value(name) for name in costs), *spread, *(row.errors.get(name) for name in names)]
        figures = [row.status, *("" if one is None else f"{one:.6g}" for one in values)]
        for setting in row.settings:
            writer.writerow([*(word(setting[name]) for name in knobs), *figures])
    return stream.getvalue()


def block(outcome: Outcome, row: Row) -> str:
    """A setting as a `fidelity:` block of a graph file, with what `--fidelity` gave to all runs; then its `--set`."""
    knobs = [f"  {name}: {text}" for name, text in chosen(outcome, row).items()]
    options = [shlex.join(("--set", f"{name}={text}")) for name, text in overrides_of(row.setting).items()]
    return "\n".join([*(["fidelity:", *knobs] if knobs else []), *options])


def chosen(outcome: Outcome, row: Row) -> dict[str, str]:
    """The knobs of a setting, and those that all runs were given, by name."""
    return {**outcome.study.scene.fidelity, **{k: text for k, text in _words(row.setting).items() if k in KNOBS}}


def _words(setting: Setting) -> dict[str, str]:
    return {name: word(value) for name, value in setting.items()}


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _costs(row: Row) -> dict[str, Any] | None:
    cost, spread = row.cost, row.spread
    if cost is None:
        return None
    return {
        **_pair(cost),
        "spread": _pair(spread) if spread else None,
        "start": row.start,
        "parts": {name: _pair(one) for name, one in row.parts.items()},
        "runs": [_pair(one.whole) for one in row.timed],
    }


def _growth(found: Float32) -> dict[str, Any]:
    """The largest differences until each of some times."""
    times, until = found.growth(POINTS)
    return {
        "times": times.tolist(),
        **{kind: [*map(_number, apart.tolist())] for kind, apart in until.items()},
        "ended": found.ended,
        "without": list(found.without),
    }


def _pair(cost: Cost) -> dict[str, float]:
    return {"wall": cost.wall, "cpu": cost.cpu}
