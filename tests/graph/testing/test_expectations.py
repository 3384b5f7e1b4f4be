"""Each kind of expectation is met by what happens, and fails with its line when it is not."""

import pytest

SMALL = """\
cases:
  it:
    graph: small.yaml
    updates: 12
    expect:
      {expectation}
"""

# An expectation that is met, one that fails, and the report about the latter. The expectation stands in line 7.
EXPECTATIONS = {
    "fired": (
        "fired: {wait.finished: [4, 9], tick.tick: [0..11]}",
        "fired: {wait.finished: [4, 10]}",
        "small.test.yaml:7:15: fired wait.finished: expected [4, 10], got [4, 9]",
    ),
    "fired often": (
        "fired: {tick.tick: 12}",
        "fired: {tick.tick: 11}",
        "small.test.yaml:7:15: fired tick.tick: expected 11, got 12 [0..11]",
    ),
    "fired never": (
        "fired: {wait.finished: [4, 9]}",
        "fired: {wait.finished: []}",
        "fired wait.finished: expected [], got [4, 9]",
    ),
    "a long list": (
        "fired: {tick.tick: [0..11]}",
        "fired: {tick.tick: [0..9, 11, 11, 12]}",
        "got [0..11] (missing [11, 12], extra [10])",
    ),
    "outputs": (
        "outputs: {wait.alpha: 0.25, wait.duration: 4}",
        "outputs: {wait.alpha: 0.5}",
        "small.test.yaml:7:17: outputs wait.alpha: expected 0.5, got 0.25 (error 0.25, tolerance 1e-09)",
    ),
    "outputs of another type": (
        "outputs: {wait.alpha: 0.25}",
        "outputs: {wait.alpha: often}",
        'outputs wait.alpha: expected "often", which cannot be: ',
    ),
    "values in a list": (
        "values: {wait.alpha: [0, 0.25, 0.5, 0.75, 1, 0, 0.25, 0.5, 0.75, 1, 0, 0.25]}",
        "values: {wait.alpha: [0, 0.25, 0.5, 0.7, 1, 0, 0.25, 0.5, 0.75, 1, 1, 0.25]}",
        "small.test.yaml:7:43: values wait.alpha, update 3: expected 0.7, got 0.75",
    ),
    "too few values": (
        "values: {wait.duration: [4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4]}",
        "values: {wait.duration: [4, 4]}",
        "values wait.duration: expected one value for each of 2 updates, got 12 updates",
    ),
    "values by update": (
        "values: {wait.alpha: {1: 0.25, 4: 1, 11: 0.25}, wait.duration: {0..11: 4}}",
        "values: {wait.alpha: {1: 0.25, 4..5: 1}}",
        "small.test.yaml:7:38: values wait.alpha, update 5: expected 1, got 0.0",
    ),
    "values after the end": (
        "values: {wait.alpha: {11: 0.25}}",
        "values: {wait.alpha: {12: 0.5}}",
        "values wait.alpha, update 12: expected 0.5, but only 12 updates were completed",
    ),
    "computes": (
        "computes: {tick: 12}",
        "computes: {tick: 5}",
        "small.test.yaml:7:18: computes tick: expected 5, got 12",
    ),
    "no warnings": (
        "warnings: []",
        "warnings: [lidar-partial-scan]",
        "small.test.yaml:7:18: warnings: expected lidar-partial-scan, got none",
    ),
    "messages without a world": (
        "warnings: []",
        "messages: {/clock: 0}",
        'messages /clock: expected 0, got none: this ran without a world; set "world: true"',
    ),
}


@pytest.mark.parametrize("kind", EXPECTATIONS)
def test_an_expectation_is_met_or_told_with_its_line(kind, run_tests, graph_file):
    met, unmet, message = EXPECTATIONS[kind]
    assert run_tests(SMALL.replace("{expectation}", met)).failures == {"it": []}
    [failure] = run_tests(SMALL.replace("{expectation}", unmet)).failures["it"]
    assert message in failure
    assert failure.startswith("small.test.yaml:7:")


