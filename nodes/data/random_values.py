"""Random values, one set for each activation: the same in every run with the same seed.

A node without its own seed uses one made of the App's seed and the node's path; a timeline stop starts the sequence
again. The numbers differ from those of other products with the same seed; the distribution is the same.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.values.coercion import dtype_of
from nodes.bounds import at_least

from .numbers import aligned, settled
from .promotion import promoted

if TYPE_CHECKING:
    import numpy as np

INPUTS = {
    "execIn": Attribute("execution", "draws a new value"),
    "isNoise": Attribute(
        "bool", "whether a seed gives one value, the same in each activation", default=False, literal_only=True
    ),
    "seed": Attribute("uint64", "the seed, where useSeed or isNoise is set"),
    "useSeed": Attribute("bool", "whether to draw from the seed instead of one made for the node", default=False),
}
EXEC_OUT = Attribute("execution", "follows once the value is drawn")


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


@dataclass(slots=True)
class Seeded(Random):
    """Memory of a node that draws from the App's seed or from its own."""

    seed: int | None = None
    """The node's own seed of the generator; None for the App's."""


def _generator(db: Database) -> np.random.Generator:
    import numpy as np

    inputs, memory = db.inputs, db.memory
    if inputs.isNoise:
        return np.random.default_rng(inputs.seed)
    wanted = inputs.seed if inputs.useSeed else None
    if memory.seed != wanted:
        memory.seed, memory.generator = wanted, None if wanted is None else np.random.default_rng(wanted)
    return generator_of(db)


@node_type(
    "omni.graph.nodes.RandomBoolean",
    version=1,
    inputs=INPUTS,
    outputs={"execOut": EXEC_OUT, "random": Attribute("bool", "true or false, as likely as not")},
    memory=Seeded,
)
def random_boolean(db: Database) -> None:
    """Draw a random bool."""
    db.outputs.random = bool(_generator(db).integers(2))
    db.fire("execOut")


@node_type(
    "omni.graph.nodes.RandomNumeric",
    version=1,
    inputs={
        **INPUTS,
        "max": Attribute(("numerics",), "the largest: of whole numbers it may come, of real ones not"),
        "min": Attribute(("numerics",), "the smallest, which may come"),
    },
    outputs={"execOut": EXEC_OUT, "random": Attribute(("numerics",), "numbers from min to max, all as likely")},
    resolve=promoted("random", "min", "max"),
    memory=Seeded,
)
def random_numeric(db: Database) -> None:
    """Draw numbers between a minimum and a maximum, independently for each component and element."""
    import numpy as np

    result = settled(db, "random")
    low, high = np.broadcast_arrays(*aligned(db, ("min", "max"), result))
    if not (low <= high).all():
        db.fail(f"input min ({db.inputs.min}) is above input max ({db.inputs.max}); exchange them")
    generator = _generator(db)
    common = np.result_type(low, high) if result is None else dtype_of(result.component)
    if common.kind in "iu":
        low, high = low.astype(common), high.astype(common)
        drawn = generator.integers(low, high, endpoint=True, dtype=common)
    else:
        drawn = generator.uniform(low.astype(float), high.astype(float))
    _give(db, drawn, result)


@node_type(
    "omni.graph.nodes.RandomGaussian",
    version=1,
    check=at_least(stdev=0),
    inputs={
        **INPUTS,
        "mean": Attribute(("decimals",), "the middle of the bell"),
        "stdev": Attribute(("decimals",), "the standard deviation, 0 or more"),
        "useLog": Attribute("bool", "whether the logarithm of the numbers is so distributed", default=False),
    },
    outputs={"execOut": EXEC_OUT, "random": Attribute(("decimals",), "normally distributed numbers")},
    resolve=promoted("random", "mean", "stdev"),
    memory=Seeded,
)
def random_gaussian(db: Database) -> None:
    """Draw numbers from a normal (or log-normal) distribution, independently for each component and element."""
    import numpy as np

    result = settled(db, "random")
    mean, deviation = np.broadcast_arrays(*aligned(db, ("mean", "stdev"), result))
    if not (deviation >= 0).all():
        db.fail(f"input stdev is {db.inputs.stdev}; give it 0 or more")
    generator = _generator(db)
    draw = generator.lognormal if db.inputs.useLog else generator.normal
    _give(db, draw(mean.astype(float), np.abs(deviation.astype(float))), result)  # of -0.0 too


@node_type(
    "omni.graph.nodes.RandomUnitVector",
    version=1,
    inputs=INPUTS,
    outputs={"execOut": EXEC_OUT, "random": Attribute("vectorf[3]", "a vector of length 1")},
    memory=Seeded,
)
def random_unit_vector(db: Database) -> None:
    """Draw a direction, uniformly distributed."""
    db.outputs.random = _unit(db, 3)
    db.fire("execOut")


@node_type(
    "omni.graph.nodes.RandomUnitQuaternion",
    version=1,
    inputs=INPUTS,
    outputs={"execOut": EXEC_OUT, "random": Attribute("quatf[4]", "a rotation, quaternion x, y, z, w of length 1")},
    memory=Seeded,
)
def random_unit_quaternion(db: Database) -> None:
    """Draw a rotation, uniformly distributed."""
    db.outputs.random = _unit(db, 4)
    db.fire("execOut")


def _unit(db: Database, size: int) -> Any:
    import numpy as np

    drawn = _generator(db).normal(size=size)
    return (drawn / np.linalg.norm(drawn)).astype(np.float32)


def _give(db: Database, drawn: Any, result: Any) -> None:
    """Writes the drawn values in the type of the output: a number, or an array in its precision."""
    if not getattr(drawn, "ndim", 0):
        db.outputs.random = drawn.item() if hasattr(drawn, "item") else drawn
    else:
        db.outputs.random = drawn if result is None else drawn.astype(dtype_of(result.component))
    db.fire("execOut")
