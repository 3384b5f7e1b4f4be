"""Types that only old graphs use."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type


class _Odd:
    """Whether the next activation is an odd one."""

    def __init__(self) -> None:
        self.next_is_odd = True


@node_type(
    "omni.graph.action.Sequence",
    version=2,
    inputs={"execIn": Attribute("execution", "goes on at one of the outputs")},
    outputs={
        "a": Attribute("execution", "follows at the first, third, ... activation"),
        "b": Attribute("execution", "follows at the second, fourth, ... activation"),
    },
    memory=_Odd,
)
def sequence(db: Database) -> None:
    """Follow a and b in turn, one per activation. To follow both, use Multisequence."""
    db.fire("a" if db.memory.next_is_odd else "b")
    db.memory.next_is_odd = not db.memory.next_is_odd
