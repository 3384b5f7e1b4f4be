"""Paths and targets made of others."""

import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of

AB, ABA = ["/A", "/B"], ["/A", "/B", "/A"]


@pytest.mark.parametrize(
    ("kind", "output", "inputs", "result"),
    [
        ("GetParentPath", "parentPath", {"path": of("token", "/World/Cube")}, "/World"),
        ("GetParentPath", "parentPath", {"path": of("token", "/World/Cube.size")}, "/World/Cube"),
        ("GetParentPath", "parentPath", {"path": of("token[]", ["/World", "/A/B/C"])}, ["/", "/A/B"]),
        ("AppendPath", "path", {"path": of("token", "/World"), "suffix": "Cube.size"}, "/World/Cube.size"),
        ("AppendPath", "path", {"path": of("token[]", AB), "suffix": "C/D"}, ["/A/C/D", "/B/C/D"]),
        ("AppendPath", "path", {"path": of("token", "/World")}, "/World"),
        ("GetRelativePath", "relativePath", {"anchor": "/World", "path": of("token", "/World/A/B")}, "A/B"),
        (
            "GetRelativePath",
            "relativePath",
            {"anchor": "/World", "path": of("token[]", ["/World", "/X"])},
            [".", "../X"],
        ),
        ("GetParentPrims", "parentPrims", {"prims": ["/World/Cube", "/World"]}, ["/World", "/"]),
        ("AppendTargets", "targets", {"input0": AB, "input1": ["/B", "/C"]}, ["/A", "/B", "/C"]),
        (
            "AppendTargets",
            "targets",
            {"input0": AB, "input1": ["/B"], "input2": ["/C"], "allowDuplicates": True},
            ["/A", "/B", "/B", "/C"],
        ),
        ("AppendTargetPaths", "targets", {"rootTargets": AB, "input0": of("token", "C/D")}, ["/A/C/D", "/B/C/D"]),
        (
            "AppendTargetPaths",
            "targets",
            {"rootTargets": AB, "input0": of("token[]", ["C", "D"]), "input1": of("token", "E")},
            ["/A/C/E", "/B/D/E"],
        ),
        ("AppendTargetPaths", "targets", {"input0": of("token", "World")}, ["/World"]),
        ("CompareTargets", "result", {"a": AB, "b": AB}, True),
        ("CompareTargets", "result", {"a": AB, "b": ["/B", "/A"], "operation": "!="}, True),
        ("FindTarget", "index", {"targets": AB, "searchTarget": "/B"}, 1),
        ("FindTarget", "index", {"targets": AB, "searchTarget": "/C"}, -1),
        ("GetTargets", "targets", {"targets": ABA}, ["/A"]),
        ("GetTargets", "targets", {"targets": ABA, "index": -2, "count": -1}, ["/B", "/A"]),
        ("GetTargets", "targets", {"targets": ABA, "index": 2, "count": 9}, ["/A"]),
        ("InsertTargets", "targets", {"targets": AB, "insertTargets": ["/C"], "index": 1}, ["/A", "/C", "/B"]),
        ("InsertTargets", "targets", {"targets": AB, "insertTargets": ["/C"], "index": 99}, ["/A", "/B", "/C"]),
        ("ReplaceTargets", "targets", {"targets": ABA, "replaceTargets": "/A", "setTargets": "/C"}, ["/C", "/B", "/C"]),
        ("ReplaceTargets", "targets", {"targets": ABA, "replaceTargets": AB, "setTargets": "/C"}, ["/C"] * 3),
        ("ReplaceTargets", "targets", {"targets": ABA, "replaceTargets": "/A"}, ["/B"]),
        ("SetTarget", "targets", {"targets": AB, "setTarget": "/C", "index": -1}, ["/A", "/C"]),
        ("SelectTargetIf", "result", {"condition": of("bool", True), "ifTrue": AB, "ifFalse": ["/C"]}, AB),
        ("SelectTargetIf", "result", {"condition": of("bool", False), "ifTrue": AB, "ifFalse": ["/C"]}, ["/C"]),
        (
            "SelectTargetIf",
            "result",
            {"condition": of("bool[]", [True, False]), "ifTrue": AB, "ifFalse": ["/C", "/D"]},
            ["/A", "/D"],
        ),
        ("GraphTarget", "primPath", {}, "/test"),
        ("GetGraphTargetPrim", "prim", {}, ["/test"]),
    ],
)
def test_paths_and_targets_are_made_of_others(kind, output, inputs, result):
    assert run_node(kind, inputs=inputs).value(output) == result


def test_targets_are_compared_one_by_one():
    trace = run_node("CompareTargets", inputs={"a": AB, "b": ["/A"], "compareEach": True})
    assert trace.value("result").tolist() == [True, False]
    assert trace.node.types["outputs:result"].name == "bool[]"


@pytest.mark.parametrize(
    ("kind", "inputs", "message"),
    [
        ("GetParentPath", {"path": of("token", "World")}, "is not an absolute path"),
        ("AppendPath", {"path": of("token", "/World"), "suffix": "/Cube"}, "does not begin with /"),
        ("AppendTargetPaths", {"rootTargets": AB, "input0": of("token[]", ["C", "D", "E"])}, "2 and 3 paths"),
        ("AppendTargetPaths", {"rootTargets": AB, "input0": of("token", "/C")}, "is not a relative path"),
        ("CompareTargets", {"a": AB, "b": ABA, "compareEach": True}, "must be as many"),
        ("FindTarget", {"targets": AB, "searchTarget": AB}, "names 2 prims; give it one"),
        ("GetTargets", {"targets": AB, "index": 2}, "the target names 2 prims"),
        ("SetTarget", {"targets": AB, "setTarget": "/C", "index": 2}, "the target names 2 prims"),
        ("SetTarget", {"targets": AB, "setTarget": AB}, "names 2 prims; give it one"),
        ("SelectTargetIf", {"condition": of("bool[]", [True]), "ifTrue": AB, "ifFalse": AB}, "must be as many"),
        ("ReplaceTargets", {"targets": AB, "replaceTargets": AB, "setTargets": ABA}, "2 prims cannot be replaced by 3"),
    ],
)
def test_what_cannot_be_put_together_fails(kind, inputs, message):
    with pytest.raises(ComputeError, match=message):
        run_node(kind, inputs=inputs)
