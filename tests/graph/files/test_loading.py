import json
import re
from fractions import Fraction
from pathlib import Path

import pytest

from graph.base.errors import Mark, UserError
from graph.files import examine, load, loads
from graph.spec.file_spec import ClockSpec, ConnectionSpec

DESIGN = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Ball:   {type: Sphere, radius: 0.2, translate: [3, 0, 2], rigid_body: true, mass: 1.0}
    /World/Lidar:
      type: OmniLidar
      config: Example_Rotary
      attributes: {"omni:sensor:tickRate": 10}
clock: {physics_hz: 240, loop_hz: 60, experience: base, parity: documented}
duration: 5.0
settings: {/rtx/hydra/supportMultiTickRate: true}
fidelity: {lidar.motion: frozen}
graphs:
  /World/ActionGraph:
    evaluator: execution
    pipeline_stage: simulation
    variables: {gain: {type: double, value: 2.0}}
    nodes:
      tick: OnPlaybackTick
      wait: {type: omni.graph.action.Countdown, inputs: {duration: 5, period: 1}}
    connections:
      - tick.tick -> wait.execIn
      - wait.finished -> [product.execIn, other.execIn]
record: {mcap: run.mcap}
"""


def test_the_example_of_the_format_says_what_it_says():
    spec = loads(DESIGN, name="design.yaml")
    assert spec.scene.prims["/World/Ball"] == {
        "type": "Sphere",
        "radius": 0.2,
        "translate": [3, 0, 2],
        "rigid_body": True,
        "mass": 1.0,
    }
    assert list(spec.scene.prims) == ["/World/Ground", "/World/Ball", "/World/Lidar"]
    assert spec.clock == ClockSpec(Fraction(240), Fraction(60), "base", "documented", Mark("design.yaml", 10, 1))
    assert spec.duration == 5
    assert spec.settings == {"/rtx/hydra/supportMultiTickRate": True}
    assert spec.fidelity == {"lidar.motion": "frozen"}
    [graph] = spec.graphs
    assert (graph.path, graph.evaluator, graph.pipeline_stage) == ("/World/ActionGraph", "execution", "simulation")
    assert graph.variables["gain"].type == "double"
    assert graph.variables["gain"].value == 2.0
    tick, wait = graph.nodes
    assert (tick.name, tick.type, tick.inputs) == ("tick", "OnPlaybackTick", {})
    assert (wait.type, wait.inputs) == ("omni.graph.action.Countdown", {"duration": 5, "period": 1})
    assert graph.connections == (
        ConnectionSpec("tick.tick", "wait.execIn", Mark("design.yaml", 23, 9)),
        ConnectionSpec("wait.finished", "product.execIn", Mark("design.yaml", 24, 27)),
        ConnectionSpec("wait.finished", "other.execIn", Mark("design.yaml", 24, 43)),
    )
    assert spec.record.mcap == "run.mcap"


def test_every_part_knows_its_place():
    spec = loads(DESIGN, name="d.yaml")
    [graph] = spec.graphs
    wait = graph.nodes[1]
    places = {
        "scene": spec.scene.mark,
        "prim": spec.scene.prim_marks["/World/Lidar",],
        "prim key": spec.scene.prim_marks["/World/Lidar", "config"],
        "setting": spec.marks["settings", "/rtx/hydra/supportMultiTickRate"],
        "knob": spec.marks["fidelity", "lidar.motion"],
        "rate": spec.marks["clock", "loop_hz"],
        "duration": spec.marks["duration",],
        "graph": graph.mark,
        "variable": graph.variables["gain"].mark,
        "node": wait.mark,
        "input": wait.input_marks["period"],
    }
    assert {what: (mark.line, mark.column) for what, mark in places.items()} == {
        "scene": (2, 1),
        "prim": (6, 5),
        "prim key": (8, 7),
        "setting": (12, 12),
        "knob": (13, 12),
        "rate": (10, 26),
        "duration": (11, 1),
        "graph": (15, 3),
        "variable": (18, 17),
        "node": (21, 7),
        "input": (21, 71),
    }


def as_plain(spec):
    graphs = [(g.path, [(n.name, n.type, n.inputs) for n in g.nodes], len(g.connections)) for g in spec.graphs]
    return (
        spec.scene.prims,
        spec.clock.physics_hz,
        spec.duration,
        spec.settings,
        spec.fidelity,
        graphs,
        spec.record.mcap,
    )


def test_json_and_yaml_say_the_same(tmp_path):
    from ruamel.yaml import YAML

    data = YAML(typ="safe", pure=True).load(DESIGN)
    (tmp_path / "d.json").write_text(json.dumps(data))
    (tmp_path / "d.yml").write_text(DESIGN)
    assert as_plain(load(tmp_path / "d.json")) == as_plain(load(tmp_path / "d.yml")) == as_plain(loads(DESIGN))


@pytest.mark.parametrize(
    "body",
    [
        "",
        "scene:\nclock:\nsettings:\ngraphs:\nrecord:\nfidelity:\nduration:\n",
        "scene: {}\nclock: {}\ngraphs: {}\nrecord: {}\n",
        "graphs: {/G: }",
        "graphs: {/G: {nodes: , connections: , variables: }}",
        "graphs: {/G: {nodes: {n: {type: X, inputs: , state: }}}}",
        "scene: {prims: {/World: }}",
        "clock: {physics_hz: 1000/3, loop_hz: '59.94'}",
        "clock: {experience: zero_delay, physics_hz: 60, loop_hz: 60.0}",
        "clock: {experience: zero_delay, loop_hz: 60}",
        "duration: 1/240",
        "settings: {/a/b: [1, 2.5, on, true], /c: text}",
        "fidelity: {lidar.subrays: 4, fabric: off, mesh.tolerance: 1e-3}",
        "graphs: {/World/Größe: {nodes: {früh: X, _1: Y}}}",
        "graphs: {/G: {nodes: &n {a: X}}, /H: {nodes: *n}}",
        "'graphs': {'/G': {'nodes': {'on': X, 'null': Y}}}",
        "# only a comment",
    ],
)
def test_good_files_are_loaded_with_the_graphs_that_they_write_out(body):
    spec = loads(f"tickgraph: 1\n{body}\n")
    assert [graph.path for graph in spec.graphs] == re.findall(r"'?(/(?:G|H|World/Größe))'?:", body)


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("60", Fraction(60)),
        ("29.97", Fraction(2997, 100)),
        ("30000/1001", Fraction(30000, 1001)),
        ("1e3", Fraction(1000)),
        ("'7.5'", Fraction(15, 2)),
        ("0.1", Fraction(1, 10)),
        ("1000 / 3", Fraction(1000, 3)),
    ],
)
def test_rates_are_exact(text, exact):
    assert loads(f"tickgraph: 1\nclock: {{physics_hz: {text}}}\n").clock.physics_hz == exact


def test_a_duration_written_as_a_rounded_fraction_means_the_fraction():
    assert loads("tickgraph: 1\nduration: 0.016666666666666666\n").duration == Fraction(1, 60)


def test_set_values_are_inputs_by_name_and_state_with_its_prefix():
    values = "inputs: {a: 1, 'inputs:b:c': 2, 'state:d': 3}, state: {e: 4}"
    [node] = loads(f"tickgraph: 1\ngraphs: {{/G: {{nodes: {{n: {{type: X, {values}}}}}}}}}\n").graphs[0].nodes
    assert node.inputs == {"a": 1, "b:c": 2, "state:d": 3, "state:e": 4}
    assert set(node.input_marks) == set(node.inputs)


def test_bytes_are_text_too():
    assert loads(b"tickgraph: 1\nduration: 2\n").duration == 2


def test_the_folder_of_a_text_is_the_current_one_or_the_one_given(tmp_path):
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    assert loads("tickgraph: 1\nscene: {usd: a.usda}\n", folder=tmp_path).scene.usd == tmp_path / "a.usda"
    assert loads("tickgraph: 1\n").folder == Path.cwd()


def test_examining_a_bad_file_gives_what_is_right_in_it(tmp_path):
    (tmp_path / "a.yaml").write_text(
        """\
