"""Events from node to node: when they arrive, in which order, with what."""

import pytest

from graph import ComputeError, Context, compile_graphs
from graph.node.context import WarningLog
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec


def graph(path, nodes, *links, evaluator="execution"):
    made = tuple(NodeSpec(name, *(entry if isinstance(entry, tuple) else (entry,))) for name, entry in nodes.items())
    return GraphSpec(path, made, tuple(ConnectionSpec(*one.split(" -> ")) for one in links), evaluator)


class Run:
    """Evaluates graphs once per update, in their order."""

    def __init__(self, *specs):
        self.graphs = compile_graphs(specs)
        self.context = Context.standalone()
        self.nodes = {f"{g.path}/{name}": node for g in self.graphs for name, node in g.nodes.items()}

    def update(self, times=1):
        for _ in range(times):
            self.context.advance()
            for one in self.graphs:
                one.evaluate(self.context)

    def counts(self, path, updates):
        """The count of a Counter after each update."""
        found = []
        for _ in range(updates):
            self.update()
            found.append(self.nodes[path].get("count"))
        return found


SENDER = graph(
    "/S",
    {
        "impulse": ("OnImpulseEvent", {}),
        "send": ("SendCustomEvent", {"eventName": "go", "path": "/World/Box"}),
        "again": ("SendCustomEvent", {"eventName": "go", "path": "/World/Ball"}),
    },
    "impulse.execOut -> send.execIn",
    "send.execOut -> again.execIn",
)
RECEIVER = graph(
    "/R",
    {"on": ("OnCustomEvent", {"eventName": "go"}), "count": "Counter"},
    "on.execOut -> count.execIn",
)


@pytest.mark.parametrize("order", [(SENDER, RECEIVER), (RECEIVER, SENDER)], ids=["sender first", "receiver first"])
def test_what_is_sent_in_one_update_arrives_in_the_next_one_by_one(order):
    run = Run(*order)
    run.nodes["/S/impulse"].set("state:enableImpulse", True)
    seen = []
    for _ in range(3):
        run.update()
        seen.append((run.nodes["/R/count"].get("count"), run.nodes["/R/on"].get("path")))
    assert seen == [(0, ""), (2, "/World/Ball"), (2, "/World/Ball")]


PATHS = graph(
    "/R",
    {
        "on": ("OnCustomEvent", {"eventName": "go"}),
        "switch": ("SwitchToken", {"branch0": "/A", "branch1": "/B"}),
        "a": "Counter",
        "b": "Counter",
        "inner": ("ForLoop", {"stop": 2}),
    },
    "on.execOut -> inner.execIn",
    "inner.loopBody -> switch.execIn",
    "on.path -> switch.value",
    "switch.output0 -> a.execIn",
    "switch.output1 -> b.execIn",
)


def test_every_waiting_event_has_a_compute_and_a_walk_of_its_own():
    run = Run(PATHS)
    run.update()
    for path in ("/A", "/B", "/A", "/C"):
        run.context.events.send("custom:go", {"path": path}, update=run.context.update)
    run.update()
    assert [run.nodes[f"/R/{name}"].get("count") for name in "ab"] == [4, 2]
    assert run.nodes["/R/on"].computes == 1 + 4
    run.update()
    assert [run.nodes[f"/R/{name}"].get("count") for name in "ab"] == [4, 2]


def test_many_events_of_one_update_do_not_pile_up():
    nodes = {
        "tick": "OnPlaybackTick",
        "loop": ("ForLoop", {"stop": 3}),
        "send": ("SendCustomEvent", {"eventName": "go"}),
    }
    sender = graph("/S", nodes, "tick.tick -> loop.execIn", "loop.loopBody -> send.execIn")
    assert Run(sender, RECEIVER).counts("/R/count", 4) == [0, 3, 6, 9]


