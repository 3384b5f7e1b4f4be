"""A converted file runs as the one it was made of: run(convert(f)) = run(f), in messages, computes and failures."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.cli.convert import convert
from graph.session.open import open_session
from graph.sim.messages.bus import MemorySink
from graph.sim.messages.ros_types import serialize

from .test_messy_files import CASES, COUNTER, TICK, UNITS, a_node, graph_text

UPDATES = 12
EXEC = "uint inputs:execIn.connect = </G/{}>"
CLOCK = "isaacsim.ros2.bridge.ROS2PublishClock"
BASE = (
    a_node("tick", TICK)
    + a_node("time", "isaacsim.core.nodes.IsaacReadSimulationTime")
    + a_node(
        "clock",
        CLOCK,
        EXEC.format("tick.outputs:tick") + "\ndouble inputs:timeStamp.connect = </G/time.outputs:simulationTime>",
    )
)
"""What runs beside every awkward part: 12 updates send 12 clocks."""

PARTS = {
    "unknown type": a_node("own", "my.Own", EXEC.format("tick.outputs:tick") + "\ncustom double inputs:x = 3"),
    "old type": a_node("old", "omni.isaac.core_nodes.IsaacReadSystemTime", "custom int inputs:swhFrameNumber = 3"),
    "removed attribute": a_node(
        "read", "isaacsim.core.nodes.IsaacReadSimulationTime", "custom int inputs:swhFrameNumber = 3"
    ),
    "unknown attribute": a_node("odd", COUNTER, EXEC.format("tick.outputs:tick") + "\ncustom int inputs:nothing = 3"),
    "value of another type": a_node(
        "bad", "omni.graph.action.Countdown", EXEC.format("tick.outputs:tick") + '\ncustom string inputs:duration = "x"'
    ),
    "unset input": a_node("text", "omni.graph.nodes.ToString")
    + a_node(
        "print",
        "omni.graph.ui_nodes.PrintText",
        EXEC.format("tick.outputs:tick") + "\nstring inputs:text.connect = </G/text.outputs:converted>",
    ),
    "source that is gone": a_node("lost", COUNTER, EXEC.format("gone.outputs:x")),
    "source that is not an attribute": a_node("lost2", COUNTER, EXEC.format("tick.outputs:tock")),
    "prim that is gone": a_node(
        "product",
        "isaacsim.core.nodes.IsaacCreateRenderProduct",
        EXEC.format("tick.outputs:tick") + "\nrel inputs:cameraPrim = </World/Gone>",
    ),
    "script": a_node(
        "script",
        "omni.graph.scriptnode.ScriptNode",
        EXEC.format("tick.outputs:tick") + '\ncustom string inputs:script = "def compute(db): raise ValueError"',
    ),
    "two sources": a_node("one", "omni.graph.nodes.ConstantDouble", "double inputs:value = 1")
    + a_node("other", "omni.graph.nodes.ConstantDouble", "double inputs:value = 2")
    + a_node(
        "late",
        CLOCK,
        EXEC.format("tick.outputs:tick")
        + '\nstring inputs:topicName = "late"\n'
        + "double inputs:timeStamp.connect = [</G/one.inputs:value>, </G/other.inputs:value>]",
    ),
    "unknown first source": a_node("maker", "my.Own", "custom double outputs:x = 7")
    + a_node("known", "omni.graph.nodes.ConstantDouble", "double inputs:value = 2")
    + a_node(
        "after",
        CLOCK,
        EXEC.format("tick.outputs:tick")
        + '\nstring inputs:topicName = "after"\n'
        + "double inputs:timeStamp.connect = [</G/maker.outputs:x>, </G/known.inputs:value>]",
    ),
    "bad topic": a_node("topic", CLOCK, EXEC.format("tick.outputs:tick") + '\nstring inputs:topicName = "no topic"'),
    "no type": a_node("none", ""),
    "unsettled types": a_node("add", "omni.graph.nodes.Add")
    + a_node("more", "omni.graph.nodes.ToString", "token inputs:value.connect = </G/add.outputs:sum>"),
    "text where numbers belong": a_node(
        "vector",
        "omni.graph.nodes.ToString",
        'custom token inputs:value = "(90, 0, 0)"',
    ),
    "a later version": a_node("new", COUNTER, EXEC.format("tick.outputs:tick") + "\nint node:typeVersion = 99"),
    "missing variable": a_node("speed", "omni.graph.core.ReadVariable", 'token inputs:variableName = "gone"'),
    "robot that is gone": a_node(
        "joints",
        "isaacsim.ros2.bridge.ROS2PublishJointState",
        EXEC.format("tick.outputs:tick") + "\nrel inputs:targetPrim = </World/Robot>",
    ),
}
MISSING = 'def Xform "Prop" (prepend references = @./gone.usda@)\n{\n}\n'


def ran(path, **options):
    """What a file does: computes by node, messages by topic as bytes, and why it ended or did not start."""
    try:
        session = open_session(path, **options)
    except UserError as error:
        # Places differ; the node, and what is wrong with it, do not.
        return {str(problem.message) for problem in error.problems}
    with session.app as app:
        sink, failure = MemorySink(), ""
        app.bus.subscribe(sink)
        try:
            app.play()
            app.update(UPDATES)
        except RunError as error:
            failure = str(error).rpartition(": ")[2]
        computes = {
            node.path: node.computes for graph in session.runner.graphs.values() for node in graph.nodes.values()
        }
        sent = {
            topic: [(one.stamp_ns, one.sent_ns, serialize(one.message, one.type_name)) for one in messages]
            for topic, messages in sink.messages.items()
        }
    return computes, sent, failure


def same_in_all_formats(file: Path, **options):
    """Runs the file, the YAML made of it, the JSON made of that, the USD made of that; returns what the file did."""
    expected, source = ran(file, **options), file
    for name in ("1.yaml", "2.json", "3.usda", "4.yaml"):
        target = file.parent / name
        convert(str(source), str(target))
        assert ran(target, **options) == expected, name
        source = target
    return expected


@pytest.mark.parametrize("skip", [False, True])
@pytest.mark.parametrize("part", PARTS)
def test_an_awkward_part_does_the_same_in_every_format(usda, part, skip):
    result = same_in_all_formats(usda(graph_text(BASE + PARTS[part]), head=UNITS), skip_unknown=skip)
    if "unknown" in part and not skip and "attribute" not in part:
        assert any("no node type" in problem for problem in result)
    elif part != "bad topic":  # which ends a run
        assert len(result[1]["/clock"]) == UPDATES


@pytest.mark.parametrize("case", CASES)
def test_a_messy_file_does_the_same_in_every_format(usda, case):
    same_in_all_formats(usda(CASES[case][0], head=UNITS), skip_unknown=True)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sets(st.sampled_from(sorted(PARTS)), min_size=2, max_size=6), st.booleans(), st.booleans(), st.booleans())
def test_awkward_parts_together_do_the_same_in_every_format(tmp_path_factory, parts, skip, missing, push):
    folder = tmp_path_factory.mktemp("scene")
    text = graph_text(BASE + "".join(PARTS[one] for one in sorted(parts)), evaluator="push" if push else "execution")
    file = folder / "scene.usda"
    file.write_text(f"#usda 1.0\n({UNITS})\n{text}{MISSING if missing else ''}")
    same_in_all_formats(file, skip_unknown=skip)


def test_the_known_source_counts_where_the_first_one_is_left_out(usda):
    """The first source's type is unknown, the second is a constant 2: the stamp is 2 s in all 12 messages."""
    _, sent, _ = same_in_all_formats(
        usda(graph_text(BASE + PARTS["unknown first source"]), head=UNITS), skip_unknown=True
    )
    assert [stamp for stamp, _, _ in sent["/after"]] == [2 * 10**9] * UPDATES


def test_a_strict_file_stays_strict(tmp_path):
    file = tmp_path / "strict.yaml"
    file.write_text("tickgraph: 1\ngraphs:\n  /G:\n    nodes: {n: {type: Counter, inputs: {nothing: 3}}}\n")
    convert(str(file), str(tmp_path / "strict.usda"))
    for path in (file, tmp_path / "strict.usda"):
        with pytest.raises(UserError, match="nothing"):
            open_session(path)


def test_a_vector_that_a_file_keeps_as_text_is_a_vector(usda):
    """A node that copies the open value "(90, 0, 0)" to a double3 of the stage computes in every update."""
    write = a_node(
        "write",
        "omni.graph.nodes.WritePrimAttribute",
        EXEC.format("tick.outputs:tick")
        + '\nbool inputs:usePath = 1\ntoken inputs:primPath = "/Cube"\ntoken inputs:name = "turn"\n'
        + 'custom token inputs:value = "(90, 0, 0)"',
    )
    cube = 'def Cube "Cube"\n{\ncustom double3 turn = (0, 0, 0)\n}\n'
    computes, _, failure = same_in_all_formats(usda(graph_text(BASE + write) + cube, head=UNITS))
    assert (computes["/G/write"], failure) == (UPDATES, "")
