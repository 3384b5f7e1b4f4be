"""A value of a run that its report keeps, and tables of many runs as a column."""

from __future__ import annotations

import math

from graph.node import Attribute, Database, node_type

MOST = 1000
"""Most metrics of a run."""


@node_type(
    "example.Metric",
    version=1,
    inputs={
        "execIn": Attribute("execution", "takes the value"),
        "name": Attribute("string", "name of the metric in the report", default="metric"),
        "value": Attribute("double", "its value", default=0.0),
        "keep": Attribute(
            "token",
            "which value is kept",
            default="last",
            allowed_tokens=("last", "first", "min", "max", "sum"),
        ),
    },
    outputs={"execOut": Attribute("execution", "follows once it is taken")},
)
def metric(db: Database) -> None:
    """Write a value into the report of the run, where `graph sweep` finds it."""
    inputs, metrics = db.inputs, db.app.metrics
    name, value = inputs.name, float(inputs.value)
    if not math.isfinite(value):
        db.warn("metric-not-finite", f'{value} is not a value of the metric "{name}"; it is left out')
    elif name not in metrics and len(metrics) >= MOST:
        db.fail(f"a run has {MOST} metrics at most")
    else:
        kept = metrics.get(name, value)
        chosen = {"first": kept, "min": min(kept, value), "max": max(kept, value)}
        metrics[name] = chosen.get(inputs.keep, value) if inputs.keep != "sum" else metrics.get(name, 0.0) + value
    db.fire("execOut")