def test_a_node_that_sends_what_starts_it_goes_round_once_per_update():
    nodes = {
        "impulse": ("OnImpulseEvent", {}),
        "on": ("OnCustomEvent", {"eventName": "go"}),
        "send": ("SendCustomEvent", {"eventName": "go"}),
        "count": "Counter",
    }
    run = Run(
        graph(
            "/R", nodes, "impulse.execOut -> send.execIn", "on.execOut -> count.execIn", "count.execOut -> send.execIn"
        )
    )
    run.nodes["/R/impulse"].set("state:enableImpulse", True)
    assert run.counts("/R/count", 4) == [0, 1, 2, 3]


@pytest.mark.parametrize("late", [False, True], ids=["the receiver was there", "the receiver came later"])
def test_beyond_ten_thousand_the_oldest_events_are_lost_and_the_receiver_warns(late):
    run = Run(RECEIVER)
    log = run.context.warn = WarningLog()
    if not late:
        run.update()
    for number in range(10_003):
        run.context.events.send("custom:go", {"path": f"/N{number}"}, update=run.context.update)
    run.update(2)
    assert run.nodes["/R/count"].get("count") == 10_000
    assert [(one.code, one.where, one.message) for one in log] == [
        (
            "events-lost",
            "/R/on",
            '3 events "go" were lost: more than 10000 waited; send fewer in one update',
        )
    ]


def test_every_receiver_of_the_name_gets_it_and_no_other():
    receiver = graph(
        "/R",
        {
            "one": ("OnCustomEvent", {"eventName": "go"}),
            "two": ("OnCustomEvent", {"eventName": "go"}),
            "other": ("OnCustomEvent", {"eventName": "stop"}),
        },
    )
    run = Run(SENDER, receiver)
    run.nodes["/S/impulse"].set("state:enableImpulse", True)
    run.update(4)
    assert [run.nodes[f"/R/{name}"].fired["execOut"] for name in ("one", "two", "other")] == [2, 2, 0]


def test_events_while_nothing_plays_are_lost_unless_they_may_count():
    nodes = {
        "playing": ("OnCustomEvent", {"eventName": "go"}),
        "always": ("OnCustomEvent", {"eventName": "go", "onlyPlayback": False}),
    }
    run = Run(graph("/R", nodes))
    run.context.is_playing = False
    run.update()
    run.context.events.send("custom:go", {"path": "/A"}, update=run.context.update)
    run.update()
    run.context.is_playing = True
    run.update()
    assert [run.nodes[f"/R/{name}"].fired["execOut"] for name in ("playing", "always")] == [0, 1]


def test_message_bus_events_carry_their_payload():
    sender = graph(
        "/S",
        {
            "tick": "OnTick",
            "send": (
                "SendMessageBusEvent",
                {
                    "eventName": "state",
                    "speed": {"type": "double", "value": 2.5},
                    "name": {"type": "token", "value": "a"},
                },
            ),
        },
        "tick.tick -> send.execIn",
    )
    receiver = graph(
        "/R",
        {"on": ("OnMessageBusEvent", {"eventName": "state"}), "log": "Counter", "add": "Add"},
        "on.execOut -> log.execIn",
        "on.speed -> add.a",
        "on.speed -> add.b",
    )
    run = Run(sender, receiver)
    run.update(3)
    assert run.nodes["/R/log"].get("count") == 2
    assert run.nodes["/R/on"].get("outputs:speed") == 2.5


def test_a_payload_of_the_wrong_type_fails_the_receiver():
    receiver = graph(
        "/R",
        {"on": ("OnMessageBusEvent", {"eventName": "state"}), "drive": "IsaacArticulationController"},
        "on.entry -> drive.robotPath",
    )
    run = Run(receiver)
    run.update()
    run.context.events.send("message:state", {"entry": 5}, update=run.context.update)
    assert run.nodes["/R/on"].get_attribute("outputs:entry").get_type_name() == "string"
    with pytest.raises(ComputeError, match='event "state", entry entry: expected'):
        run.update()


def test_a_stop_forgets_what_is_on_its_way():
    run = Run(SENDER, RECEIVER)
    run.nodes["/S/impulse"].set("state:enableImpulse", True)
    run.update()
    for one in run.graphs:
        one.reset()
    run.context.events.clear()
    run.nodes["/S/impulse"].set("state:enableImpulse", False)
    assert run.counts("/R/count", 3) == [0, 0, 0]
