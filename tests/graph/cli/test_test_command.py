"""`graph test`: files and folders, the filter, exit codes, JUnit."""

from xml.etree import ElementTree

import pytest

from tests.support.countdown_tests import PASSES
from tests.support.places import ROOT
from tests.support.without_wing import MISSING_EXAMPLES

FAILS = """\
  it finishes <late> & "quoted":
    expect: {fired: {finished: [3]}, outputs: {alpha: 0.5}}
"""
TESTS = PASSES + FAILS


@pytest.fixture
def tests(folder):
    """a.test.yaml and deep/b.test.yaml, each with one case that passes and one that fails, and other files."""
    (folder / "deep").mkdir()
    for name in ("a.test.yaml", "deep/b.test.yaml"):
        (folder / name).write_text(TESTS)
    (folder / "deep" / "graph.yaml").write_text("tickgraph: 1\n")
    return folder


def test_the_tests_of_the_examples_pass(graph):
    files = [one for one in (ROOT / "graphs").glob("*.test.yaml") if one.name.partition(".")[0] not in MISSING_EXAMPLES]
    result = graph("test", *(files if MISSING_EXAMPLES else [ROOT / "graphs"]))
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines()[-1] == f"{len(result.out.splitlines()) - 1} passed, 0 failed"


def test_expected_against_got_is_reported_with_the_line(graph, tests):
    result = graph("test", "a.test.yaml")
    assert result.code == 1
    out = [line.partition(" (0")[0] for line in result.out.splitlines()]
    assert out == [
        "ok     a.test.yaml: it finishes",
        'FAILED a.test.yaml: it finishes <late> & "quoted"',
        "       a.test.yaml:10:22: fired finished: expected [3], got [2]",
        "       a.test.yaml:10:48: outputs alpha: expected 0.5, got 1.0 (error 0.5, tolerance 1e-09)",
        "1 passed, 1 failed",
    ]


def test_folders_are_searched_to_their_bottom_and_files_taken_once(graph, tests):
    result = graph("test", "-q", ".", "a.test.yaml")
    assert result.out.splitlines()[-1] == "2 passed, 2 failed"


def test_a_filter_takes_cases_by_name_or_file(graph, tests):
    assert graph("test", ".", "-k", "LATE").out.splitlines()[-1] == "0 passed, 2 failed"
    assert graph("test", ".", "-k", "deep/b").out.splitlines()[-1] == "1 passed, 1 failed"
    result = graph("test", ".", "-k", "nowhere")
    assert (result.code, result.out) == (2, "")
    assert result.err == "graph: -k nowhere: no case has that in its name; leave out -k to run all\n"


def test_junit_holds_every_case(graph, tests):
    assert graph("test", ".", "--junit", "out/results.xml").code == 1
    root = ElementTree.parse(tests / "out" / "results.xml").getroot()
    assert (root.tag, root.get("tests"), root.get("failures"), root.get("errors")) == ("testsuites", "4", "2", "0")
    assert [suite.get("name") for suite in root] == ["a.test.yaml", "deep/b.test.yaml"]
    passed, failed = root[0]
    assert (passed.get("name"), passed.get("classname"), len(passed)) == ("it finishes", "a.test.yaml", 0)
    assert failed.get("name") == 'it finishes <late> & "quoted"'
    assert (failed.get("file"), failed.get("line")) == ("a.test.yaml", "9")
    assert failed[0].get("message") == "a.test.yaml:10:22: fired finished: expected [3], got [2]"
    assert len(failed[0].text.splitlines()) == 2
    assert all(float(case.get("time")) >= 0 for case in root.iter("testcase"))


def test_a_mistake_in_one_file_stops_all_before_anything_runs(graph, tests):
    (tests / "bad.test.yaml").write_text("tickgraph_tests: 1\ncases: {it: {node: Countdwn, updtes: 1}}\n")
    result = graph("test", ".", "--junit", "results.xml")
    assert (result.code, result.out) == (2, "")
    assert result.err.splitlines() == [
        'bad.test.yaml:2:14: case "it": no node type "Countdwn"; did you mean "Countdown"?',
        'bad.test.yaml:2:30: case "it": unknown key "updtes"; did you mean "updates"?',
    ]
    assert not (tests / "results.xml").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "graph: nowhere: no such file or folder"),
        (["empty"], "graph: empty: there is no test file (*.test.yaml) in this folder"),
        (["deep/graph.yaml"], "graph: deep/graph.yaml is not a test file; its name ends in .test.yaml"),
        (["a.yaml"], "graph: a.yaml is not a test file; did you mean a.test.yaml?"),
        (["a.test.yaml", "--junit", "."], "graph: --junit . is a folder; name a file in it"),
        (["a.test.yaml", "--junit", "a.yaml/x.xml"], "graph: --junit a.yaml/x.xml: "),
        ([], "graph test: the following arguments are required: FILE; see graph test --help"),
    ],
)
def test_wrong_arguments_are_reported(graph, tests, arguments, message):
    (tests / "empty").mkdir()
    (tests / "a.yaml").write_text("tickgraph: 1\n")
    result = graph("test", *arguments)
    assert result.code == 2
    assert message in result.err
    assert "Traceback" not in result.err


