"""`play:` of test files: what the subscribers of a case receive."""

import pytest

from graph.base.errors import UserError
from graph.testing import run_graph
from graph.testing.cases import read_cases
from graph.testing.checking import check_cases
from graph.testing.running import run_case

LISTENER = """\
tickgraph: 1
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      command: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel}}
    connections: [tick.tick -> command.execIn]
"""
TWIST = "{at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 0.25}}}"
# At 60 Hz, 0.5 s is the end of update 29.
EXPECT = "{fired: {command.execOut: [29]}, outputs: {command.linearVelocity: [0.25, 0, 0]}}"


@pytest.fixture
def cases(tmp_path):
    """The cases of a test file that holds this one, beside the listener and a file of messages."""
    (tmp_path / "robot.yaml").write_text(LISTENER)
    (tmp_path / "commands.yaml").write_text(f"- {TWIST}\n")

    def read(text):
        (tmp_path / "robot.test.yaml").write_text("tickgraph_tests: 1\ncases:\n  it:\n" + text)
        return read_cases(tmp_path / "robot.test.yaml")

    return read


@pytest.mark.parametrize("play", ["commands.yaml", TWIST, f"[{TWIST}]", "[commands.yaml]"])
def test_a_case_receives_messages_of_files_and_its_own(play, cases):
    found = cases(f"    play: {play}\n    updates: 40\n    expect: {EXPECT}\n")
    assert [*found.problems, *check_cases(found.cases)] == []
    [case] = found.cases
    assert not run_case(case).failures


def test_without_messages_nothing_is_received(cases):
    [case] = cases("    updates: 40\n    expect: {fired: {command.execOut: []}}\n    world: true\n").cases
    assert not run_case(case).failures


def test_a_single_node_receives_them_too(cases):
    text = (
        f"    node: ROS2SubscribeTwist\n    inputs: {{topicName: cmd_vel}}\n    pulses: {{execIn: [0..39]}}\n"
        f"    play: {TWIST}\n    updates: 40\n    expect: {{fired: {{execOut: [29]}}}}\n"
    )
    [case] = cases(text).cases
    assert not run_case(case).failures


@pytest.mark.parametrize(
    ("play", "place", "message"),
    [
        ("7", "4:11", "play must be a file of messages, a message, or a list of such, found number 7"),
        ("none.yaml", "4:11", 'play: there is no file "none.yaml"'),
        ("{at: 1}", "4:11", "topic is missing"),
        (TWIST.replace("Twist,", "Twst,"), "4:11", 'play: there is no message type "geometry_msgs/msg/Twst"'),
        (f"[commands.yaml, {TWIST.replace('x:', 'up:')}]", "4:27", "has no field linear.up; it has x, y, z"),
        ("commands.yaml\n    world: false", "5:5", "messages come through an App; leave out world: false"),
    ],
)
def test_wrong_messages_are_found_before_anything_runs(play, place, message, cases):
    found = cases(f"    play: {play}\n    updates: 40\n")
    problems = [*found.problems, *check_cases(found.cases)]
    assert len(problems) == 1
    problem = problems[0]
    assert str(problem.mark).endswith(f"robot.test.yaml:{place}")
    assert message in problem.message


def test_run_graph_plays_files_and_needs_an_app_for_it(cases, tmp_path):
    cases("    updates: 1\n")
    trace = run_graph(tmp_path / "robot.yaml", updates=40, play=[tmp_path / "commands.yaml"])
    assert trace.fired("command.execOut") == [29]
    with pytest.raises(UserError, match="messages come through an App"):
        run_graph(tmp_path / "robot.yaml", updates=1, app=False, play=[tmp_path / "commands.yaml"])