WORLD = """\
cases:
  it:
    scene: {prims: {/World/Lidar: {type: OmniLidar, config: Example_Rotary}}}
    graph:
      nodes:
        tick: OnPlaybackTick
        clock: ROS2PublishClock
        time: IsaacReadSimulationTime
        product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
        cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameSkipCount: 1}}
      connections:
        - tick.tick -> [clock.execIn, product.execIn]
        - time.simulationTime -> clock.timeStamp
        - product.execOut -> cloud.execIn
        - product.renderProductPath -> cloud.renderProductPath
    updates: 12
    expect:
      {expectation}
"""
IN_WORLD = {
    "messages": ("messages: {/clock: [0..11], /odom: 0}", "messages: {/clock: 11}", "expected 11, got 12 [0..11]"),
    "a wrong topic": (
        "messages: {/clock: 12}",
        "messages: {/clocks: 12}",
        'messages /clocks: expected 12, got none: nothing of that name; did you mean "/clock"?',
    ),
    "frames": (
        "frames: {/World/Lidar: [5, 11]}",
        "frames: {/World/Lidar: [6, 12]}",
        "frames /World/Lidar: expected [6, 12], got [5, 11]",
    ),
    "a warning": (
        "warnings: [frame-skip-deprecated]",
        "warnings: []",
        "warnings: not expected: frame-skip-deprecated: /Graph/cloud: ",
    ),
    "a warning's place": (
        "warnings: [{code: frame-skip-deprecated, where: /Graph/cloud, message: frameSkipCount}]",
        "warnings: [{code: frame-skip-deprecated, count: 100}]",
        "warnings: expected frame-skip-deprecated (count: 100), got frame-skip-deprecated (/Graph/cloud, ",
    ),
}


@pytest.mark.parametrize("kind", IN_WORLD)
def test_what_comes_out_of_a_world_is_expected_too(kind, run_tests):
    met, unmet, message = IN_WORLD[kind]
    result = run_tests(WORLD.replace("{expectation}", met))
    assert (result.problems, result.failures) == ([], {"it": []})
    failures = run_tests(WORLD.replace("{expectation}", unmet)).failures["it"]
    assert any(message in failure for failure in failures)
    assert all(failure.startswith("small.test.yaml:19:") for failure in failures)


FAILING = """\
cases:
  it:
    node: Countdown
    inputs: {duration: 3}
    pulses: {execIn: [0, 6]}
    changes: {5: {duration: -1}}
    updates: 9
    expect:
      fired: {finished: [3]}
      outputs: {alpha: 1.0}
      {expectation}
"""
ERRORS = {
    "its text": ("error: duration", "error: wheels", 'error: expected "wheels" in it, got: '),
    "pieces of it": ("error: [duration, update 6]", "error: [duration, update 7]", 'expected "update 7" in it'),
    "its exit code": ("error: {exit: 1}", "error: {exit: 2}", "error: expected exit 2, got exit 1: "),
    "its update": ("error: {update: 6}", "error: {update: 5}", "expected in update 5, came in update 6"),
    "none": ("error: duration", "computes: {}", "expected no error, but the run failed (exit 1): "),
}


@pytest.mark.parametrize("kind", ERRORS)
def test_an_expected_error_is_part_of_the_test(kind, run_tests):
    met, unmet, message = ERRORS[kind]
    assert run_tests(FAILING.replace("{expectation}", met)).failures == {"it": []}
    [failure] = run_tests(FAILING.replace("{expectation}", unmet)).failures["it"]
    assert message in failure


def test_an_error_that_does_not_come_is_a_failure(run_tests):
    [failure] = run_tests(
        """\
        cases:
          it:
            node: Countdown
            updates: 3
            expect:
              error: {message: duration, exit: 1}
        """
    ).failures["it"]
    wanted = 'error: expected an error ("duration", exit 1), but 3 updates ran without one'
    assert failure == f"small.test.yaml:7:7: {wanted}"


def test_what_should_come_before_an_error_is_looked_at(run_tests):
    text = FAILING.replace("{expectation}", "error: duration").replace("[3]", "[2]").replace("1.0", "0.5")
    failures = run_tests(text).failures["it"]
    assert [failure.partition(": ")[2][:20] for failure in failures] == ["fired finished: expe", "outputs alpha: expec"]


def test_wrong_input_can_be_expected_but_then_nothing_else(run_tests):
    text = """\
        cases:
          it:
            node: Countdwn
            expect: {error: {message: did you mean "Countdown", exit: 2}}
        """
    assert run_tests(text).failures == {"it": []}
    [failure] = run_tests(text.replace("exit: 2}", "exit: 2}, warnings: []")).failures["it"]
    assert "warnings: nothing ran" in failure