def test_settings_reach_the_apps(graph, folder):
    (folder / "a.test.yaml").write_text(
        "tickgraph_tests: 1\n"
        "cases:\n"
        "  it:\n"
        "    graph: {nodes: {tick: OnPlaybackTick}}\n"
        "    world: true\n"
        "    expect: {warnings: [setting-unknown]}\n"
    )
    assert graph("test", "a.test.yaml").code == 1
    assert graph("test", "a.test.yaml", "--/app/runLoops/main/rateLimitFreqency=30").code == 0


def test_one_broken_case_does_not_stop_the_others(graph, tests, monkeypatch):
    from graph.testing import running

    def broken(*args, **options):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr(running, "run_node", broken)
    result = graph("test", "a.test.yaml")
    assert result.code == 1
    assert result.out.count("internal error: ZeroDivisionError: division by zero") == 2


def test_the_schema_of_test_files_takes_the_examples_and_refuses_mistakes(graph):
    import json

    from ruamel.yaml import YAML

    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(graph("schema", "--tests").out)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)

    def as_json(value):
        if isinstance(value, dict):
            return {str(key): as_json(one) for key, one in value.items()}
        return [as_json(one) for one in value] if isinstance(value, list) else value

    for file in sorted((ROOT / "graphs").glob("*.test.yaml")):
        written = as_json(YAML(typ="safe").load(file.read_text(encoding="utf8")))
        assert [error.message for error in validator.iter_errors(written)] == []
    for wrong in ({"expct": {}}, {"updates": -1}, {"expect": {"fired": {"a": "x"}}}, {"pulses": {"a": ["x"]}}):
        assert not validator.is_valid({"tickgraph_tests": 1, "cases": {"a": {"node": "Once", **wrong}}})
    for right in (
        {"expect": {"error": "a"}},
        {"expect": {"warnings": ["a", {"code": "b"}]}},
        {"graph": "a.yaml"},
        None,
    ):
        assert validator.is_valid({"tickgraph_tests": 1, "cases": {"a": right}})


def test_check_knows_test_files(graph, tests):
    result = graph("check", "a.test.yaml")
    assert (result.code, result.out) == (0, "a.test.yaml: ok, 2 cases\n")
    (tests / "bad.test.yaml").write_text(TESTS.replace("[2]", "often").replace("alpha", "alhpa"))
    result = graph("check", "bad.test.yaml")
    assert (result.code, result.out) == (2, "")
    assert [line.split(": ")[0] for line in result.err.splitlines()] == ["bad.test.yaml:8:32", "bad.test.yaml:10:48"]


@pytest.mark.parametrize("world", ["false", "true"])
def test_scripts_run_only_when_they_are_allowed(graph, folder, world):
    (folder / "a.test.yaml").write_text(
        "tickgraph_tests: 1\n"
        f"world: {world}\n"
        "cases:\n"
        "  node: {node: ScriptNode, inputs: {script: &code 'def compute(db): pass'}, pulses: {execIn: [0]}}\n"
        "  graph: {graph: {nodes: {s: {type: ScriptNode, inputs: {script: *code}}}}, pulses: {s.execIn: [0]}}\n"
    )
    refused = graph("test", "a.test.yaml")
    assert refused.out.splitlines()[-1] == "0 passed, 2 failed"
    assert refused.out.count("--allow-scripts") == 2
    assert graph("test", "a.test.yaml", "--allow-scripts").out.splitlines()[-1] == "2 passed, 0 failed"


OGN = """\
{"omni.graph.action.Branch": {
  "description": "x",
  "inputs": {"execIn": {"type": "execution"}, "condition": {"type": "bool"}},
  "outputs": {"execTrue": {"type": "execution"}, "execFalse": {"type": "execution"}},
  "tests": [
    {"inputs:condition": true, "outputs:execTrue": 1, "outputs:execFalse": 0},
    {"inputs": {"condition": false}, "outputs": {"execTrue": 1}, "gpu": false}
  ]
}}
"""


def test_the_tests_of_an_ogn_file_run_with_their_lines(graph, folder):
    (folder / "OgnBranch.ogn").write_text(OGN)
    result = graph("test", "OgnBranch.ogn")
    lines = [line.partition(" (")[0] for line in result.out.splitlines()]
    assert (result.code, lines[0]) == (1, "ok     OgnBranch.ogn: omni.graph.action.Branch test 0")
    assert lines[2] == "       OgnBranch.ogn:7:50: fired execTrue: expected [0], got []"
    assert lines[3] == "1 passed, 1 failed"


def test_an_ogn_file_whose_tests_cannot_run_says_why(graph, folder):
    (folder / "a.ogn").write_text('{"a.A": {"tests": [{"setup": {"nodes": []}, "inputs:a": 1}, 3]}}')
    (folder / "b.ogn").write_text('{"a.B": {"description": "x"}}')
    assert [line.partition(": ")[2] for line in graph("test", "a.ogn", "b.ogn").err.splitlines()] == [
        'case "a.A test 0": no node type "a.A"; no node package is installed, and '
        "--nodes FILE.py brings types of your own",
        '"setup" is nothing that can be tested here; write the test as a *.test.yaml file',
        "a test is a mapping such as {inputs:a: 1, outputs:b: 2}",
        '"a.B" has no list of tests; add "tests"',
    ]
