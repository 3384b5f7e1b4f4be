"""OmniGraph prims as people save them, read into a specification."""

import pytest

from graph.base.errors import Mark
from graph.files import load
from graph.session.load import load_graph

DRIVE = """
def Xform "World"
{
    def OmniGraph "ActionGraph"
    {
        token evaluationMode = "Automatic"
        token evaluator:type = "execution"
        token fabricCacheBacking = "StageWithoutHistory"
        int2 fileFormatVersion = (1, 9)
        custom double graph:variable:Speed = 5 (
            customData = { token scope = "private" }
            displayName = "Speed"
        )
        token pipelineStage = "pipelineStageSimulation"

        def OmniGraphNode "tick" ( prepend apiSchemas = ["NodeGraphNodeAPI"] )
        {
            token node:type = "omni.graph.action.OnPlaybackTick"
            int node:typeVersion = 2
            custom uint outputs:tick ( customData = { bool isExecution = 1 } )
            uniform float2 ui:nodegraph:node:pos = (1, 2)
        }

        def OmniGraphNode "wait"
        {
            custom int inputs:duration = 7
            custom uint inputs:execIn
            prepend uint inputs:execIn.connect = </World/ActionGraph/tick.outputs:tick>
            custom int inputs:period
            token node:type = "omni.graph.action.Countdown"
            int node:typeVersion = 2
        }

        def OmniGraphNode "product"
        {
            custom rel inputs:cameraPrim = </World/Lidar> (
                customData = { dictionary omni = { dictionary graph = { string relType = "target" } } }
            )
            uint inputs:execIn.connect = <../wait.outputs:finished>
            token node:type = "isaacsim.core.nodes.IsaacCreateRenderProduct"
            int node:typeVersion = 3
        }
    }
    def OmniLidar "Lidar" {}
}
"""


def node(spec, name, graph=0):
    return next(one for one in spec.graphs[graph].nodes if one.name == name)


def wires(spec, graph=0):
    return [f"{one.source} -> {one.target}" for one in spec.graphs[graph].connections]


def codes(spec):
    return [code for code, _, _ in spec.notes]


def wrapped(nodes, settings='token evaluator:type = "execution"'):
    return f'def OmniGraph "G"\n{{\n{settings}\n{nodes}\n}}\n'


def a_node(name, type_id, body=""):
    return f'def OmniGraphNode "{name}"\n{{\ntoken node:type = "{type_id}"\n{body}\n}}\n'


CONSTANT = "omni.graph.nodes.ConstantDouble"


def test_a_saved_graph_is_read_with_settings_values_targets_and_connections(usda):
    path = usda(DRIVE, head='metersPerUnit = 1\n upAxis = "Z"')
    spec = load(path)
    [graph] = spec.graphs
    assert (graph.path, graph.evaluator, graph.pipeline_stage) == ("/World/ActionGraph", "execution", "simulation")
    assert [one.name for one in graph.nodes] == ["tick", "wait", "product"]
    assert graph.variables["Speed"].type == "double"
    assert graph.variables["Speed"].value == 5.0
    assert node(spec, "wait").inputs == {"duration": 7}
    assert node(spec, "product").inputs == {"cameraPrim": "/World/Lidar"}
    assert wires(spec) == ["tick.tick -> wait.execIn", "wait.finished -> product.execIn"]
    assert spec.scene.usd == path
    assert spec.notes == ()


def test_marks_point_at_prims_values_and_connections_in_the_text(usda):
    path = usda(DRIVE)
    spec = load(path)
    wait = node(spec, "wait")
    assert wait.mark == Mark(str(path), 26, 9)
    assert wait.input_marks["duration"] == Mark(str(path), 28, 24)
    assert spec.graphs[0].connections[0].mark == Mark(str(path), 30, 26)


def test_it_compiles_and_the_values_arrive(usda):
    loaded = load_graph(usda(DRIVE))
    graph = loaded.graph("/World/ActionGraph")
    assert graph.nodes["wait"].get("duration") == 7
    assert graph.nodes["wait"].get("period") == 1  # declared without a value: the type's default


