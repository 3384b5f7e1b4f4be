"""The `tests` of an `.ogn` file as the tree of a test file: each entry sets values, computes once and checks values.

Values are written as `inputs:a: 1` or as `inputs: {a: 1}`; `state_set` and `state_get` are the state before and after.
An execution input with a value is triggered; if a test sets none of them, the first one is triggered.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.base.errors import Problem
from graph.files.source import Source
from graph.files.tree import Map, Seq

from .case_forms import KEY, VERSION

_GIVEN = {"inputs": "inputs", "state_set": "state"}
_EXPECTED = {"outputs": "outputs", "state_get": "state"}
_IGNORED = ("description", "gpu")


def test_tree(source: Source, root: Map, problems: list[Problem]) -> Map:
    """The tree with a case for each test; an entry that cannot be a test is reported."""
    tree = Map(root.at)
    tree.add(KEY, root.at, VERSION, root.at)
    cases = Map(root.at)
    tree.add("cases", root.at, cases, root.at)
    for name, body in ((one, root[one]) for one in root if not one.startswith("$")):
        tests = body.get("tests") if isinstance(body, Map) else None
        if not isinstance(tests, Seq) or not tests:
            problems.append(source.problem(root.places[name][0], f'"{name}" has no list of tests; add "tests"'))
            continue
        for number, (test, at) in enumerate(zip(tests, tests.item_at, strict=True)):
            if isinstance(test, Map):
                cases.add(f"{name} test {number}", at, _case(source, name, body, test, problems), at)
            else:
                problems.append(source.problem(at, "a test is a mapping such as {inputs:a: 1, outputs:b: 2}"))
    return tree


def _case(source: Source, name: str, body: Map, test: Map, problems: list[Problem]) -> Map:
    case, inputs, pulses, expected, fired = (Map(test.at) for _ in range(5))
    for prefix, attribute, at, value in _values(source, test, problems):
        flow = _is_execution(body, prefix, attribute)
        if prefix in _GIVEN and flow:
            pulses.add(attribute, at, [0] if value else [], at)
        elif prefix in _GIVEN:
            inputs.add(f"{_GIVEN[prefix]}:{attribute}", at, value, at)
        elif flow:
            fired.add(attribute, at, [0] if value else [], at)
        else:
            bare = value["value"] if isinstance(value, Map) and set(value) == {"type", "value"} else value
            expected.add(f"{_EXPECTED[prefix]}:{attribute}", at, bare, at)
    declared = body.get("inputs")
    triggers = [one for one in (declared if isinstance(declared, Map) else ()) if _is_execution(body, "inputs", one)]
    if triggers and not pulses:
        pulses.add(triggers[0], test.at, [0], test.at)
    expect = Map(test.at)
    expect.add("outputs", test.at, expected, test.at)
    expect.add("fired", test.at, fired, test.at)
    for key, value in (("node", name), ("inputs", inputs), ("pulses", pulses), ("expect", expect)):
        case.add(key, test.at, value, test.at)
    return case


def _values(source: Source, test: Map, problems: list[Problem]) -> Iterator[tuple[str, str, int, Any]]:
    """Prefix, attribute, place and value of everything that a test sets or expects."""
    for key, value in test.items():
        at = test.places[key][0]
        prefix, _, attribute = key.partition(":")
        if prefix in _IGNORED or prefix.startswith("$"):
            continue
        if prefix not in (*_GIVEN, *_EXPECTED):
            message = f'"{key}" is nothing that can be tested here; write the test as a *.test.yaml file'
            problems.append(source.problem(at, message))
        elif attribute:
            yield prefix, attribute, at, value
        elif isinstance(value, Map):
            yield from ((prefix, one, value.places[one][0], value[one]) for one in value)


def _is_execution(body: Map, prefix: str, attribute: str) -> bool:
    declared = body.get({"state_set": "state", "state_get": "state"}.get(prefix, prefix))
    one = declared.get(attribute) if isinstance(declared, Map) else None
    return isinstance(one, Map) and one.get("type") == "execution"
