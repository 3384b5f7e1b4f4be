"""graph convert, as a user sees it."""

import json
import subprocess
import sys

import pytest

from graph.cli.main import main
from graph.files import load

YAML = """\
# A drive for the yard.
# Second line.
tickgraph: 1
clock: {physics_hz: 240}
scene:
  prims:
    /World/Lidar: {type: OmniLidar}
graphs:
  # What the robot does.
  /World/G:
    variables: {speed: {type: double, value: 2.5}}
    nodes:
      # Starts it all.
      tick: OnPlaybackTick   # every update
      wait: {type: omni.graph.action.Countdown, inputs: {duration: 7, "odd#key": "a # b"}}
      turn: {type: omni.graph.nodes.ConstantQuatd, inputs: {value: [0.1, 0.2, 0.3, 0.5]}}
      add: {type: omni.graph.nodes.Add, inputs: {b: {type: float, value: 0.1}}}
      product: {type: isaacsim.core.nodes.IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
    connections:
      - tick.tick -> [wait.execIn, product.execIn]
      - tick.deltaSeconds -> add.a
"""


@pytest.fixture
def source(folder):
    (folder / "a.yaml").write_text(YAML)
    return folder


def test_yaml_to_yaml_keeps_every_byte(source, graph):
    assert graph("convert", "a.yaml", "b.yaml").code == 0
    assert (source / "b.yaml").read_text() == YAML


def test_usd_opens_with_plain_usd_and_looks_like_isaac_sims(source, graph):
    assert graph("convert", "a.yaml", "b.usda").code == 0
    look = """
from pxr import Usd
stage = Usd.Stage.Open("b.usda")
g = stage.GetPrimAtPath("/World/G")
print(g.GetTypeName(), g.GetAttribute("evaluator:type").Get(), g.GetAttribute("pipelineStage").Get())
print(g.GetAttribute("fileFormatVersion").Get(), g.GetAttribute("graph:variable:speed").Get())
wait = stage.GetPrimAtPath("/World/G/wait")
print(wait.GetTypeName(), wait.GetAttribute("node:type").Get(), wait.GetAttribute("node:typeVersion").Get())
print(wait.GetAttribute("inputs:duration").GetTypeName(), wait.GetAttribute("inputs:duration").Get())
exec_in = wait.GetAttribute("inputs:execIn")
print(exec_in.GetTypeName(), exec_in.GetCustomDataByKey("isExecution"), exec_in.GetConnections())
print(wait.GetAttribute("inputs:period").HasAuthoredValue(), wait.GetAttribute("outputs:tick").GetTypeName())
print(stage.GetPrimAtPath("/World/G/turn").GetAttribute("inputs:value").Get())
a = stage.GetPrimAtPath("/World/G/add").GetAttribute("inputs:a")
print(a.GetTypeName(), a.GetConnections())
print(stage.GetPrimAtPath("/World/G/add").GetAttribute("inputs:b").GetCustomDataByKey("omni:graph:resolvedType"))
camera = stage.GetPrimAtPath("/World/G/product").GetRelationship("inputs:cameraPrim")
print(camera.GetTargets(), camera.GetCustomDataByKey("omni:graph:relType"))
print(stage.GetPrimAtPath("/World/G/tick").GetDocumentation())
print(stage.GetRootLayer().customLayerData["tickgraph"]["clock"])
"""
    done = subprocess.run([sys.executable, "-c", look], cwd=source, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "OmniGraph execution pipelineStageSimulation",
        "(1, 9) 2.5",
        "OmniGraphNode omni.graph.action.Countdown 2",
        "int 7",
        "uint True [Sdf.Path('/World/G/tick.outputs:tick')]",
        "False uint",
        "(0.5, 0.1, 0.2, 0.3)",
        "token [Sdf.Path('/World/G/tick.outputs:deltaSeconds')]",
        "float",
        "[Sdf.Path('/World/Lidar')] target",
        "Starts it all.",
        "every update",
        "{'physics_hz': 240}",
    ]