def test_a_graph_file_that_cannot_be_run_fails_its_cases(run_tests, graph_file):
    graph_file.write_text(graph_file.read_text().replace("Countdown", "Cuntdown"))
    [failure] = run_tests("cases: {it: {updates: 3, expect: {fired: {wait.finished: []}}}}").failures["it"]
    assert "expected no error, but this cannot be run (exit 2): " in failure
    assert 'small.yaml:6:7: node "wait": no node type "Cuntdown"; did you mean "Countdown"?' in failure


def test_a_missing_world_is_explained(run_tests):
    text = "cases: {it: {node: ROS2PublishClock, pulses: {execIn: [0]}}}"
    [failure] = run_tests(text).failures["it"]
    assert failure.endswith('set "world: true" in the test')
    assert run_tests(text.replace("node:", "world: true, node:")).failures == {"it": []}


def test_a_node_can_be_tested_in_a_world(run_tests):
    result = run_tests(
        """\
        cases:
          it:
            node: ROS2PublishClock
            world: true
            inputs: {timeStamp: 1.5}
            pulses: {execIn: [0, 2]}
            playing: [1, 2]
            updates: 4
            expect: {messages: {/clock: [0, 2]}, warnings: []}
        """
    )
    assert (result.problems, result.failures) == ([], {"it": []})


def test_tolerances_of_a_case_and_of_one_attribute(run_tests):
    text = """\
        cases:
          it:
            node: Countdown
            inputs: {duration: 3}
            pulses: {execIn: [0]}
            updates: 2
            tolerance: {tolerance}
            expect: {outputs: {alpha: 0.333}}
        """
    assert run_tests(text.replace("{tolerance}", "0.001")).failures == {"it": []}
    assert run_tests(text.replace("{tolerance}", "{alpha: 1e-3}")).failures == {"it": []}
    assert len(run_tests(text.replace("{tolerance}", "{duration: 1e-3}")).failures["it"]) == 1


def test_inputs_of_a_node_that_count_as_connected_change_too(run_tests):
    result = run_tests(
        """\
        cases:
          it:
            node: omni.graph.nodes.Add
            connect: {a: double, b: double}
            inputs: {a: 1.0, b: 2.0}
            changes: {2..3: {b: 5.0}}
            updates: 5
            expect: {values: {sum: [3, 3, 6, 6, 6]}}
        """
    )
    assert (result.problems, result.failures) == ([], {"it": []})


def test_variables_of_a_nodes_graph(run_tests):
    result = run_tests(
        """\
        cases:
          it:
            node: ReadVariable
            variables: {gain: {type: double, value: 2.5}}
            inputs: {variableName: gain}
            expect: {outputs: {value: 2.5}}
        """
    )
    assert (result.problems, result.failures) == ([], {"it": []})


SHARED = """\
node: Countdown
inputs: {duration: 4, period: 2}
pulses: {execIn: [0]}
updates: 6
cases:
  as it is:
    expect: {fired: {tick: [2, 4], finished: [4]}}
  joined entry by entry:
    inputs: {period: 1}
    expect: {fired: {tick: [1, 2, 3, 4], finished: [4]}}
"""


def test_what_stands_beside_the_cases_holds_for_all(run_tests):
    result = run_tests(SHARED)
    assert (result.problems, result.failures) == ([], {"as it is": [], "joined entry by entry": []})


def test_a_case_of_its_own_graph_must_get_along_with_what_is_shared(run_tests):
    problems = run_tests(SHARED + "  other: {graph: {nodes: {tick: OnTick}}, pulses: null}\n").problems
    assert problems == [
        'small.test.yaml:3:10: case "other": inputs: "duration" names no attribute; write node.attribute',
        'small.test.yaml:3:23: case "other": inputs: "period" names no attribute; write node.attribute',
    ]  # of the pulses null is left


@pytest.mark.parametrize("world", ["false", "true"])
def test_a_stop_sets_a_node_back(run_tests, world):
    result = run_tests(
        f"""\
        cases:
          it:
            node: Countdown
            world: {world}
            inputs: {{duration: 3}}
            pulses: {{execIn: [0, 2]}}
            stops: [2]
            updates: 7
            expect: {{fired: {{finished: [5]}}}}
        """
    )
    assert (result.problems, result.failures) == ([], {"it": []})
