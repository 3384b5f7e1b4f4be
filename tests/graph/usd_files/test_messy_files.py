"""What real files carry along: each survives, each with one clear line."""

import json

import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.node import registry
from graph.session.load import load_graph

TICK = "omni.graph.action.OnPlaybackTick"
COUNTER = "omni.graph.action.Counter"
COMPOUND = "omni.graph.nodes.CompoundSubgraph"
CONSTANT = "omni.graph.nodes.ConstantDouble"
UNITS = 'metersPerUnit = 1; upAxis = "Z"'
EXEC = "uint inputs:execIn.connect = </G/{}>"


def graph_text(nodes, evaluator="execution", path="G"):
    return f'def OmniGraph "{path}"\n{{\ntoken evaluator:type = "{evaluator}"\n{nodes}\n}}\n'


def a_node(name, type_id, body=""):
    return f'def OmniGraphNode "{name}"\n{{\ntoken node:type = "{type_id}"\n{body}\n}}\n'


def user(name, graphs, body=""):
    """A prim that has graphs."""
    return (
        f'def Xform "{name}" (\nprepend apiSchemas = ["OmniGraphAPI"]\n)\n{{\nrel omniGraphs = {graphs}\n{body}\n}}\n'
    )


CASES = {
    "empty graph": (graph_text(""), "usd-empty-graph", "3:1: /G has no nodes"),
    "over-only file": (
        'over "Robot"\n{\nover "ActionGraph"\n{\nover "tick"\n{\ncustom string inputs:topicName = "x"\n}\n}\n}\n',
        "usd-over-only",
        "/Robot/ActionGraph: 1 prim (tick) only override nodes that no file defines; left out",
    ),
    "overs that name their types": (
        'over OmniGraph "G"\n{\nover OmniGraphNode "tick"\n{\ntoken node:type = "omni.graph.action.OnTick"\n}\n}\n',
        "usd-over-only",
        "5:1: /G: 1 prim (tick) only override nodes that no file defines; left out",
    ),
    "nodes outside every graph": (
        'def Xform "World"\n{\n' + a_node("a", TICK) + a_node("b", TICK) + "}\n",
        "usd-node-outside",
        "5:1: 2 nodes (a, b) in no graph; only nodes below an OmniGraph prim compute",
    ),
    "variable of a type that OmniGraph lacks": (
        graph_text("custom string[] graph:variable:V = []\n" + a_node("tick", TICK)),
        "usd-variable-type",
        '6:17: /G: the variable "V" is left out; OmniGraph has no type string[]',
    ),
    "compound whose graph is missing": (
        graph_text(
            a_node("tick", TICK)
            + a_node(
                "c",
                COMPOUND,
                "rel omni:graph:compoundGraph = </G/c/Gone>\n"
                "uint inputs:go.connect = </G/tick.outputs:tick>\ncustom uint outputs:done",
            )
            + a_node("n", COUNTER, EXEC.format("c.outputs:done"))
        ),
        "usd-empty-compound",
        "11:1: /G/c is a compound whose graph is missing; it does nothing",
    ),
    "compound without a graph": (
        graph_text(a_node("tick", TICK) + a_node("c", COMPOUND)),
        "usd-empty-compound",
        "11:1: /G/c is a compound whose graph is missing; it does nothing",
    ),
    "unknown evaluation mode": (
        graph_text('token evaluationMode = "Foo"\n' + a_node("tick", TICK)),
        "evaluation-mode-unknown",
        '3:1: /G has the unknown evaluation mode "Foo"; it runs as automatic',
    ),
    "instanced graph that no prim has": (
        graph_text('token evaluationMode = "Instanced"\n' + a_node("tick", TICK)),
        "usd-no-instances",
        "3:1: /G runs for the prims that have it (evaluationMode Instanced), and none has",
    ),
    "prim that has what is not a graph": (
        graph_text(a_node("tick", TICK)) + user("A", "[</G>, </A>]") + user("B", "</A>"),
        "usd-instance-lost",
        "13:1: /A, named in omniGraphs of 2 prims (A, B), is not a graph that runs",
    ),
    "prim that has a graph without the API schema": (
        graph_text(a_node("tick", TICK)) + 'def Xform "A"\n{\nrel omniGraphs = </G>\n}\n',
        "usd-instance-schema",
        "13:1: omniGraphs of 1 prim (A) counts, though the API schema OmniGraphAPI is not applied",
    ),
    "variable of an instance that its graph lacks": (
        graph_text("custom int graph:variable:n = 1\n" + a_node("tick", TICK))
        + user("A", "</G>", "custom int graph:variable:n = 2\ncustom int graph:variable:gone = 2"),
        "usd-instance-variable",
        "14:1: /A gives values to gone, which no graph of it has; they are left out",
    ),
    "node of a newer type": (
        graph_text("".join(a_node(name, TICK, "int node:typeVersion = 99") for name in "ab")),
        "type-newer",
        "6:1: OnPlaybackTick is of version 99 in the file and of version 2 here; what is new is left out",
    ),
    "animated input": (
        graph_text(
            a_node("w", "omni.graph.action.Delay", "double inputs:duration.timeSamples = {\n0: 1,\n10: 2,\n}\n")
        ),
        "value-animated",
        "9:8: time samples move no graph; one value counts of 1 attribute (w.inputs:duration)",
    ),
    "attribute of an unknown type, composed": (
        'class OmniGraph "_G"\n{\nininint2 fileFormatVersion = (1, 9)\n'
        + a_node("w", "omni.graph.action.Countdown", "ininint2 inputs:duration = (1, 9)")
        + '}\ndef OmniGraph "G" (inherits = </_G>)\n{\nover "w"\n{\nint inputs:period = 2\n}\n}\n',
        "value-left-out",
        "the value is left out",
    ),
    "connection to a missing prim": (
        graph_text(a_node("n", COUNTER, "uint inputs:execIn.connect = </G/gone.outputs:tick>")),
        "usd-lost-connection",
        "9:6: /G/n.inputs:execIn is fed by /G/gone.outputs:tick, but that is not a node of a graph",
    ),
    "two sources on one data input": (
        graph_text(
            a_node("a", CONSTANT)
            + a_node("b", CONSTANT)
            + a_node(
                "w",
                "omni.graph.action.Delay",
                "double inputs:duration.connect = [</G/a.inputs:value>, </G/b.inputs:value>]",
            )
        ),
        "two-sources",
        "/G/w.duration has two sources; a.inputs:value counts, b.inputs:value does not",
    ),
    "Replicator pipeline": (
        'def "Replicator" {' + graph_text(a_node("n", "omni.replicator.core.OgnSampler"), path="SDGPipeline") + "}",
        "usd-replicator",
        "/Replicator/SDGPipeline is a Replicator pipeline (1 nodes) saved by accident; left out",
    ),
    "event node in a push graph": (
        graph_text(a_node("tick", TICK), "push"),
        "event-in-push-graph",
        "/G is a push graph with event nodes (tick)",
    ),
    "missing referenced asset": (
        'def "Robot" (references = @./nowhere/robot.usd@) {}\n' + graph_text(a_node("tick", TICK)),
        "usd-missing-asset",
        "./nowhere/robot.usd does not exist; it is left out",
    ),
    "asset behind a URL": (
        'def "Robot" (payload = @https://example.com/robot.usd@) {}\n' + graph_text(a_node("tick", TICK)),
        "usd-missing-asset",
        "robot.usd is not downloaded (https://example.com/robot.usd; give its folder with --asset-root ",
    ),
    "attribute that the type lost": (
        graph_text(a_node("t", "isaacsim.core.nodes.IsaacReadSimulationTime", "int64 inputs:swhFrameNumber = 3")),
        "attribute-removed",
        "IsaacReadSimulationTime: inputs:swhFrameNumber is gone and is left out",
    ),
    "attribute that the type never had": (
        graph_text(a_node("tick", TICK, "int inputs:nonsense = 3")),
        "attribute-unknown",
        "OnPlaybackTick has no inputs:nonsense (any more); its value is left out",
    ),
    "connection from an output that does not exist": (
        graph_text(a_node("tick", TICK) + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/tick.outputs:tock>")),
        "attribute-unknown",
        "tick.tock does not exist; the connection is left out",
    ),
    "types that cannot meet": (
        graph_text(
            a_node("t", "omni.graph.nodes.ConstantString")
            + a_node("w", "omni.graph.action.Delay", "double inputs:duration.connect = </G/t.inputs:value>")
        ),
        "connection-left-out",
        "the connection is left out",
    ),
    "value that does not fit": (
        graph_text(a_node("w", "omni.graph.action.Countdown", 'string inputs:period = "long"')),
        "value-left-out",
        "the value is left out, and the default counts: 1",
    ),
    "node without a type": (
        graph_text(a_node("tick", TICK) + 'def OmniGraphNode "bare"\n{\nint inputs:x = 3\n}\n'),
        "usd-no-type",
        "/G/bare has no node type; it is left out, with its connections",
    ),
    "old id": (
        graph_text(a_node("c", "omni.isaac.ros2_bridge.ROS2Context")),
        "type-renamed",
        'node type "omni.isaac.ros2_bridge.ROS2Context" is now called "isaacsim.ros2.bridge.ROS2Context"',
    ),
    "ROS 1 id": (
        graph_text(a_node("c", "omni.isaac.ros_bridge.ROS1PublishClock")),
        "type-renamed",
        'the ROS 1 node type "omni.isaac.ros_bridge.ROS1PublishClock" is gone; its ROS 2 twin',
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_it_loads_with_one_line(usda, case):
    body, code, message = CASES[case]
    loaded = load_graph(usda(body, head=UNITS))
    told = [f"{where}: {text}" for one, where, text in loaded.spec.notes if one == code]
    assert len(told) == 1, loaded.spec.notes
    assert message in told[0]
    assert [one for one, _, _ in loaded.spec.notes] == [code]


@pytest.mark.parametrize("case", [*CASES, "fed output", "unknown type"])
def test_a_file_that_composes_nothing_is_read_as_one_that_may(read, case):
    """Prims of the one are read straight from its layer; a comment makes it one of the other kind."""
    more = {
        "fed output": a_node("n", COUNTER, "int outputs:count.connect = </G/n.outputs:count>"),
        "unknown type": a_node("n", "my.Own", "custom double[3] outputs:x = (1, 2, 3)\ncustom rel outputs:y = </G>"),
    }
    body = CASES[case][0] if case in CASES else graph_text(more[case])
    alone, composed = read(body).spec, read(body + "# references\n").spec
    assert alone == composed


def test_a_prim_with_two_graphs_gives_each_the_variables_that_it_has(usda):
    variables = (("G", "a"), ("H", "b"))
    graphs = [
        graph_text(f"custom int graph:variable:{one} = 1\n" + a_node("tick", TICK), path=path)
        for path, one in variables
    ]
    values = "custom int graph:variable:a = 2\ncustom int graph:variable:b = 3"
    loaded = load_graph(usda("".join(graphs) + user("A", "[</G>, </H>]", values), head=UNITS))
    assert [dict(graph.instances) for graph in loaded.spec.graphs] == [{"/A": {"a": 2}}, {"/A": {"b": 3}}]
    assert loaded.spec.notes == ()


def test_a_node_whose_source_is_gone_does_nothing_and_the_run_goes_on(usda, capsys):
    body = graph_text(
        a_node("tick", TICK)
        + a_node("text", "omni.graph.nodes.ToString", "token inputs:value.connect = </G/gone.outputs:x>")
        + a_node("speed", "omni.graph.core.ReadVariable", 'token inputs:variableName = "gone"')
        + a_node(
            "print",
            "omni.graph.ui_nodes.PrintText",
            "uint inputs:execIn.connect = </G/tick.outputs:tick>\n"
            "string inputs:text.connect = </G/text.outputs:converted>",
        )
        + a_node("more", "omni.graph.nodes.ToString", "token inputs:value.connect = </G/speed.outputs:value>")
        + a_node(
            "again",
            "omni.graph.ui_nodes.PrintText",
            "uint inputs:execIn.connect = </G/print.outputs:execOut>\n"
            "string inputs:text.connect = </G/more.outputs:converted>",
        )
        + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/again.outputs:execOut>")
    )
    assert main(["run", str(usda(body)), "--updates", "3", "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["nodes"]["/G/n"]["computes"] == 3
    assert "/G/text: input value is not set. Give it a value or connect it. (3 times)" in told.err
    assert '/G/speed: the graph has no variable "gone"' in told.err


def test_an_old_id_is_reported_once_with_how_many_more_there_are(usda):
    old = "omni.isaac.core_nodes.IsaacReadSimulationTime"
    loaded = load_graph(usda(graph_text("".join(a_node(name, old) for name in "abc"))))
    [(code, _, message)] = loaded.spec.notes
    assert code == "type-renamed"
    assert message.endswith("the new name is used (and 2 more)")


ELSEWHERE = (
    "; no node package is installed, and --nodes FILE.py brings types of your own; "
    "--skip-unknown runs the rest of the file"
)


def test_unknown_types_are_reported_together_with_their_places(usda):
    with pytest.raises(UserError) as caught:
        load_graph(usda(graph_text(a_node("a", "my.own.One") + a_node("tick", TICK) + a_node("b", "my.own.Two"))))
    assert [str(one).partition("scene.usda:")[2] for one in caught.value.problems] == [
        '6:1: node "a": no node type "my.own.One"' + ELSEWHERE,
        '16:1: node "b": no node type "my.own.Two"' + ELSEWHERE,
    ]


def test_a_near_name_does_not_hide_that_the_rest_can_run(usda):
    with pytest.raises(UserError) as caught:
        load_graph(usda(graph_text(a_node("a", "omni.graph.action.Countdwn") + a_node("b", "omni.graph.nodes.AddAll"))))
    assert [one.message for one in caught.value.problems] == [
        'node "a": no node type "omni.graph.action.Countdwn"; did you mean "omni.graph.action.Countdown"? '
        "--skip-unknown runs the rest of the file",
        'node "b": no node type "omni.graph.nodes.AddAll"; did you mean "omni.graph.nodes.Add"? '
        "--skip-unknown runs the rest of the file",
    ]


def test_check_counts_the_prims_of_a_scene_without_graphs_and_nodes(usda, capsys):
    path = usda('def Xform "World"\n{\ndef Cube "Box"\n{\n}\n}\n' + graph_text(a_node("tick", TICK)))
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out.endswith(": ok, 1 graph, 1 node, 0 connections, 2 prims\n")


def test_skip_unknown_runs_the_rest(usda, capsys):
    body = graph_text(
        a_node("tick", TICK)
        + a_node("x", "my.own.One", "uint inputs:execIn.connect = </G/tick.outputs:tick>")
        + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/tick.outputs:tick>")
    )
    path = usda(body)
    loaded = load_graph(path, skip_unknown=True)
    assert list(loaded.graphs[0].nodes) == ["tick", "n"]
    assert main(["run", str(path), "--skip-unknown", "--updates", "3", "--json"]) == 0
    out, err = capsys.readouterr()
    assert '"computes": 3' in out
    assert 'there is no node type "my.own.One" here; 1 node of it left out (x)' in err
    assert main(["run", str(path), "--updates", "3"]) == 2


def test_what_an_unknown_node_fed_is_not_reported_as_unset_and_does_nothing_if_it_is_skipped(tmp_path, capsys):
    path = tmp_path / "a.yaml"
    path.write_text("""\
tickgraph: 1
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      guess: my.own.Guess
      text: omni.graph.nodes.ToString
      print: PrintText
      n: Counter
    connections:
      - guess.value -> text.value
      - text.converted -> print.text
      - tick.tick -> [print.execIn, n.execIn]
""")
    assert main(["check", str(path)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert 'no node type "my.own.Guess"' in line
    assert main(["run", str(path), "--skip-unknown", "--updates", "3", "--json"]) == 0
    told = capsys.readouterr()
    assert "input-not-set: /G/text: input value is not set. Give it a value or connect it. (3 times)" in told.err
    assert json.loads(told.out)["nodes"]["/G/n"]["computes"] == 3


def test_an_input_whose_connection_is_wrong_is_not_reported_as_unset_too(tmp_path, capsys):
    path = tmp_path / "a.yaml"
    path.write_text(
        "tickgraph: 1\ngraphs: {/G: {nodes: {t: OnPlaybackTick, s: omni.graph.nodes.ToString}, "
        "connections: [t.gone -> s.value]}}\n"
    )
    assert main(["check", str(path)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert 'node "t" (OnPlaybackTick) has no output "gone"' in line


TWO_HELPERS = (
    a_node("tick", TICK)
    + a_node(
        "old",
        "isaacsim.ros2.bridge.ROS2CameraHelper",
        "uint inputs:execIn.connect = </G/tick.outputs:tick>\n"
        'token inputs:renderProductPath = "/Render/OmniverseKit/HydraTextures/Replicator_04"',
    )
    + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/tick.outputs:tick>")
)


def test_a_helper_of_a_render_product_that_was_not_saved_does_not_stop_the_others(usda, capsys):
    path = usda(graph_text(TWO_HELPERS))
    assert main(["check", str(path)]) == 0
    assert "render-product-missing" in (said := capsys.readouterr().err)
    assert "no node makes the render product /Render/OmniverseKit/HydraTextures/Replicator_04" in said
    assert main(["run", str(path), "--updates", "3", "--json"]) == 0
    assert "input-not-set: /G/old: there is no render product" in capsys.readouterr().err
    assert main(["run", str(path), "--updates", "3", "--on-error", "stop"]) == 1


def test_a_lidar_of_a_scene_whose_lists_disagree_is_reported_with_its_file(usda, capsys):
    lidar = 'def OmniLidar "Lidar" (prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI"])\n{\n'
    lidar += "float[] omni:sensor:Core:emitterState:s001:elevationDeg = [5]\n"
    lidar += "float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [0]\n}\n"
    assert main(["check", str(usda(lidar))]) == 2
    assert capsys.readouterr().err.endswith(
        "scene.usda: lidar config /Lidar: numberOfEmitters is 128, emitter state s001 lists 1; make both the same\n"
    )


def test_a_node_that_cannot_work_does_not_stop_the_others(usda, capsys):
    """A laser scan, the default of the lidar helper, of a lidar with beams out of the plane."""
    body = (
        'def OmniLidar "Lidar" (prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI", '
        '"OmniSensorGenericLidarCoreEmitterStateAPI:s001"])\n{\n'
        "float[] omni:sensor:Core:emitterState:s001:elevationDeg = [15]\n"
        "float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [0]\n"
        "uint[] omni:sensor:Core:emitterState:s001:fireTimeNs = [0]\nuint omni:sensor:Core:numberOfEmitters = 1\n}\n"
        + graph_text(
            a_node("tick", TICK)
            + a_node(
                "product",
                "isaacsim.core.nodes.IsaacCreateRenderProduct",
                "uint inputs:execIn.connect = </G/tick.outputs:tick>\nrel inputs:cameraPrim = </Lidar>",
            )
            + a_node(
                "scan",
                "isaacsim.ros2.bridge.ROS2RtxLidarHelper",
                "uint inputs:execIn.connect = </G/product.outputs:execOut>\n"
                "token inputs:renderProductPath.connect = </G/product.outputs:renderProductPath>",
            )
            + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/tick.outputs:tick>")
        )
    )
    path = usda(body)
    assert main(["run", str(path), "--updates", "5", "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["nodes"]["/G/n"]["computes"] == 5
    assert "node-cannot-work" in told.err
    assert "or publish its point_cloud" in told.err


def test_skip_unknown_holds_for_yaml_too(tmp_path, capsys):
    path = tmp_path / "a.yaml"
    path.write_text(
        "tickgraph: 1\ngraphs: {/G: {nodes: {t: OnPlaybackTick, x: my.Own}, connections: [t.tick -> x.in]}}\n"
    )
    assert main(["check", str(path)]) == 2
    assert main(["check", str(path), "--skip-unknown"]) == 0
    assert "left out (x)" in capsys.readouterr().err


def test_a_node_whose_prim_came_with_a_missing_asset_does_not_stop_the_others(usda, capsys):
    body = 'def "Robot" (references = @./gone.usd@) {}\n' + graph_text(
        a_node("tick", TICK)
        + a_node(
            "drive",
            "isaacsim.core.nodes.IsaacArticulationController",
            "uint inputs:execIn.connect = </G/tick.outputs:tick>\nrel inputs:targetPrim = </Robot>",
        )
        + a_node("n", COUNTER, "uint inputs:execIn.connect = </G/tick.outputs:tick>")
    )
    path = usda(body)
    assert main(["run", str(path), "--updates", "5", "--json"]) == 0
    assert main(["run", str(path), "--updates", "5", "--on-error", "stop"]) == 1


def test_a_value_that_a_layer_below_has_for_another_type_is_left_out(usda):
    usda('over "G"\n{\nover "n"\n{\ntoken inputs:value = "x"\n}\n}\n', name="below.usda")
    node = a_node("n", CONSTANT, "double inputs:value")
    loaded = load_graph(usda(graph_text(node), head="subLayers = [@below.usda@]"))
    assert [(code, where.rpartition("/")[2]) for code, where, _ in loaded.spec.notes] == [
        ("value-left-out", "scene.usda:9:8")
    ]


def test_no_type_ends_the_run_of_a_saved_scene_where_its_inputs_are_unset(usda, capsys):
    """The generators of node types leave such a file beside each: one node in a push graph, nothing connected."""
    nodes = "".join(a_node(f"n{number}", one.id) for number, one in enumerate(registry.all()))

    assert main(["run", str(usda(graph_text(nodes, "push"))), "--updates", "2"]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(("options", "result"), [([], 0), (["--on-error", "stop"], 1)])
def test_a_robot_without_joints_does_not_end_the_run_of_a_saved_scene(usda, capsys, options, result):
    body = (
        'def Xform "Robot"\n{\ndef Cube "base" (\nprepend apiSchemas = ["PhysicsRigidBodyAPI"]\n)\n{\n}\n}\n'
    ) + graph_text(
        a_node("tick", TICK)
        + "".join(
            a_node(name, f"isaacsim.{kind}", "rel inputs:targetPrim = </Robot>\n" + EXEC.format("tick.outputs:tick"))
            for name, kind in (
                ("drive", "core.nodes.IsaacArticulationController"),
                ("state", "core.nodes.IsaacArticulationState"),
                ("joints", "ros2.bridge.ROS2PublishJointState"),
            )
        )
    )

    assert main(["run", str(usda(body)), "--updates", "2", *options]) == result

    told = capsys.readouterr().err
    what = "/Robot: no revolute or prismatic joint is there"
    for name in ("drive", "state", "joints"):
        assert (f"input-not-set: /G/{name}: {what} (2 times)" in told) == (not options)
    assert what in told


def test_an_array_made_as_isaac_sim_2022_made_it_is_constructed(usda, capsys, caplog):
    nodes = a_node("tick", TICK) + "".join(
        a_node(name, CONSTANT, f"double inputs:value = {value}") for name, value in (("x", 1.5), ("y", -2))
    )
    nodes += a_node(
        "array",
        "omni.graph.nodes.MakeArray",
        "int inputs:arraySize = 2\ncustom token inputs:a\ncustom token inputs:b\ncustom token inputs:c\n"
        "token inputs:a.connect = </G/x.inputs:value>\ntoken inputs:b.connect = </G/y.inputs:value>",
    )
    nodes += a_node("text", "omni.graph.nodes.ToString", "token inputs:value.connect = </G/array.outputs:array>")
    nodes += a_node(
        "print",
        "omni.graph.ui_nodes.PrintText",
        EXEC.format("tick.outputs:tick") + "\nstring inputs:text.connect = </G/text.outputs:converted>",
    )

    with caplog.at_level("INFO", "tickgraph"):
        assert main(["run", str(usda(graph_text(nodes))), "--updates", "1"]) == 0

    assert "[1.5, -2.0]" in caplog.messages
    assert [line.split(":")[0] for line in capsys.readouterr().err.splitlines() if line.startswith("warning")] == [
        "warning type-renamed",
        "warning attribute-renamed",
        "warning attribute-renamed",
    ]