def test_list_edits_compose_over_layers(usda):
    usda(
        wrapped(
            a_node("a", CONSTANT)
            + a_node("b", CONSTANT)
            + a_node("add", "omni.graph.nodes.Add", "token inputs:a.connect = </G/a.inputs:value>")
        ),
        name="base.usda",
    )
    strong = """over "G" { over "add" {
        delete token inputs:a.connect = </G/a.inputs:value>
        prepend token inputs:a.connect = </G/b.inputs:value>
    }
}"""
    spec = load(usda(strong, head="subLayers = [@base.usda@]"))
    assert wires(spec) == ["b.inputs:value -> add.a"]


def test_a_referenced_graph_has_its_paths_where_it_is_used(usda):
    inner = wrapped(
        a_node("tick", "omni.graph.action.OnPlaybackTick")
        + a_node("n", "omni.graph.action.Counter", "uint inputs:execIn.connect = </Robot/G/tick.outputs:tick>")
    )
    usda(f'def Xform "Robot"\n{{\n{inner}\n}}', name="robot.usda")
    spec = load(usda('def "World"\n{\ndef "R2" (references = @robot.usda@</Robot>) {}\n}'))
    assert [graph.path for graph in spec.graphs] == ["/World/R2/G"]
    assert wires(spec) == ["tick.tick -> n.execIn"]


def test_quaternions_are_xyzw_and_matrices_rows(usda):
    body = wrapped(
        a_node("q", "omni.graph.nodes.ConstantQuatd", "quatd inputs:value = (0.5, 0.1, 0.2, 0.3)")
        + a_node(
            "m",
            "omni.graph.nodes.ConstantMatrix4d",
            "matrix4d inputs:value = ((1,0,0,0), (0,1,0,0), (0,0,1,0), (5,6,7,1))",
        )
        + a_node("f", "omni.graph.nodes.ConstantFloat", "float inputs:value = 0.1")
    )
    spec = load(usda(body))
    assert node(spec, "q").inputs["value"] == [0.1, 0.2, 0.3, 0.5]
    assert node(spec, "m").inputs["value"][3] == [5, 6, 7, 1]
    assert node(spec, "f").inputs["value"] == 0.1


def test_an_extended_attribute_has_its_type_and_value_from_custom_data(usda):
    custom = """( customData = { dictionary omni = { dictionary graph = {
        double attrValue = 2.5
        string resolvedType = "double"
    } } } )"""
    spec = load(usda(wrapped(a_node("add", "omni.graph.nodes.Add", f"custom token inputs:a {custom}"))))
    assert node(spec, "add").inputs == {"a": {"type": "double", "value": 2.5}}


def test_dynamic_attributes_of_open_types_keep_the_type_they_were_made_with(usda):
    spec = load(usda(wrapped(a_node("add", "omni.graph.nodes.Add", "custom float inputs:input2 = 3"))))
    assert node(spec, "add").inputs == {"input2": {"type": "float", "value": 3.0}}


@pytest.mark.parametrize(
    ("token", "evaluator"), [("push", "push"), ("dirty_push", "dirty_push"), ("execution", "execution")]
)
def test_evaluator_tokens(read, token, evaluator):
    spec = read(wrapped(a_node("c", CONSTANT), f'token evaluator:type = "{token}"')).spec
    assert spec.graphs[0].evaluator == evaluator


def test_without_an_evaluator_a_graph_is_a_push_graph(read):
    assert read(wrapped(a_node("c", CONSTANT), "")).spec.graphs[0].evaluator == "push"


@pytest.mark.parametrize(("gone", "now"), [("pull", "dirty_push"), ("execution_pull", "execution")])
def test_evaluators_that_are_gone_are_noted(read, gone, now):
    spec = read(wrapped(a_node("c", CONSTANT), f'token evaluator:type = "{gone}"')).spec
    assert spec.graphs[0].evaluator == now
    assert codes(spec) == ["evaluator-gone"]


@pytest.mark.parametrize(
    ("token", "stage"),
    [
        ("Simulation", "simulation"),
        ("PreRender", "pre_render"),
        ("PostRender", "post_render"),
        ("OnDemand", "on_demand"),
    ],
)
def test_pipeline_stage_tokens(read, token, stage):
    body = wrapped(
        a_node("c", CONSTANT), f'token evaluator:type = "push"\ntoken pipelineStage = "pipelineStage{token}"'
    )
    assert read(body).spec.graphs[0].pipeline_stage == stage