def test_comments_come_back_from_usd_as_comments(source, graph):
    graph("convert", "a.yaml", "b.usda")
    graph("convert", "b.usda", "c.yaml")
    text = (source / "c.yaml").read_text()
    assert text.startswith("# A drive for the yard.\n# Second line.\ntickgraph: 1\n")
    assert "  # What the robot does.\n  /World/G:\n" in text
    assert "      # Starts it all.\n      # every update\n      tick: OnPlaybackTick\n" in text
    assert "      - tick.tick -> wait.execIn\n      - tick.tick -> product.execIn\n" in text


COMMENTED = """\
# head
# above the version
tickgraph: 1
# above the clock
clock: {physics_hz: 120} # beside it
scene:
  prims:
    # above a prim
    /World/B: {type: Cube, translate: [0, 0, 1]}
graphs: # all
  # above a graph
  /World/G: # beside it
    variables: # beside variables
      v: {type: double, value: 1.0} # beside one
    # above the nodes
    nodes:
      t: OnTick
      # above a node
      s:
        type: ScriptNode
        # inside a node
        inputs:
          script: |
            # code, no comment
            x = 1  # neither
      c: {type: LogMessage, inputs: {message: '#text'}}
    connections:
      # above a connection
      - t.tick -> [s.execIn, c.execIn] # beside it
    # below the connections
# the end
"""


def test_every_comment_survives_usd_where_it_stood(source, graph):
    (source / "c.yaml").write_text(COMMENTED)
    for step in ("c.yaml c.usda", "c.usda d.yaml", "d.yaml d.usda", "d.usda e.usda", "e.usda f.yaml"):
        assert graph("convert", *step.split()).code == 0
    assert (source / "d.yaml").read_text() == (source / "f.yaml").read_text()
    assert (
        (source / "d.yaml").read_text()
        == """\
# head
# above the version
tickgraph: 1
# above the clock
# beside it
clock: {physics_hz: 120}
scene:
  prims:
    # above a prim
    /World/B: {type: Cube, translate: [0, 0, 1]}
# all
graphs:
  # above a graph
  # beside it
  /World/G:
    # beside variables
    variables:
      # beside one
      v: {type: double, value: 1.0}
    # above the nodes
    nodes:
      t: OnTick
      # above a node
      # inside a node
      s: {type: ScriptNode, inputs: {script: "# code, no comment\\nx = 1  # neither\\n"}}
      c: {type: LogMessage, inputs: {message: "#text"}}
    connections:
      # above a connection
      # beside it
      - t.tick -> s.execIn
      - t.tick -> c.execIn
# below the connections
# the end
"""
    )


def test_json_says_the_same(source, graph):
    graph("convert", "a.yaml", "b.json")
    document = json.loads((source / "b.json").read_text())
    assert document["graphs"]["/World/G"]["nodes"]["wait"]["inputs"] == {"duration": 7, "odd#key": "a # b"}


def test_the_scene_is_a_sublayer_with_its_units_and_found_from_another_folder(source, graph):
    (source / "s.usda").write_text('#usda 1.0\n(\nmetersPerUnit = 0.01\nupAxis = "Y"\n)\ndef Cube "C" {\n}\n')
    (source / "d.yaml").write_text("tickgraph: 1\nscene: {usd: s.usda}\ngraphs: {/World/G: {nodes: {t: OnTick}}}\n")
    (source / "sub").mkdir()
    assert graph("convert", "d.yaml", "sub/e.usda").code == 0
    text = (source / "sub" / "e.usda").read_text()
    assert "@../s.usda@" in text
    assert "metersPerUnit = 0.01" in text
    assert 'upAxis = "Y"' in text
    assert graph("convert", "sub/e.usda", "f.yaml", "--allow", ".").code == 0
    assert load(source / "f.yaml").scene.usd == source / "s.usda"


def test_a_saved_scene_becomes_a_graph_file_over_that_scene(source, graph):
    (source / "saved.usda").write_text(
        '#usda 1.0\ndef OmniGraph "G" {\ntoken evaluator:type = "execution"\n'
        'def OmniGraphNode "t" {\ntoken node:type = "omni.graph.action.OnTick"\nuint inputs:framePeriod = 2\n}\n}\n'
    )
    assert graph("convert", "saved.usda", "out.yaml").code == 0
    assert (source / "out.yaml").read_text() == (
        "tickgraph: 1\nscene:\n  usd: saved.usda\ngraphs:\n  /G:\n    lenient: true\n    nodes:\n"
        "      t: {type: omni.graph.action.OnTick, inputs: {framePeriod: 2}}\n"
    )