tickgraph: 1
clock: {loop_hz: 30, physics_hz: 0}
oops: 1
graphs:
  /G:
    nodes:
      good: {type: X, inputs: {a: 1}, bad_key: 2}
      lost: 5
    connections:
      - good.x -> lost.y
      - /G/lost.y -> good.x
      - good.x -> absent.y
      - nonsense
  /H: 7
"""
    )
    examined = examine(tmp_path / "a.yaml")
    assert [problem.mark.line for problem in examined.problems] == [2, 3, 7, 8, 13, 14]
    assert examined.spec.clock.loop_hz == 30
    assert examined.spec.clock.physics_hz is None
    [graph] = examined.spec.graphs
    assert [(node.name, node.inputs) for node in graph.nodes] == [("good", {"a": 1})]
    # Connections of the lost node would only repeat its problem; the one to a node that never existed must still be
    # reported.
    assert [(c.source, c.target) for c in graph.connections] == [("good.x", "absent.y")]


def test_examining_unreadable_text_gives_no_specification(tmp_path):
    (tmp_path / "a.yaml").write_text("tickgraph: [1\n")
    examined = examine(tmp_path / "a.yaml")
    assert examined.spec is None
    assert len(examined.problems) == 1


def test_a_file_is_named_in_messages_as_the_user_named_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text("tickgraph: 1\nx: 1\n")
    with pytest.raises(UserError, match=r"^a\.yaml:2:1: "):
        load("a.yaml")
    with pytest.raises(UserError, match=r"^\./a\.yaml:2:1: "):
        load("./a.yaml")


def test_the_garbage_collector_is_as_before():
    import gc

    assert gc.isenabled()
    loads("tickgraph: 1\n")
    assert gc.isenabled()
    gc.disable()
    try:
        loads("tickgraph: 1\n")
        assert not gc.isenabled()
    finally:
        gc.enable()
