"""What a node is stands in its declaration: third-party types get every treatment that the shipped ones get."""

import pytest

from graph import Attribute, Database, NodeType, UserError, node_type
from graph.cli.explanation import explain
from graph.cli.idle_parts import silent_parts, wired_sensors
from graph.node import NodeAtLoad, finders
from graph.node.registry import Registry
from graph.session.open import build_parts, open_session
from tests.support.without_wing import needs_wing

REGISTRY = Registry(finders.ALL)
IN, OUT = Attribute("execution", "go"), Attribute("execution", "then")


@node_type(
    "acme.Render",
    inputs={"go": IN, "eye": Attribute("target", "sensor", role="sensor")},
    outputs={"made": Attribute("token", "path", role="product"), "then": OUT},
    registry=REGISTRY,
)
def render(db: Database) -> None:
    """Have a sensor rendered."""
    from sensors.products import render_product

    db.outputs.made = render_product(db.app, str(db.inputs.eye[0])).path
    db.fire("then")


@node_type(
    "acme.Watch",
    inputs={"go": IN, "film": Attribute("token", "product", role="product")},
    outputs={"then": OUT},
    registry=REGISTRY,
)
def watch(db: Database) -> None:
    """Begin with a frame."""
    db.fire("then")


def _long_enough(node: NodeAtLoad):
    if "channel" in node.given and len(node.db.inputs.channel) < 3:
        yield "channel", f"is too short for {len(node.sensors)} sensors"
    if node.sensors == ("/World/Blind",):
        yield "", "its sensor is blind"


@node_type(
    "acme.Say",
    inputs={
        "go": IN,
        "channel": Attribute("string", "topic", default="talk", role="topic"),
        "at": Attribute("double", "time", role="stamp"),
        "film": Attribute("token", "product", role="product"),
    },
    check=_long_enough,
    registry=REGISTRY,
)
def say(db: Database) -> None:
    """Say nothing."""


@node_type("acme.Clock", outputs={"now": Attribute("double", "time", role="timeline time")}, registry=REGISTRY)
def clock(db: Database) -> None:
    """Tell the timeline's time."""
    db.outputs.now = db.context.time


@node_type("acme.Nap", inputs={"go": IN}, outputs={"then": OUT}, latent=True, registry=REGISTRY)
def nap(db: Database) -> None:
    """Sleep."""
    db.sleep()


@node_type("acme.Pass", inputs={"go": IN}, outputs={"then": OUT}, registry=REGISTRY)
def pass_on(db: Database) -> None:
    """Go on."""
    db.fire("then")


SCENE = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [4, 0, 1]}
    /World/Eye: {type: OmniLidar, config: Example_Rotary, translate: [0, 0, 1]}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
"""
MADE = """\
  /World/G:
    nodes:
      tick: OnPlaybackTick
      render: {type: acme.Render, inputs: {eye: /World/Eye}}
      say: {type: acme.Say, inputs: {channel: words}}
      clock: acme.Clock
    connections:
      - tick.tick -> render.go
      - render.then -> say.go
"""
WATCHED = """\
  /World/P:
    pipeline_stage: post_render
    nodes:
      watch: acme.Watch
      count: Counter
    connections:
      - /World/G/render.made -> watch.film
      - watch.then -> count.execIn
