"""graph convert over a scene that holds the original graphs: what was deleted stays deleted."""

import json

import pytest

from graph.cli.convert import convert
from graph.files import examine
from graph.files.document import graph_document

SCENE = """#usda 1.0
def OmniGraph "G" (doc = "an old comment")
{
    token evaluator:type = "execution"
    custom float graph:variable:Speed = 1.5
    custom float graph:variable:Turn = 2.5
    def OmniGraphNode "tick" {
        token node:type = "omni.graph.action.OnPlaybackTick"
    }
    def OmniGraphNode "tick2" {
        token node:type = "omni.graph.action.OnTick"
    }
    def OmniGraphNode "c" {
        token node:type = "omni.graph.action.Counter"
        custom uint inputs:execIn
        uint inputs:execIn.connect = [</G/tick.outputs:tick>, </G/tick2.outputs:tick>]
        custom uint inputs:reset
        uint inputs:reset.connect = </G/tick2.outputs:tick>
    }
    def OmniGraphNode "k" {
        token node:type = "omni.graph.nodes.ConstantDouble"
        custom double inputs:value = 2
    }
    def OmniGraphNode "add" {
        token node:type = "omni.graph.nodes.Add"
        custom token inputs:a
        token inputs:a.connect = </G/k.inputs:value>
        custom token inputs:b (customData = {dictionary omni = {dictionary graph = {
            string attrType = "Any"
            string resolvedType = "double"
            double attrValue = 3
        }}})
    }
    def OmniGraphNode "old" {
        token node:type = "omni.graph.nodes.Add"
        custom token inputs:a (customData = {string "omni:graph:resolvedType" = "int"
            int "omni:graph:attrValue" = 3})
    }
    def OmniGraphNode "get" {
        token node:type = "omni.graph.nodes.ReadPrimAttribute"
        custom rel inputs:prim = </World/Box>
        custom token inputs:name = "size"
    }
}
def OmniGraph "Other" {
        token evaluator:type = "execution"
    def OmniGraphNode "tick" {
        token node:type = "omni.graph.action.OnPlaybackTick"
    }
}
def Xform "World" {
    def Cube "Box" (prepend apiSchemas = ["OmniGraphAPI"]) {
        rel omniGraphs = </G>
        custom float graph:variable:Turn = 7
    }
}
"""


def said(path):
    """What a file says of its graphs, by path."""
    examined = examine(path)
    assert not examined.problems, examined.problems
    return {graph.path: graph_document(graph) for graph in examined.spec.graphs}


@pytest.fixture
def files(tmp_path):
    (tmp_path / "scene.usda").write_text(SCENE)
    convert(str(tmp_path / "scene.usda"), str(tmp_path / "a.yaml"))
    return tmp_path


def through_usd(files):
    """a.yaml, and what it became by way of USD."""
    convert(str(files / "a.yaml"), str(files / "b.usda"))
    convert(str(files / "b.usda"), str(files / "c.yaml"))
    return (files / "a.yaml").read_text(), (files / "c.yaml").read_text()


def edit(path, *changes):
    text = path.read_text()
    for old, new in changes:
        assert text.count(old) == 1, (old, text)
        text = text.replace(old, new)
    path.write_text(text)


def test_a_scene_comes_back_as_it_is(files):
    before, after = through_usd(files)
    assert after == before


@pytest.mark.parametrize(
    "changes",
    [
        [("      - tick2.tick -> c.execIn\n", "")],
        [("      - tick2.tick -> c.reset\n", "")],
        [('      - "k.inputs:value -> add.a"\n', "")],
        [
            ("      tick2: omni.graph.action.OnTick\n", ""),
            ("      - tick2.tick -> c.execIn\n", ""),
            ("      - tick2.tick -> c.reset\n", ""),
        ],
        [("{type: omni.graph.nodes.ConstantDouble, inputs: {value: 2.0}}", "omni.graph.nodes.ConstantDouble")],
        [("inputs: {prim: /World/Box, name: size}", "inputs: {name: size}")],
        [("{type: omni.graph.nodes.Add, inputs: {b: {type: double, value: 3.0}}}", "omni.graph.nodes.Add")],
        [("b: {type: double, value: 3.0}", "b: {type: int, value: 4}")],
        [("{type: omni.graph.nodes.Add, inputs: {a: {type: int, value: 3}}}", "omni.graph.nodes.Add")],
        [("a: {type: int, value: 3}", "a: {type: int, value: 5}")],
        [("      Turn: {type: float, value: 2.5}\n", ""), (" {Turn: 7.0}", " {}")],
        [(", value: 1.5", "")],
        [(" {Turn: 7.0}", " {}")],
        [("    instances: {/World/Box: {Turn: 7.0}}\n", "")],
        [("  /Other:\n    lenient: true\n    nodes:\n      tick: omni.graph.action.OnPlaybackTick\n", "")],
        [("  # an old comment\n", "")],
        [("      c: omni", "      new: omni.graph.action.Counter\n      c: omni")],
    ],
)
def test_what_an_edit_deletes_stays_deleted(files, changes):
    edit(files / "a.yaml", *changes)
    before, after = through_usd(files)
    assert after == before
    # And once more over the layer that hides it.
    convert(str(files / "b.usda"), str(files / "d.usda"))
    assert said(files / "d.usda") == said(files / "b.usda")


