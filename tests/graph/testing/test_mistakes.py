"""Mistakes in test files: each is reported with file, line, column and what to do, and all of them at once."""

import pytest

from graph.testing.cases import parse_cases

ONE = "cases:\n  it: {graph: small.yaml, updates: 5, %s}\n"
NODE = "cases:\n  it: {node: Countdown, updates: 5, %s}\n"

# What is written (below the first line), and the report; {} stands for `case "it": `.
MISTAKES = {
    "no cases": ("node: Countdown\n", '1:1: "cases" is missing; add it'),
    "empty cases": ("cases: {}\n", "2:8: cases is empty; give it a value"),
    "cases in a list": ("cases: [a]\n", "2:8: cases must be a mapping, found a list"),
    "unknown key": ("casse: {}\ncases: {a: {node: Once}}\n", '2:1: unknown key "casse"; did you mean "cases"?'),
    "unknown key of a case": (NODE % "expct: {}", '3:37: {}unknown key "expct"; did you mean "expect"?'),
    "unknown expectation": (
        NODE % "expect: {fire: {}}",
        '3:46: {}unknown key "fire" in expect; did you mean "fired"?',
    ),
    "unknown key of an error": (
        NODE % "expect: {error: {mesage: a}}",
        '3:54: {}unknown key "mesage" in expect.error; did you mean "message"?',
    ),
    "misspelt warning": (
        NODE % "expect: {warnings: [{cod: a}]}",
        '3:58: {}unknown key "cod" in a warning; did you mean "code"?',
    ),
    "a case that is not a mapping": ("cases: {it: 5}\n", "2:13: {}the case must be a mapping, found number 5"),
    "no updates": (NODE.replace("5", "-1") % "world: false", "3:34: {}updates must be 0 or more, found number -1"),
    "too many updates": (
        NODE.replace("5", "5000000") % "world: false",
        "3:34: {}updates must be at most 1,000,000, found number 5000000",
    ),
    "updates in words": (
        NODE.replace("5", "ten") % "seed: 1",
        '3:34: {}updates must be a whole number, found text "ten"',
    ),
    "a world in words": (NODE % "world: maybe", '3:44: {}world must be true or false, found text "maybe"'),
    "a pulse that is not a list": (
        NODE % "pulses: {execIn: 3}",
        "3:54: {}pulses execIn must be a list of updates such as [0, 3, 6..9], found number 3",
    ),
    "a pulse that is not an update": (
        NODE % "pulses: {execIn: [0, 2.5]}",
        "3:54: {}pulses execIn: number 2.5 is not an update; write its index, 0 or more, or a range such as 0..11",
    ),
    "a range that runs backwards": (
        NODE % "pulses: {execIn: [4..2]}",
        '3:54: {}pulses execIn: "4..2" is not an update; ',
    ),
    "a million updates twice": (
        NODE % "pulses: {execIn: [0..999999, 0..999999]}",
        "3:54: {}pulses execIn names more than 1,000,000 updates; write fewer",
    ),
    "a pulse after the end": (
        NODE % "pulses: {execIn: [0, 5]}",
        "3:46: {}pulses: execIn is to be triggered in update 5, but the case runs 5 updates, 0 to 4; give it more",
    ),
    "a change after the end": (
        NODE % "changes: {7: {duration: 1}}",
        "3:47: {}changes: update 7 never comes: the case runs 5 updates, 0 to 4; give it more",
    ),
    "a change at no update": (NODE % "changes: {soon: {}}", '3:46: {}changes: "soon" is not an update; '),
    "a change of nothing": (
        NODE % "changes: {1: 5}",
        "3:46: {}changes: update 1: must be a mapping from attributes to values, found number 5",
    ),
    "a tolerance that no double holds": (
        NODE % f"tolerance: 1{'0' * 320}",
        "3:48: a number of 321 digits is larger than any double",
    ),
    "a tolerance below zero": (
        NODE % "tolerance: -1",
        "3:48: {}tolerance must be a number of 0 or more, or a mapping from attributes to such, found number -1",
    ),
    "firings in words": (
        NODE % "expect: {fired: {tick: often}}",
        "3:60: {}expect.fired tick must be a count or a list of updates such as [0, 3, 6..9], "
        'found text "often"',
    ),
    "values in one": (
        NODE % "expect: {values: {alpha: 3}}",
        "3:62: {}expect.values alpha must be a list with the value after each update, or a mapping from updates to "
        "values, found number 3",
    ),
    "values at no update": (
        NODE % "expect: {values: {alpha: {last: 3}}}",
        '{}expect.values alpha: "last" is not an update',
    ),
    "an exit code": (NODE % "expect: {error: {exit: 3}}", "3:60: {}expect.error.exit must be 1 or 2, found number 3"),
    "an empty error": (NODE % "expect: {error: []}", "{}expect.error.message must be a piece of the error's text"),
    "graph and node": (ONE % "node: Countdown", "3:39: {}give graph or node, not both"),
    "a missing graph file": (
        ONE.replace("small", "smal") % "seed: 1",
        '3:15: {}graph: there is no file "smal.yaml" (relative to the graph file); did you mean "small.yaml"?',
    ),
    "a graph file elsewhere": (
        ONE.replace("small", "../small") % "seed: 1",
        '3:15: {}graph: "../small.yaml" is outside',
    ),
    "a scene beside a graph file": (ONE % "scene: {}", "3:39: {}scene: the graph file has its own; leave it out"),
    "connect with a graph": (
        ONE % "connect: {a: int}",
        "3:39: {}connect: only the test of a node takes it; leave it out",
    ),
    "an unknown node type": (
        NODE.replace("Countdown", "Countdwn") % "seed: 1",
        '3:8: {}no node type "Countdwn"; did you mean "Countdown"?',
    ),
    "an unknown attribute": (
        NODE % "inputs: {duratin: 1}",
        '3:46: {}inputs: omni.graph.action.Countdown has no attribute "duratin"; did you mean "duration"?',
    ),
    "an execution input set": (
        NODE % "inputs: {execIn: 1}",
        '3:46: {}inputs: "execIn" is an execution attribute; trigger it by pulses',
    ),
    "an output set": (
        NODE % "inputs: {alpha: 1}",
        '{}inputs: "alpha" is an output; only inputs and state can be set',
    ),
    "a data input triggered": (
        NODE % "pulses: {period: [0]}",
        '3:46: {}pulses: "period" is not an execution input; set it by inputs',
    ),
    "a firing of data": (
        NODE % "expect: {fired: {alpha: []}}",
        '3:54: {}expect.fired: "alpha" is not an execution output; look at its values',
    ),
    "a value of execution": (
        NODE % "expect: {outputs: {tick: 1}}",
        '3:56: {}expect.outputs: "tick" is an execution attribute; look at when it fired',
    ),
    "computes of another": (
        NODE % "expect: {computes: {countdown: 1}}",
        '{}expect.computes: there is no node "countdown"; the node under test is called "node"',
    ),
    "an unknown node": (
        ONE % "expect: {fired: {wat.tick: []}}",
        '3:56: {}expect.fired: there is no node "wat"; did you mean "wait"?',
    ),
    "an attribute without a node": (
        ONE % "expect: {outputs: {alpha: 1}}",
        '{}expect.outputs: "alpha" names no attribute; write node.attribute',
    ),
    "a mistake in a graph written out": (
        "cases:\n  it:\n    graph:\n      nods: {}\n",
        '5:7: {}unknown key "nods" in graph /Graph; did you mean "nodes"?',
    ),
    "a connection in a graph written out": (
        "cases:\n  it:\n    graph:\n      nodes: {a: Once}\n      connections: [a.once - b.execIn]\n",
        "6:21: {}",
    ),
    "a mistake in a scene": (
        "cases:\n  it: {node: Once, scene: {usd: there.usda}}\n",
        '3:33: {}scene.usd: there is no file "there.usda"',
    ),
    "a clock": (
        "cases: {it: {node: Once, clock: {loop_hz: fast}}}\n",
        "2:43: {}clock.loop_hz must be a rate in Hz such as 60, 29.97 or 30000/1001, found text \"fast\"",
    ),
    "a setting": ("cases: {it: {node: Once, settings: {a: 1}}}\n", '{}settings: "a" is not a setting; '),
    "a variable": (
        "cases: {it: {node: Once, variables: {gain: {typ: int}}}}\n",
        '2:45: {}unknown key "typ" in variable "gain"; did you mean "type"?',
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_reported_with_its_place(mistake, run_tests, graph_file):
    text, message = MISTAKES[mistake]
    problems = run_tests(text).problems
    assert len(problems) == 1, problems
    assert message.replace("{}", 'case "it": ', 1) in problems[0]
    assert problems[0].startswith("small.test.yaml:")


def test_a_case_of_nothing_is_reported(run_tests):
    [problem] = run_tests("cases: {it: {}}\n").problems
    assert problem == (
        'small.test.yaml:2:9: case "it": names neither graph nor node, and no graph file of this name stands beside; '
        'add "graph" or "node"'
    )


def test_all_mistakes_are_reported_at_once(run_tests, graph_file):
    problems = run_tests(
        """\
        cases:
          one: {node: Countdown, pulses: {execIn: 3}, expct: {}}
          two: {node: Countdwn}
          three: {graph: small.yaml, expect: {fired: {wait.tack: []}}}
        """
    ).problems
    assert [problem.split(": ")[1:3] for problem in problems] == [
        ['case "one"', "pulses execIn must be a list of updates such as [0, 3, 6..9], found number 3"],
        ['case "one"', 'unknown key "expct"; did you mean "expect"?'],
        ['case "two"', 'no node type "Countdwn"; did you mean "Countdown"?'],
        ['case "three"', "expect.fired"],
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b" ", 'a.test.yaml:1:1: the file is empty; a test file is a mapping that starts with "tickgraph_tests: 1'),
        (b"[1]", 'a test file is a mapping that starts with "tickgraph_tests: 1", found a list'),
        (b"services: {}", 'there is no "tickgraph_tests" key'),
        (b"cases: {a: {node: Once}}", 'there is no "tickgraph_tests" key; a test file starts with "tickgraph_'),
        (b"tickgraph_tests: 2\ncases: {a: {node: Once}}", "tickgraph_tests must be 1, the version of the format"),
        (b"tickgraph_tests: 1\ncases: {a: [}", "2:13: this } closes the [ of line 2; write ]"),
        (b"tickgraph_tests: 1\ncases: {a: {}, a: {}}", 'key "a" is repeated'),
        (b"\xff\xfea", "UTF-16"),
    ],
)  # fmt: skip
def test_what_is_not_a_test_file_is_reported(text, message, tmp_path):
    file = parse_cases(text, "a.test.yaml", tmp_path / "a.test.yaml")
    assert any(message in str(problem) for problem in file.problems), file.problems


def test_a_missing_file_is_reported(tmp_path):
    from graph.testing.cases import read_cases

    [problem] = read_cases(tmp_path / "no.test.yaml").problems
    assert str(problem).endswith("no.test.yaml cannot be read: No such file or directory")


def test_tests_may_be_json(tmp_path):
    text = b'{"tickgraph_tests": 1, "cases": {"a": {"node": "Countdown", "expect": {"fird": {}}}}}'
    [problem] = parse_cases(text, "a.test.json", tmp_path / "a.test.json").problems
    assert str(problem) == 'a.test.json:1:72: case "a": unknown key "fird" in expect; did you mean "fired"?'