"""


@pytest.fixture
def opened(tmp_path):
    sessions = []

    def open_(text, **options):
        (tmp_path / "g.yaml").write_text(SCENE + text)
        sessions.append(open_session(tmp_path / "g.yaml", registry=REGISTRY, **options))
        return sessions[-1]

    yield open_
    for session in sessions:
        session.app.close()


@pytest.fixture
def noted(tmp_path):
    """(code, message) of each warning of a file."""

    def note(text):
        (tmp_path / "g.yaml").write_text(SCENE + text)
        parts = build_parts(tmp_path / "g.yaml", registry=REGISTRY)
        assert parts.problems == []
        return [(code, message) for code, _, message in parts.warnings]

    return note


def test_a_new_frame_starts_the_node_that_names_its_product(opened):
    """A 10 Hz lidar ticks at 0.1 k s: 3 frames in 20 updates of 1/60 s."""
    session = opened(MADE + WATCHED)
    session.app.play()
    session.app.update(steps=20)
    assert session.runner.graphs["/World/P"].node("count").computes == 3


def test_a_publisher_that_sends_nothing_and_the_sensors_that_nodes_name_are_reported(opened):
    session = opened(MADE)
    assert [*wired_sensors(session.app, session.runner)] == ["/World/Eye"]
    session.app.play()
    session.app.update(steps=2)
    assert "publisher /World/G/say sent no message" in silent_parts(session.app, session.runner)


def test_explain_knows_the_maker_of_a_product_the_topic_and_the_stamp(opened):
    told = explain(opened(MADE + "      - clock.now -> say.at\n"), "g.yaml")
    [sensor] = told["sensors"]
    assert sensor["made_by"] == ["/World/G/render"]
    assert [(topic["topic"], topic["publishers"]) for topic in told["topics"]] == [("/words", ["/World/G/say"])]
    traps = {(trap["code"], trap["where"]) for trap in told["traps"]}
    assert ("timeline-stamp", "/World/G/say.inputs:at") in traps
    told = explain(opened(MADE), "g.yaml")
    assert ("timestamp-unconnected", "/World/G/say.inputs:at") in {(t["code"], t["where"]) for t in told["traps"]}


def test_a_type_checks_the_values_and_the_wiring_of_its_nodes_at_load(opened):
    with pytest.raises(UserError, match=r"g.yaml:12:\d+: /World/G/say.inputs:channel: is too short for 0 sensors"):
        opened(MADE.replace("words", "w"))
    blind = MADE.replace("/World/Eye", "/World/Blind") + "      - render.made -> say.film\n"
    with pytest.raises(UserError, match=r"/World/G/say: its sensor is blind"):
        opened(blind)


def test_a_role_that_nobody_knows_is_an_error_of_the_declaration():
    with pytest.raises(ValueError, match=r"acme.X: inputs a: role 'tpic' is not one of topic, stamp"):
        NodeType("acme.X", inputs={"a": Attribute("string", "a", role="tpic")})


# -- graphs that never run, execution that goes round


def one(nodes, connections=(), stage="simulation"):
    lines = [f"  /World/G:\n    pipeline_stage: {stage}\n    nodes: {{{nodes}}}\n"]
    return "".join([*lines, "    connections:\n" if connections else "", *(f"      - {c}\n" for c in connections)])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (one("p: acme.Pass"), "it has no event node; add one, such as OnPlaybackTick"),
        (one("p: acme.Pass", stage="post_render"), "no node of it is started by a frame"),
        (one("p: acme.Pass", stage="on_demand"), "on_demand graphs wait for a node such as OnPhysicsStep"),
    ],
)
def test_a_graph_that_nothing_starts_is_warned_of(noted, text, why):
    [(code, message)] = noted(text)
    assert code == "graph-never-runs"
    assert why in message


@pytest.mark.parametrize(
    "text",
    [
        one("t: OnTick"),
        one("t: OnTick", stage="post_render"),
        one("w: acme.Watch", stage="post_render"),
        one("s: OnPhysicsStep", stage="on_demand"),
        one("c: OnClosing"),
        "  /World/G: {evaluator: push, nodes: {c: acme.Clock}}\n",
        one("c: ConstantDouble"),
    ],
)
def test_a_graph_that_something_starts_is_not(noted, text):
    assert noted(text) == []


@needs_wing("replicator")
def test_an_event_in_a_post_render_graph_fires_in_each_update_with_a_frame(opened):
    entry = one("e: GpuInteropRenderProductEntry, t: OnPlaybackTick, c: Counter", ["e.exec -> c.execIn"], "post_render")
    session = opened(MADE + entry.replace("/World/G", "/World/P"))
    session.app.play()
    session.app.update(steps=20)
    nodes = session.runner.graphs["/World/P"].nodes
    # a 10 Hz lidar in 20 updates of 1/60 s
    assert (nodes["c"].computes, nodes["t"].fired["tick"]) == (3, 3)


ROUND = ["t.tick -> a.go", "a.then -> b.go", "b.then -> a.go"]


def test_execution_that_goes_round_is_warned_of(noted):
    [(code, message)] = noted(one("t: OnTick, a: acme.Pass, b: acme.Pass", ROUND))
    assert code == "execution-cycle"
    assert "(a -> b -> a)" in message


@pytest.mark.parametrize("waits", ["acme.Nap", "Countdown", "Branch"])
def test_a_node_on_the_way_that_waits_or_decides_ends_it(noted, waits):
    names = {"Countdown": ("execIn", "finished"), "Branch": ("execIn", "execTrue")}.get(waits, ("go", "then"))
    way = [line.replace("b.go", f"b.{names[0]}").replace("b.then", f"b.{names[1]}") for line in ROUND]
    assert noted(one(f"t: OnTick, a: acme.Pass, b: {waits}", way)) == []
