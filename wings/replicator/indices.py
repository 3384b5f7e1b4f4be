"""Chooses which of many environments are randomised now."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type


@node_type(
    "isaacsim.replicator.domain_randomization.OgnCountIndices",
    version=1,
    inputs={"indices": Attribute("int[]", "indices of environments")},
    outputs={"count": Attribute("uint", "how many there are")},
)
def count_indices(db: Database) -> None:
    """Count indices."""
    db.outputs.count = len(db.inputs.indices)


@node_type(
    "isaacsim.replicator.domain_randomization.OgnIntervalFiltering",
    version=1,
    inputs={
        "interval": Attribute("int", "frames between two randomisations of an environment"),
        "frameCounts": Attribute("int[]", "frames since its reset, of each environment"),
        "indices": Attribute("int[]", "environments that were reset"),
        "ignoreInterval": Attribute("bool", "take `indices` as they are", default=False),
        "execIn": Attribute("execution", "selects the environments"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute, also with no environment selected"),
        "indices": Attribute("int[]", "the environments selected"),
        "on_reset": Attribute("bool", "whether they are those that were reset"),
    },
)
def interval_filtering(db: Database) -> None:
    """Select the environments whose frame count is a positive multiple of the interval, or those that were reset."""
    import numpy as np

    inputs, outputs = db.inputs, db.outputs
    if inputs.ignoreInterval:
        outputs.indices = inputs.indices
    else:
        counts, interval = np.asarray(inputs.frameCounts), inputs.interval
        if interval <= 0 and len(counts):
            db.fail(f"input interval is {interval}; give it at least 1 frame")
        outputs.indices = np.flatnonzero((counts % interval == 0) & (counts > 0)) if len(counts) else []
    outputs.on_reset = bool(inputs.ignoreInterval)
    db.fire("execOut")
