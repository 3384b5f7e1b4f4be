"""Test files from strangers: whatever stands in them, reading ends soon, with problems and without a traceback."""

import io
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from graph.testing.cases import parse_cases
from graph.testing.checking import check_cases

SEED = """\
tickgraph_tests: 1
node: Countdown
inputs: {duration: 2, period: [1]}
pulses: {execIn: [0, 2..3]}
changes: {1: {duration: 3}}
tolerance: {alpha: 1e-3}
clock: {loop_hz: 30000/1001}
cases:
  one: {updates: 4, expect: {fired: {finished: [2], tick: 3}, outputs: {alpha: .nan}, values: {alpha: {0..3: 1}}}}
  two: {graph: {nodes: {a: Once}, connections: [a.once -> a.execIn]}, scene: {prims: {/A: {type: Cube}}}}
  three: {expect: {warnings: [a, {code: b}], error: {message: [a], exit: 2}, computes: {node: 1}, frames: {/A: []}}}
"""
WORDS = """{ } [ ] *a ~ 0..999999 1e999 -1 .. cases graph node expect values null ' # ../ <<"""
PIECES = st.sampled_from(
    [
        *WORDS.split(),
        *(": ", "\n", "- ", "&a ", "!!int ", "\x00", "\U0001f4a3", '"', "9" * 500, "\t"),
    ]
)
KEYS = """graph node scene clock world updates seed inputs changes pulses playing stops settings fidelity connect
    variables tolerance expect"""


def read(text, tmp_path):
    """Reads and checks; every problem is one line with the file's name."""
    file = parse_cases(text, "a.test.yaml", tmp_path / "a.test.yaml")
    problems = [*file.problems, *check_cases(file.cases)]
    assert all(str(one).startswith("a.test.yaml") and "\n" not in str(one) for one in problems)
    return problems


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, len(SEED)), st.integers(0, 12), PIECES), min_size=1, max_size=4))
def test_changed_files_are_read_without_surprise(tmp_path, edits):
    text = SEED
    for at, length, piece in edits:
        text = text[:at] + piece + text[at + length :]
    read(text.encode("utf-8", "surrogatepass"), tmp_path)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
        max_leaves=12,
    ),
    st.sampled_from(KEYS.split()),
)
def test_any_value_of_any_key_is_taken_or_told(tmp_path, value, key):
    import json

    case = {"node": "Countdown", key: value} if key != "graph" else {key: value}
    text = json.dumps({"tickgraph_tests": 1, "cases": {"it": case}}, allow_nan=False) if _finite(value) else ""
    file = parse_cases(text.encode(), "a.test.json", tmp_path / "a.test.json")
    assert all(str(one).startswith("a.test.json") and "\n" not in str(one) for one in file.problems)
    assert file.problems or [one.name for one in file.cases] == ["it"]


def _finite(value):
    import json

    try:
        json.dumps(value, allow_nan=False)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize(
    "text",
    [
        "pulses:\n" + "".join(f"  a{n}: [0..999999]\n" for n in range(1000)),
        "expect: {fired: {a: [" + "0..999, " * 2000 + "]}}\n",
        "expect: {values: {a: " + "[" * 99 + "]" * 99 + "}}\n",
        "inputs: &a {x: [1, 1, 1, 1, 1, 1, 1, 1, 1]}\nchanges: {" + ", ".join(f"{n}: *a" for n in range(1000)) + "}\n",
        "tolerance: {" + ", ".join(f"a{n}: 1" for n in range(1000)) + "}\n",
    ],
    ids=["millions of pulses", "millions of firings", "deep", "aliases", "many wrong names"],
)
def test_short_files_that_stand_for_much(text, tmp_path):
    """Reading costs a few times what the YAML parser needs for the text alone (least of three, shared machine)."""
    body = "".join(f"    {line}\n" for line in text.splitlines())
    whole = f"tickgraph_tests: 1\ncases:\n  it:\n    node: Countdown\n{body}".encode()
    ours = min(cost(lambda: read(whole, tmp_path)) for _ in range(3))
    parser = min(cost(lambda: list(YAML(pure=True).parse(io.BytesIO(whole)))) for _ in range(3))
    assert ours < 10 * parser + 0.05


def cost(what):
    started = time.process_time()
    what()
    return time.process_time() - started
