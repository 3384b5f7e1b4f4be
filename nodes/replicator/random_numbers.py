"""Random numbers of a node: the same in every run with the same seed; every play starts the sequence again."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

if TYPE_CHECKING:
    import numpy as np


@dataclass(slots=True)
class Random:
    """Memory of a node that draws random numbers."""

    generator: Any = None


def generator_of(db: Database) -> np.random.Generator:
    """The node's own generator, from the App's seed (0 without one) and the node's path."""
    import numpy as np

    memory = db.memory
    if memory.generator is None:
        app = db.context.app
        memory.generator = np.random.default_rng([0 if app is None else app.seed, zlib.crc32(db.path.encode())])
    generator: np.random.Generator = memory.generator
    return generator


@node_type(
    "isaacsim.replicator.domain_randomization.Random3f",
    version=1,
    volatile=True,
    inputs={
        "minimum": Attribute("float[3]", "smallest numbers"),
        "maximum": Attribute("float[3]", "largest numbers"),
    },
    outputs={"output": Attribute("float[3]", "random numbers, new ones in every compute")},
    memory=Random,
)
def random_3f(db: Database) -> None:
    """Draw three numbers, each uniformly between its minimum and maximum."""
    inputs = db.inputs
    low, high = inputs.minimum, inputs.maximum
    if not (low <= high).all():
        db.fail(f"minimum {low.tolist()} is above maximum {high.tolist()}; exchange them")
    db.outputs.output = generator_of(db).uniform(low, high)
