"""Prims that nodes name by paths as text, and written numbers that no run would take, found before a run."""

import pytest

from graph.node.registry import DEFAULT
from graph.session.open import build_parts
from tests.support.without_wing import MISSING_NAMES

BY_TEXT = [(one.id, name) for one in DEFAULT.all() for name in one.inputs_as("prim")]


def problems(tmp_path, node_type, inputs):
    """The messages about one node with these inputs, on a stage with one cube that physics does not move."""
    shown = ", ".join(f"{name}: {value}" for name, value in inputs.items())
    file = tmp_path / "g.yaml"
    file.write_text(
        "tickgraph: 1\nscene: {prims: {/World/Cube: {type: Cube}}}\n"
        f"graphs: {{/G: {{nodes: {{one: {{type: {node_type}, inputs: {{{shown}}}}}}}}}}}\n"
    )
    return [one.message for one in build_parts(file).problems]


@pytest.mark.parametrize(("node_type", "name"), BY_TEXT)
def test_a_path_as_text_must_name_a_prim(tmp_path, node_type, name):
    kind = DEFAULT.get(node_type)
    use = {"usePath": "true"} if "usePath" in kind.inputs else {}
    use |= {"value": "1.0"} if "value" in kind.inputs else {}
    path = "[{}]" if str(kind.inputs[name].type).endswith("[]") else "{}"
    gone = f'/G/one.inputs:{name}: there is no prim /World/Cub on the stage; did you mean "/World/Cube"?'
    assert gone in problems(tmp_path, node_type, {name: path.format("/World/Cub"), **use})
    assert not any("no prim" in one for one in problems(tmp_path, node_type, {name: path.format("/World/Cube"), **use}))


def test_nodes_that_name_prims_by_text_are_known():
    named = {"IsaacArticulationController", "ReadPrimAttribute", "WritePrimMaterial", "OnContactEventBasic"}
    assert named - MISSING_NAMES <= {node_type.rpartition(".")[2] for node_type, _ in BY_TEXT}


def test_a_path_that_usePath_leaves_unused_is_not_checked(tmp_path):
    inputs = {"usePath": "false", "prim": "/World/Cube", "primPath": "/World/Gone", "name": "size"}
    assert problems(tmp_path, "ReadPrimAttribute", inputs) == []


def test_a_path_of_a_property_needs_its_prim(tmp_path):
    assert problems(tmp_path, "OnObjectChange", {"path": "/World/Cube.size"}) == []
    assert problems(tmp_path, "OnObjectChange", {"path": "/World/Gone.size"}) != []


@pytest.mark.parametrize(
    ("node_type", "inputs", "problem"),
    [
        ("Countdown", {"period": 0}, "period: 0 is too small; give it 1 or more"),
        ("Countdown", {"duration": -1}, "duration: -1 is too small; give it 0 or more"),
        ("Delay", {"duration": ".inf"}, "duration: inf s does not end; give it a finite number of seconds"),
        ("Timer", {"duration": -0.5}, "duration: -0.5 is too small; give it 0 or more"),
        ("ForLoop", {"step": 0}, "step: 0 leads nowhere; give the loop a positive or negative step"),
        ("Divide", {"a": 1.0, "b": 0.0}, "b: it contains 0; division by zero"),
        ("Modulo", {"a": 1, "b": 0}, "b: it contains 0; division by zero"),
        ("Logarithm", {"base": 1.0, "value": 2.0},
         "base: 1 is not the base of a logarithm; it must be above 0 and not 1"),
        ("Ease", {"blendExponent": -1, "alpha": 0.5, "start": 0.0, "end": 1.0},
         "blendExponent: -1 is too small; give it 0 or more"),
        ("RandomGaussian", {"mean": 0.0, "stdev": -1.0}, "stdev: -1 is too small; give it 0 or more"),
        ("DifferentialController", {"wheelRadius": -0.1, "wheelDistance": 1},
         "wheelRadius: -0.1 is too small; give it 0 or more"),
        ("IsaacReadIMU", {"imuPrim": "/World/Cube"},
         "imuPrim: /World/Cube is on no rigid body; put it on one, or below"),
        ("IsaacReadContactSensor", {"csPrim": "/World/Cube"},
         "csPrim: /World/Cube is on no rigid body; put it on one, or below"),
        ("ROS2SubscribeTransformTree", {"frameNamesMap": "[/World/Gone, a]"},
         "frameNamesMap: there is no prim /World/Gone on the stage; correct the path"),
        ("ROS2SubscribeTransformTree", {"frameNamesMap": "[/World/Cube]"},
         "frameNamesMap: frameNamesMap has 1 entries; it needs pairs of prim path and frame name"),
    ],
)  # fmt: skip
def test_values_that_no_run_would_take_are_found_in_the_file(tmp_path, node_type, inputs, problem):
    assert problems(tmp_path, node_type, inputs) == [f"/G/one.inputs:{problem}"]