def test_compounds_become_nodes_of_the_graph_and_that_is_reported(source, graph):
    inner = 'def OmniGraphNode "add" {\ntoken node:type = "omni.graph.nodes.Add"\n}\n'
    (source / "saved.usda").write_text(
        '#usda 1.0\ndef OmniGraph "G" {\ntoken evaluator:type = "execution"\n'
        'def OmniGraphNode "c" {\ntoken node:type = "omni.graph.nodes.CompoundSubgraph"\n'
        f'def OmniGraph "Subgraph" {{\n{inner}}}\n}}\n}}\n'
    )
    for target in ("out.yaml", "out.usda"):
        said = "/G: the nodes in c become its own, such as c/Subgraph/add; the ports are gone"
        assert f"warning compound-flattened: saved.usda:2:1: {said}\n" in graph("convert", "saved.usda", target).err
    assert [node.name for node in load(source / "out.yaml").graphs[0].nodes] == ["c/Subgraph/add"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("a.yaml", "b.txt"),
            "b.txt: unknown extension; use one of .yaml, .yml, .json, .usda, .usd, .usdc",
        ),
        (("a.yaml", "a.yaml"), "a.yaml is the file to convert; name another one to write"),
        (("none.yaml", "b.json"), "none.yaml: no such file; did you mean"),
        (("a.yaml", "nowhere/b.json"), "nowhere/b.json: there is no folder"),
    ],
)
def test_wrong_use_is_reported_and_writes_nothing(source, graph, arguments, message):
    before = sorted(path.name for path in source.iterdir())
    result = graph("convert", *arguments)
    assert result.code == 2
    assert message in result.err
    assert sorted(path.name for path in source.iterdir()) == before


def test_two_things_that_would_be_one_prim_are_reported(folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\ngraphs: {/A: {nodes: {b: OnTick}}, /A/b: {nodes: {c: OnTick}}}\n")
    result = graph("convert", "a.yaml", "b.usda")
    assert result.code == 2
    assert result.err == 'a.yaml:2:36: graph /A/b and node "b" of /A would be one prim in USD; rename one\n'
    assert not (folder / "b.usda").exists()


def test_the_command_says_so_in_usd_too_when_a_type_is_unknown(source, graph):
    (source / "u.yaml").write_text("tickgraph: 1\ngraphs: {/G: {nodes: {x: {type: my.Own, inputs: {a: 1}}}}}\n")
    assert graph("convert", "u.yaml", "u.usda").code == 0
    result = graph("check", "u.usda")
    assert result.code == 2
    assert 'node "x": no node type "my.Own"' in result.err


def test_the_scene_of_a_file_is_not_overwritten_by_its_conversion(tmp_path, capsys):
    scene = tmp_path / "s.usda"
    scene.write_text('#usda 1.0\n\ndef Xform "World"\n{\n}\n')
    (tmp_path / "s.yaml").write_text("tickgraph: 1\nscene: {usd: s.usda}\n")
    assert main(["convert", str(tmp_path / "s.yaml"), str(scene)]) == 2
    assert "is the scene of" in capsys.readouterr().err
    assert scene.read_text().startswith('#usda 1.0\n\ndef Xform "World"')


def test_a_file_that_names_files_outside_its_new_folder_says_what_to_allow(folder, graph):
    for name in ("mine", "other"):
        (folder / name).mkdir()
    (folder / "mine" / "scene.usda").write_text('#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n)\n')
    (folder / "mine" / "a.yaml").write_text("tickgraph: 1\nscene: {usd: scene.usda}\n")
    assert graph("convert", "mine/a.yaml", "mine/b.yaml").err == ""
    for name in ("other/a.yaml", "other/a.json", "other/a.usda"):
        moved = graph("convert", "mine/a.yaml", name)
        assert moved.code == 0
        said = "it names ../mine/scene.usda, outside its folder; give --allow mine with it, or move the files"
        assert moved.err == f"warning files-outside: {name}: {said}\n"
        assert graph("check", name).code == 2
        assert graph("check", name, "--allow", "mine").code == 0
