"""Gates that wait for all their wires, and the old Sequence: arrival by arrival."""

import pytest

from graph import Context, compile_graphs
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec


@pytest.fixture
def gate():
    """A function that builds a gate with two wires, A and B; `arrive(wire, **values)` gives (fired so far, outputs)."""

    def build(kind, **start):
        spec = GraphSpec(
            "/G",
            (
                NodeSpec("a", "OnImpulseEvent"),
                NodeSpec("b", "OnImpulseEvent"),
                NodeSpec("gate", kind, start),
            ),
            (ConnectionSpec("a.execOut", "gate.execIn"), ConnectionSpec("b.execOut", "gate.execIn")),
        )
        graph, context = compile_graphs([spec])[0], Context.standalone()
        node = graph.nodes["gate"]

        def arrive(wire, **values):
            for name, value in values.items():
                node.set(f"inputs:{name}", value)
            graph.nodes[wire].set("state:enableImpulse", True)
            graph.evaluate(context)
            graph.nodes[wire].set("state:enableImpulse", False)
            return node.fired["execOut"], *(node.get(f"outputs:{name}") for name in values)

        return arrive

    return build


def test_a_sync_gate_fires_when_every_wire_has_brought_the_value(gate):
    arrive = gate("SyncGate")
    trace = [("a", 7), ("b", 7), ("a", 8), ("a", 9), ("b", 9), ("a", 9), ("b", 9)]
    assert [arrive(wire, syncValue=value) for wire, value in trace] == [
        (0, 7),
        (1, 7),
        (1, 8),
        (1, 9),
        (2, 9),
        (2, 9),
        (3, 9),
    ]


def test_a_rational_gate_compares_in_lowest_terms(gate):
    arrive = gate("RationalTimeSyncGate")
    times = [(3, 6), (1, 2), (1, 0), (2, 0), (2, 0), (-2, 4), (-1, 2)]
    seen = [arrive("ab"[i % 2], rationalTimeNumerator=n, rationalTimeDenominator=d) for i, (n, d) in enumerate(times)]
    assert [fired for fired, *_ in seen] == [0, 1, 1, 1, 2, 2, 3]
    assert seen[1][1:] == (1, 2)
    assert seen[0][1:] == (3, 6), "the outputs are as they came"


def test_the_old_sequence_takes_turns():
    spec = GraphSpec(
        "/G",
        (NodeSpec("tick", "OnTick"), NodeSpec("turns", "omni.graph.action.Sequence")),
        (ConnectionSpec("tick.tick", "turns.execIn"),),
    )
    graph, context = compile_graphs([spec])[0], Context.standalone()
    seen = []
    for _ in range(4):
        graph.evaluate(context)
        seen.append(tuple(graph.nodes["turns"].fired.values()))
    assert seen == [(1, 0), (1, 1), (2, 1), (2, 2)]
