"""Whatever the text: a specification or a UserError, in little time, and never anything else."""

import json
import resource

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from graph.base.errors import UserError
from graph.files import loads
from tests.support.costs import within

NAMES = """tickgraph scene usd prims /World/A clock physics_hz loop_hz graphs /G nodes n type inputs connections record
    mcap settings fidelity variables value duration config x.json ../x 1 0 -1 1/240 nan 1e999 null on <<"""
WORDS = st.sampled_from([*NAMES.split(), "a.x -> b.y", "a.x -> [b.y, c.z]"])
SIGNS = "{ } [ ] | > ' \" ! @ ` ~ \\ \\U \\x &a *a !!x %YAML --- ..."
BREAKS = ["\n", "\r\n", "\t", " ", "  ", "\n  ", ": ", "- ", ", ", "? ", "# ", "\x85", "\u2028", "\ufeff", "\U0001f600"]
SYNTAX = st.sampled_from([*SIGNS.split(), *BREAKS])
PIECES = st.lists(WORDS | SYNTAX | st.text(max_size=6), max_size=40).map("".join)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | WORDS | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS | st.text(max_size=4), inner, max_size=6),
    max_leaves=30,
)
calm = settings(max_examples=300, deadline=2000, suppress_health_check=[HealthCheck.too_slow])


def read(text, name):
    problems = ()
    try:
        loads(text, name=name)
    except UserError as error:
        problems = error.problems or (None,)
    for problem in problems:
        assert "\n" not in str(problem)
        assert not problem.message.endswith(".")


@calm
@given(text=PIECES)
@example("tickgraph: 1\ngraphs: {/G: {nodes: &a {a: *a}}}")
@example('tickgraph: 1\nx: "\\UFFFFFFFF"')
@example("tickgraph: 1\nduration: 1e99999999999999999999")
@example("tickgraph: 1\nduration: 0o777777777777777777777777777777777777")
@example("? ")
@example("!<")
@example("%TAG")
@example("tickgraph: 1\n\ud800: 1")
def test_yaml_text(text):
    read(text, "a.yaml")


@calm
@given(data=st.binary(max_size=200) | PIECES.map(lambda text: text.encode("utf-8", "surrogatepass")))
def test_bytes(data):
    read(data, "a.yaml")
    read(data, "a.json")


@calm
@given(text=PIECES)
def test_json_text(text):
    read(text, "a.json")


@calm
@given(value=VALUES, graphs=VALUES, scene=VALUES, clock=VALUES)
def test_any_tree(value, graphs, scene, clock):
    tree = {"tickgraph": 1, "graphs": graphs, "scene": scene, "clock": clock, "settings": value, "record": value}
    read(json.dumps(tree), "a.json")
    if isinstance(value, dict):
        read(json.dumps({"tickgraph": 1, "graphs": {"/G": value}}), "a.json")
        read(json.dumps({"tickgraph": 1, "graphs": {"/G": {"nodes": value}}}), "a.json")
        read(json.dumps({"tickgraph": 1, "graphs": {"/G": {"nodes": {"n": value}}}}), "a.json")


SIZE = 64_000


def bombs():
    alias_levels = "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 100)
    )
    wide = "x: &x [1]\ny: [" + "*x, " * (SIZE // 4 - 10) + "]"
    return {
        "aliases": alias_levels,
        "many aliases": wide,
        "open brackets": "[" * SIZE,
        "open braces": "{" * SIZE,
        "mixed brackets": "[{" * (SIZE // 2),
        "dashes": "- " * (SIZE // 2),
        "question marks": "? " * (SIZE // 2),
        "colons": "a: " * (SIZE // 3),
        "stairs": "".join(" " * i + "a:\n" for i in range(350)),
        "one long word": "a" * SIZE,
        "one long key": "a" * SIZE + ": 1",
        "long quoted": '"' + "\\x41" * (SIZE // 4) + '"',
        "unclosed quote": 'a: "' + "x\n" * (SIZE // 2),
        "digits": "tickgraph: " + "1" * (SIZE - 20),
        "anchors": "".join(f"- &a{i} x\n" for i in range(SIZE // 12)),
        "tags": "- !<" + "x" * (SIZE - 10) + ">",
        "comments": "#\n" * (SIZE // 2),
        "blank lines": "a: 1" + "\n" * (SIZE - 4),
        "folded": "a: >\n" + " x\n" * (SIZE // 3 - 5),
        "folded blank": "a: >\n" + " x\n\n" * (SIZE // 4 - 5),
        "plain lines": "a: x\n" + " x\n" * (SIZE // 3 - 5),
        "dots": "tickgraph: 1\ngraphs: {/G: {connections: ['" + "a." * (SIZE // 2 - 40) + " - > b']}}",
        "arrows": "tickgraph: 1\ngraphs: {/G: {connections: ['" + "->" * (SIZE // 2 - 40) + "']}}",
        "targets": "tickgraph: 1\ngraphs: {/G: {connections: ['a.x -> [" + "b.y," * (SIZE // 4 - 40) + "c']}}",
        "spaces": "tickgraph: 1\nclock: {loop_hz: '" + " " * (SIZE - 50) + "x'}",
        "same keys": "a: 1\n" * (SIZE // 5),
        "bad keys": "tickgraph: 1\n" + "".join(f"k{i}: 1\n" for i in range(SIZE // 9)),
        "near names": "tickgraph: 1\n" + "".join(f"graph{i}: 1\n" for i in range(SIZE // 13)),
        "bad nodes": "tickgraph: 1\ngraphs: {/G: {nodes: {" + "".join(f"n{i}: 1, " for i in range(SIZE // 11)) + "}}}",
        "misspelt": "tickgraph: 1\ngraphs: {/G: {nodes: {"
        + "".join(f"n{i}: {{typ: X}}, " for i in range(SIZE // 19))
        + "}}}",
        "unknown keys of a node": "tickgraph: 1\ngraphs: {/G: {nodes: {n: {"
        + "".join(f"k{i}: 1, " for i in range(SIZE // 11))
        + "}}}}",
        "lost nodes": "tickgraph: 1\ngraphs: {/G: {nodes: {"
        + "".join(f"n{i}: 1, " for i in range(2000))
        + "}, connections: ["
        + "".join(f"n{i}.x -> n.y, " for i in range(2000))
        + "]}}",
        "directives": "%X\n" * (SIZE // 3),
        "documents": "---\n" * (SIZE // 4),
        "carriage returns": "\r" * SIZE,
    }


@pytest.mark.parametrize("kind", bombs())
@pytest.mark.parametrize("name", ["a.yaml", "a.json"])
def test_64_kilobytes_made_to_hurt_are_read_in_two_seconds_and_little_memory(kind, name):
    text = bombs()[kind]
    assert len(text) <= SIZE + 10
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with within(2):
        read(text, name)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 500_000
