"""How much memory a graph file may ask for."""

import pytest

from graph.base.errors import RunError
from graph.base.memory_budget import Room
from graph.testing import run_node

MIB = 2**20


def test_what_a_node_holds_is_counted_once_however_often_it_computes():
    room = Room(10 * MIB)
    for _ in range(5):
        assert room.claim("/G/a", 6 * MIB) is None
    assert room.claim("/G/b", 4 * MIB) is None
    assert "would take 5,242,880 bytes" in room.claim("/G/b", 5 * MIB)
    assert room.claim("/G/a", 100) is None
    assert room.claim("/G/b", 10 * MIB) is None


def test_small_values_are_not_counted():
    room = Room(5000)
    assert all(room.claim(f"/G/{number}", 4096) is None for number in range(1000))
    assert room.claim("/G/large", 4097) is None  # the first that counts
    assert "4,097 bytes" in room.claim("/G/other", 4097)


def test_many_values_that_are_each_just_small_enough_are_counted_together():
    room = Room(3000 * 2**20 - 1)
    told = [room.claim(f"/G/{number}", 2**20) for number in range(3000)]
    assert told[:-1] == [None] * 2999
    assert told[-1].endswith("raise it with --limit graph.bytes=N")


@pytest.mark.parametrize(
    ("type_id", "inputs"),
    [
        ("ConstructArray", {"arraySize": 2_000_000_000, "arrayType": "double[]", "input0": 1.0}),
        ("ConstructArray", {"arraySize": 2_000_000_000, "arrayType": "token[]", "input0": "x"}),
        ("ArrayResize", {"array": {"type": "double[]", "value": [1.0]}, "newSize": 2_000_000_000}),
        ("ArraySetIndex", {
            "array": {"type": "double[]", "value": [1.0]}, "index": 2_000_000_000, "value": 1.0, "resizeToFit": True,
        }),
    ],
)  # fmt: skip
def test_a_value_that_would_fill_the_machine_is_refused_before_it_is_made(type_id, inputs):
    with pytest.raises(RunError, match="all values of the graphs may take 1,073,741,824 together; "):
        run_node(type_id, inputs=inputs)