COMPOUND = """
def OmniGraph "G"
{
    token evaluator:type = "push"
    def OmniGraphNode "two"
    {
        double inputs:value = 2
        token node:type = "omni.graph.nodes.ConstantDouble"
    }
    def OmniGraphNode "twice" ( prepend apiSchemas = ["OmniGraphCompoundNodeAPI"] )
    {
        token node:type = "omni.graph.nodes.CompoundSubgraph"
        token omni:graph:compoundType = "subgraph"
        rel omni:graph:compoundGraph = </G/twice/Subgraph>
        custom token inputs:a
        token inputs:a.connect = </G/two.inputs:value>
        custom double inputs:b = 3
        custom token outputs:sum
        token outputs:sum.connect = </G/twice/Subgraph/add.outputs:sum>
        def OmniGraph "Subgraph"
        {
            def OmniGraphNode "add"
            {
                token node:type = "omni.graph.nodes.Add"
                token inputs:a.connect = </G/twice.inputs:a>
                double inputs:b.connect = </G/twice.inputs:b>
            }
        }
    }
    def OmniGraphNode "out"
    {
        token node:type = "omni.graph.nodes.Multiply"
        token inputs:a.connect = </G/twice.outputs:sum>
        token inputs:b.connect = </G/two.inputs:value>
    }
}
"""


def test_compounds_are_flattened_and_their_ports_resolved(usda):
    path = usda(COMPOUND)
    spec = load(path)
    assert [one.name for one in spec.graphs[0].nodes] == ["two", "twice/Subgraph/add", "out"]
    assert node(spec, "twice/Subgraph/add").inputs == {"b": {"type": "double", "value": 3.0}}
    assert wires(spec) == [
        "two.inputs:value -> twice/Subgraph/add.a",
        "twice/Subgraph/add.sum -> out.a",
        "two.inputs:value -> out.b",
    ]
    assert spec.graphs[0].compounds == {
        "twice": {
            "inputs:a": ("twice/Subgraph/add.inputs:a",),
            "inputs:b": ("twice/Subgraph/add.inputs:b",),
            "outputs:sum": ("twice/Subgraph/add.outputs:sum",),
        }
    }
    assert load_graph(path).graphs[0].nodes["twice/Subgraph/add"].path == "/G/twice/Subgraph/add"


OLD = """
def ComputeGraph "PushGraph"
{
    def ComputeGraphSettings "computegraphSettings"
    {
        custom token evaluator:type = "dirty_push"
        custom token flatCacheBacking = "Shared"
        custom int2 fileFormatVersion = (1, 3)
        custom token pipelineStage = "pipelineStageSimulation"
    }
    def ComputeNode "c"
    {
        custom token node:type = "omni.graph.nodes.ConstantInt"
        custom int inputs:value = 4
    }
}
"""


def test_the_old_compute_graph_layout_is_read(read):
    spec = read(OLD).spec
    assert spec.graphs[0].evaluator == "dirty_push"
    assert node(spec, "c").inputs == {"value": 4}
    assert codes(spec) == ["usd-old-layout"]


def test_graphs_on_many_prims_are_instances_with_their_own_variables(read):
    users = """def Xform "A" ( prepend apiSchemas = ["OmniGraphAPI"] )
    {
        rel omniGraphs = </G>
        custom double graph:variable:Speed = 9
    }
    def Xform "B"
    {
        rel omniGraphs = </G>
    }
    """
    body = wrapped(
        a_node("c", CONSTANT),
        'token evaluator:type = "push"\ntoken evaluationMode = "Instanced"\ncustom double graph:variable:Speed = 1',
    )
    [graph] = read(body + users).spec.graphs
    assert graph.evaluation_mode == "instanced"
    assert graph.instances == {"/A": {"Speed": 9.0}, "/B": {}}


def test_binary_files_read_the_same_and_messages_name_the_prim(usda, tmp_path):
    from graph.sim.usd import Sdf

    text = usda(DRIVE)
    binary = tmp_path / "scene.usdc"
    Sdf.Layer.FindOrOpen(str(text)).Export(str(binary))
    spec = load(binary)
    assert wires(spec) == ["tick.tick -> wait.execIn", "wait.finished -> product.execIn"]
    assert str(node(spec, "wait").input_marks["duration"]) == f"{binary}</World/ActionGraph/wait.inputs:duration>"
