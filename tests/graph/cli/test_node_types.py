import json
import sys

import pytest

import nodes
from graph import Attribute
from graph.cli.describe import node_type_as_dict
from graph.cli.main import main
from graph.node import registry as registry_module
from graph.node.declaration import NodeType
from graph.node.decorator import declare, node_type


@pytest.fixture
def types(monkeypatch):
    """A registry with two types, in the place of the default one."""
    registry = registry_module.Registry()
    monkeypatch.setattr(registry_module, "DEFAULT", registry)

    @node_type(
        "acme.flow.Wait",
        version=3,
        registry=registry,
        inputs={
            "execIn": Attribute("execution", "starts"),
            "limit": Attribute("double", "how long", default=2.5, unit="s", minimum=0.0),
            "mode": Attribute("token", "which way", default="up", allowed_tokens=("up", "down")),
            "gains": Attribute("double[3]", "one for each axis", default=(1.0, 2.0, float("inf"))),
            "old": Attribute("int", "no longer used", optional=True, deprecated="use limit"),
        },
        outputs={"done": Attribute("execution", "ends")},
        state={"count": Attribute("int", "so far", default=-1)},
    )
    def wait(db):
        """Waits.

        For as long as told.
        """

    declare(
        "acme.math.Sum",
        "Adds things.",
        registry=registry,
        inputs={"a": Attribute(("numerics", "token"), "a thing")},
    )
    return registry


def test_types_are_listed_one_a_line_with_version_and_purpose(types, graph):
    rows = [line.split("\t") for line in graph("nodes").out.splitlines()]
    assert [row[:3] for row in rows] == [["acme.flow.Wait", "3", "Waits."], ["acme.math.Sum", "1", "Adds things."]]


def test_types_that_are_not_ours_are_listed_with_their_origin(types, graph):
    assert graph("nodes", "Sum").out.split("\t")[3].rpartition(":")[0].endswith("test_node_types")


def test_our_types_are_listed_without_an_origin(graph):
    assert graph("nodes", "Countdown").out.count("\t") == 2


def test_a_terminal_gets_a_table_with_headings(types, capsys, monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "dumb")
    assert main(["nodes"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == ["TYPE", "VERSION", "WHAT", "IT", "DOES", "FROM"]
    assert lines[1][:3] == ["acme.flow.Wait", "3", "Waits."]


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("wait", ["acme.flow.Wait"]),
        ("acme", ["acme.flow.Wait", "acme.math.Sum"]),
        ("W*", ["acme.flow.Wait"]),
        ("acme.*.s?m", ["acme.math.Sum"]),
        ("*.math.*", ["acme.math.Sum"]),
    ],
)
def test_a_pattern_is_part_of_the_id_or_has_wildcards(types, graph, pattern, found):
    assert [line.split("\t")[0] for line in graph("nodes", pattern).out.splitlines()] == found


def test_a_pattern_that_fits_nothing_is_a_mistake(types, graph):
    result = graph("nodes", "zzz")
    assert result.code == 2
    assert result.err == 'graph: no node type fits "zzz"; graph nodes lists them all\n'


def test_a_misspelt_word_of_names_is_suggested(graph):
    assert graph("nodes", "lidr").err == 'graph: no node type fits "lidr"; did you mean "Lidar"?\n'


def test_json_has_version_inputs_and_outputs_by_name(types, graph):
    listed = json.loads(graph("nodes", "--json").out)
    assert list(listed) == ["acme.flow.Wait", "acme.math.Sum"]
    wait = listed["acme.flow.Wait"]
    assert wait["version"] == 3
    assert wait["doc"].startswith("Waits.\n")
    assert {name: (one["type"], one["default"]) for name, one in wait["inputs"].items()} == {
        "execIn": ("execution", None),
        "limit": ("double", 2.5),
        "mode": ("token", "up"),
        "gains": ("double[3]", [1.0, 2.0, "inf"]),
        "old": ("int", None),
    }
    assert wait["inputs"]["limit"]["unit"] == "s"
    assert wait["inputs"]["mode"]["allowed_tokens"] == ["up", "down"]
    assert wait["outputs"] == {"done": {"type": "execution", "default": None, "doc": "ends"}}
    assert wait["state"]["count"]["default"] == -1
    assert listed["acme.math.Sum"]["inputs"]["a"]["type"] == ["numerics", "token"]
    assert json.loads(graph("node", "Wait", "--json").out) == {"acme.flow.Wait": wait}


def test_a_type_is_described_to_a_person(types, graph):
    text = graph("node", "Wait").out
    assert text.startswith("acme.flow.Wait (version 3)\n\n  Waits.\n\n  For as long as told.\n\ninputs:\n")
    assert "  limit   double     how long (s; default 2.5; at least 0.0)\n" in text
    assert '  mode    token      which way (default "up"; one of up, down)\n' in text
    assert "  old     int        no longer used (optional; deprecated: use limit)\n" in text
    assert "\noutputs:\n  done  execution  ends\n" in text
    assert "\nstate:\n  count  int  so far (default -1)\n" in text


def test_an_unknown_type_gets_a_suggestion(types, graph):
    result = graph("node", "Wiat")
    assert result.code == 2
    assert result.err == 'graph: no node type "Wiat"; did you mean "Wait"?\n'


def test_dynamic_attributes_are_distinguished():
    one = NodeType("a.B", dynamic_inputs={"input{n}": Attribute("any", "more")})
    assert node_type_as_dict(one)["dynamic"] == {
        "inputs": {"input{n}": {"type": "any", "default": None, "doc": "more"}},
        "outputs": {},
    }


def test_the_shipped_types_are_listed(graph):
    listed = json.loads(graph("nodes", "--json").out)
    countdown = listed["omni.graph.action.Countdown"]
    assert countdown["inputs"]["duration"]["default"] == 5
    assert countdown["inputs"]["period"]["type"] == "int"
    shipped = [name for names in nodes.TYPES.values() for name in names]  # other tests may have registered theirs
    assert all(listed[name]["doc"] and listed[name]["origin"].startswith("nodes.") for name in shipped)