def test_a_deleted_thing_can_come_back(files):
    whole = (files / "a.yaml").read_text()
    edit(files / "a.yaml", (", inputs: {value: 2.0}", ""), (", inputs: {b: {type: double, value: 3.0}}", ""))
    through_usd(files)
    (files / "e.yaml").write_text(whole.replace("usd: scene.usda", "usd: b.usda"))
    convert(str(files / "e.yaml"), str(files / "f.usda"))
    convert(str(files / "f.usda"), str(files / "g.yaml"))
    assert said(files / "g.yaml") == said(files / "e.yaml")


def test_a_node_without_a_type_is_left_out_with_a_line(tmp_path):
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\ndef OmniGraph "G" {\n token evaluator:type = "execution"\n def OmniGraphNode "n" {\n }\n'
        ' def OmniGraphNode "c" {\n  token node:type = "omni.graph.action.Counter"\n'
        "  uint inputs:execIn.connect = </G/n.outputs:x>\n }\n}\n"
    )
    notes = convert(str(tmp_path / "a.usda"), str(tmp_path / "a.yaml"))
    assert [(code, message) for code, _, message in notes if code == "usd-no-type"] == [
        ("usd-no-type", "/G/n has no node type; it is left out, with its connections")
    ]
    assert said(tmp_path / "a.yaml") == {"/G": {"lenient": True, "nodes": {"c": "omni.graph.action.Counter"}}}


def test_a_compound_without_its_nodes_is_gone(tmp_path):
    (tmp_path / "a.usda").write_text("""#usda 1.0
def OmniGraph "G" {
    token evaluator:type = "execution"
    def OmniGraphNode "k" {
        token node:type = "omni.graph.nodes.ConstantDouble"
    }
    def OmniGraphNode "comp" {
        token node:type = "omni.graph.nodes.CompoundSubgraph"
        rel omni:graph:compoundGraph = </G/comp/Sub>
        def OmniGraph "Sub" {
            token evaluator:type = "execution"
            def OmniGraphNode "m" {
                token node:type = "omni.graph.nodes.Multiply"
            }
        }
    }
}
""")
    convert(str(tmp_path / "a.usda"), str(tmp_path / "a.yaml"))
    edit(tmp_path / "a.yaml", ("      comp/Sub/m: omni.graph.nodes.Multiply\n", ""))
    before, after = through_usd(tmp_path)
    assert after == before


def test_an_order_that_the_scene_notes_itself_does_not_count_any_more(tmp_path):
    """The scene is a file of our own writer; over it lies one with the same parts in the opposite order."""
    folder = tmp_path
    first = {
        "tickgraph": 1,
        "graphs": {
            "/G": {
                "variables": {"v": {"type": "int"}, "a": {"type": "int"}},
                "nodes": {"sub/b": {"type": "Add", "inputs": {"b": 1, "a": 2}}, "x": "OnTick", "sub/a": "OnTick"},
            }
        },
    }
    graph = first["graphs"]["/G"]
    turned = {
        "variables": dict(reversed(graph["variables"].items())),
        "nodes": {"sub/a": "OnTick", "x": "OnTick", "sub/b": {"type": "Add", "inputs": {"a": 2, "b": 1}}},
    }
    (folder / "first.json").write_text(json.dumps(first))
    convert(str(folder / "first.json"), str(folder / "first.usda"))
    second = {"tickgraph": 1, "scene": {"usd": "first.usda"}, "graphs": {"/G": turned}}
    (folder / "second.json").write_text(json.dumps(second))
    convert(str(folder / "second.json"), str(folder / "second.usda"))
    convert(str(folder / "second.usda"), str(folder / "third.json"))
    assert json.dumps(json.loads((folder / "third.json").read_text())["graphs"]["/G"]) == json.dumps(turned)
