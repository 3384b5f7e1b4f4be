import json

import pytest

from graph import UNSET, UserError
from graph.ogn import read_ogn


def problems(text):
    with pytest.raises(UserError) as caught:
        read_ogn(text, name="OgnX.ogn", extension="acme")
    return [str(one) for one in caught.value.problems]


def declared(**body):
    return json.dumps({"X": {"description": "x", **body}})


def test_a_type_name_with_a_dot_is_a_whole_id():
    assert read_ogn(declared(), name="x", extension="acme").id == "acme.X"
    assert read_ogn('{"other.X": {"description": "x"}}', name="x", extension="acme").id == "other.X"


def test_everything_that_omnigraph_allows_is_read():
    node = read_ogn(
        declared(
            version=3,
            language="cpp",
            uiName="X",
            icon="x.svg",
            categories=["math"],
            metadata={"hidden": "true"},
            scheduling=["threadsafe", "usd-read"],
            memoryType="any",
            cudaPointers="cpu",
            singleton=True,
            exclude=["tests"],
            tokens={"go": "Go!"},
            state={"count": {"type": "int", "description": "x", "default": -1}},
            inputs={
                "a:b": {"type": "pointd[3][]", "description": ["a", "b"], "uiName": "A", "memoryType": "cuda"},
                "open": {"type": ["double", "numeric_arrays"], "description": "x", "optional": True},
                "fixed": {"type": "bool", "description": "x", "default": True, "metadata": {"literalOnly": "1"}},
                "old": {"type": "any", "description": "x", "deprecated": "use a:b"},
            },
            tests=[{"inputs:fixed": True}],
        ),
        name="x",
    )
    assert (node.id, node.version, node.volatile, node.tokens) == ("X", 3, True, {"go": "Go!"})
    assert node.state["count"].default == -1
    assert node.inputs["a:b"].doc == "a\nb"
    assert node.inputs["open"].type == ("double", "numeric_arrays")
    assert node.inputs["open"].optional
    assert node.inputs["fixed"].literal_only
    assert node.inputs["old"].deprecated == "use a:b"
    assert not node.is_event


@pytest.mark.parametrize(
    ("usd", "ogn"), [("float3", "float[3]"), ("double2[]", "double[2][]"), ("int4", "int[4]"), ("half3", "half[3]")]
)
def test_usds_names_of_plain_tuples_are_understood(usd, ogn):
    default = [] if usd.endswith("[]") else [0] * int(usd[-1])
    one = {"type": usd, "description": "x", "default": default}
    node = read_ogn(declared(inputs={"a": one}), name="x", extension="acme")
    assert str(node.inputs["a"].parsed) == ogn


@pytest.mark.parametrize("idle", [0, False, None])
def test_an_execution_input_that_is_not_triggered_may_say_so(idle):
    one = {"type": "execution", "description": "x", "default": idle}
    assert read_ogn(declared(inputs={"go": one}), name="x", extension="acme").inputs["go"].default is UNSET


def test_all_problems_of_a_file_come_at_once_in_its_order():
    text = """{
  "X": {
    "version": 0,
    "descriptin": "x",
    "inputs": {
      "a b": {"type": "int", "description": "x"},
      "c": {"type": "doubel", "description": "x"},
      "d": {"type": "int", "description": "x", "default": "no"},
      "e": {"description": "x"},
      "f": {"type": "int"},
      "g": 5
    },
    "outputs": []
  }
}"""
    assert problems(text) == [
        "OgnX.ogn:2:3: description: give it a text, or a list of lines",
        "OgnX.ogn:3:16: version: expected a whole number from 1, found number 0",
        'OgnX.ogn:4:5: unknown key "descriptin"; did you mean "description"?',
        'OgnX.ogn:6:7: "a b" is not an attribute name; use letters, digits, underscores and ":"',
        'OgnX.ogn:7:21: inputs.c: no attribute type "doubel"; did you mean "double"?',
        "OgnX.ogn:8:59: inputs.d: default: expected a whole number (int), got 'no'",
        "OgnX.ogn:9:7: inputs.e: give it a type, such as double, or a list of types",
        "OgnX.ogn:10:7: description: give it a text, or a list of lines",
        "OgnX.ogn:11:12: inputs.g: expected a mapping, found number 5",
        "OgnX.ogn:13:16: outputs: expected a mapping, found a list",
    ]


@pytest.mark.parametrize("text", ["[]", "{}", "5", '{"$comment": 1}', '{"A": {}, "B": {}}'])
def test_a_file_declares_one_type(text):
    assert problems(text) == ["OgnX.ogn:1:1: an .ogn file is a mapping with one key, the name of its node type"]


@pytest.mark.parametrize(
    "body",
    [
        {"tokens": 5},
        {"tokens": [[]]},
        {"scheduling": 5},
        {"inputs": {"a": {"type": [], "description": "x"}}},
        {"inputs": {"a": {"type": "int", "description": "x", "allowedTokens": 5}}},
        {"inputs": {"a": {"type": "int", "description": "x", "minimum": "no"}}},
        {"inputs": {"a": {"type": "int", "description": "x", "deprecated": 5}}},
        {"description": []},
        {"version": "1"},
    ],
)
def test_values_of_the_wrong_kind_are_problems_not_tracebacks(body):
    assert problems(declared(**body))
