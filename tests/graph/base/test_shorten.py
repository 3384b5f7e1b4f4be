from graph.base.errors import Mark, Problem, RunError, UserError
from graph.base.shorten import LONGEST, SHORT, WORD, brief, listed
from graph.files import loads
from graph.plan import compile_graphs
from graph.sim.warnings import WarningList

LONG = "Counter" * 700


def test_a_message_that_a_person_can_read_is_left_as_it_is():
    message = f'no node type "{"x" * (SHORT - 20)}"'
    assert brief(message) == message


def test_a_long_name_keeps_its_start_and_its_end_and_what_stands_around_it():
    short = brief(f'node "n": no node type "{LONG}"; did you mean "Count"?')
    start, end = f'"{LONG}'[: WORD - WORD // 4 - 3], f'{LONG}"'[-WORD // 4 :]
    assert short == f'node "n": no node type {start}...{end}; did you mean "Count"?'


def test_what_stands_between_two_quoted_names_is_kept():
    between = " and what is said at some length of both of them " * 4
    assert brief(f'"a"{between}"b"{LONG}').startswith(f'"a"{between}"b"')


def test_many_short_words_lose_their_middle_but_not_what_to_do():
    short = brief(f"found {'a, ' * 20_000}; remove one of them")
    assert len(short) == LONGEST
    assert short.startswith("found a, a, ")
    assert short.endswith("; remove one of them")


def test_shortening_twice_changes_nothing():
    once = brief(f'"{LONG}" {LONG} ' + "ab " * 5000)
    assert brief(once) == once


def test_lists_end_with_how_many_more_there_are():
    assert listed(["a", "b"], 2) == "a, b"
    assert listed([*"abcdefghij"], 8) == "a, b, c, d, e, f, g, h and 2 more"


def test_problems_failures_and_warnings_are_short_wherever_they_come_from():
    mark = Mark("f.yaml", 1, 2)
    assert len(str(Problem(LONG, mark))) == len("f.yaml:1:2: ") + WORD
    assert len(str(UserError(LONG))) == WORD
    assert len(str(RunError(LONG))) == WORD
    warnings = WarningList()
    warnings.add("node-warning", "/G/n", LONG)
    assert [len(one.message) for one in warnings] == [WORD]


def test_a_cycle_of_hundreds_of_nodes_is_one_short_line():
    nodes = ", ".join(f"n{i}: {{type: Add, inputs: {{b: 1.0}}}}" for i in range(300))
    links = ", ".join(f"n{i}.sum -> n{(i + 1) % 300}.a" for i in range(300))
    spec = loads(f"tickgraph: 1\ngraphs: {{/G: {{nodes: {{{nodes}}}, connections: [{links}]}}}}")
    try:
        compile_graphs(spec.graphs)
    except UserError as error:
        [problem] = error.problems
    assert "n0.outputs:sum -> n1.inputs:a, " in problem.message
    assert " and 292 more. Remove one of these connections" in problem.message
