"""`--play`: files of messages as text, and what is said of wrong ones."""

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.cli.playing import open_sources, play_into, warn_unheard
from graph.files.played import load_played
from graph.sim import App

YAML = """\
- {at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 0.2}}}
- at: 1/3
  topic: /cmd_vel
- {at: 2, topic: chat, type: std_msgs/msg/String, message: {data: on}}
"""
JSON = '[{"at": 0.5, "topic": "/cmd_vel", "type": "geometry_msgs/msg/Twist", "message": {"linear": {"x": 0.2}}}]'


def write(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_yaml_json_and_json_lines_say_the_same(tmp_path):
    entries = [
        load_played(write(tmp_path, name, text))[0]
        for name, text in (("a.yaml", YAML), ("a.json", JSON), ("a.jsonl", JSON[1:-1] + "\n\n"))
    ]
    for entry in entries:
        assert (entry.time, entry.topic, entry.type_name) == (Fraction(1, 2), "/cmd_vel", "geometry_msgs/msg/Twist")
        assert entry.fields == {"linear": {"x": 0.2}}


def test_messages_come_in_the_order_of_their_times(tmp_path):
    [source] = open_sources([write(tmp_path, "a.yaml", YAML)])
    found = [(entry.time_ns, entry.topic, entry.type_name) for entry in source]
    twist = "geometry_msgs/msg/Twist"
    assert found == [
        (333_333_333, "/cmd_vel", twist), (500_000_000, "/cmd_vel", twist), (2 * 10**9, "/chat", "std_msgs/msg/String"),
    ]  # fmt: skip
    loaded = [entry.load() for entry in source]
    assert [loaded[0].linear.x, loaded[1].linear.x, loaded[2].data] == [0, 0.2, "on"]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.yaml", "at: 1", "a.yaml:1:1: messages are a list, found"),
        ("a.yaml", "- 4", "a.yaml:1:3: a message is a mapping, found number 4; write {at: 0.5"),
        ("a.yaml", "- {at: 1, topic: a, typ: b}", 'a.yaml:1:21: unknown key "typ"; did you mean "type"?'),
        ("a.yaml", "- {at: soon, topic: a, type: std_msgs/msg/Empty}", "a.yaml:1:8: at: "),
        ("a.yaml", "- {at: -1, topic: a, type: std_msgs/msg/Empty}", "a.yaml:1:8: at: a time before the start"),
        ("a.yaml", "- {topic: a, type: std_msgs/msg/Empty}", "a.yaml:1:3: at: None is no time; give seconds"),
        ("a.yaml", "- {at: 1, type: std_msgs/msg/Empty}", "a.yaml:1:3: topic is missing"),
        ("a.yaml", "- {at: 1, topic: a}", "a.yaml:1:3: type is missing; the first message on a says its type"),
        (
            "a.yaml",
            "- {at: 1, topic: a, type: std_msgs/msg/Empty}\n- {at: 1, topic: a, type: std_msgs/msg/Bool}",
            "a.yaml:2:27: a has messages of type std_msgs/msg/Empty above; one topic has one type",
        ),
        (
            "a.yaml",
            "- {at: 1, topic: a, type: std_msgs/msg/Empty, message: 3}",
            "a.yaml:1:56: message is a mapping of fields, found number 3",
        ),
        (
            "a.yaml",
            "- {at: 1, topic: a, type: geometry_msgs/Twist}",
            'a.yaml:1:3: there is no message type "geometry_msgs/Twist"; did you mean "geometry_msgs/msg/Twist"?',
        ),
        (
            "a.yaml",
            "- {at: 1, topic: a, type: std_msgs/msg/Bool, message: {dta: 1}}",
            "a.yaml:1:3: std_msgs/msg/Bool has no field dta; it has data",
        ),
        ("a.jsonl", '{"at": 1, "topic": "a", "type": "std_msgs/msg/Empty"}\n{"at": 1', "a.jsonl:2:"),
        ("a.jsonl", '\n{"at": 1, "topic": "a", "typ": 1}', 'a.jsonl:2:25: unknown key "typ"'),
        ("a.txt", "", "messages are played from .mcap, .yaml, .json and .jsonl files"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, monkeypatch, name, text, message):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, name, text)
    with pytest.raises(UserError) as refused:
        open_sources([name])
    assert message in str(refused.value)


def test_the_problems_of_all_files_come_together(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "a.yaml", "- 4\n- 5")
    with pytest.raises(UserError) as refused:
        open_sources(["a.yaml", "gone.mcap", "gone.yaml"])
    lines = str(refused.value).splitlines()
    assert [line.partition(":")[0] for line in lines] == ["a.yaml", "a.yaml", "gone.mcap", "gone.yaml"]


def test_a_file_nobody_listened_to_is_a_warning(tmp_path):
    with App() as app:
        player = play_into(app, open_sources([write(tmp_path, "a.yaml", YAML)]))
        app.play()
        app.update()
        warn_unheard(app, player)
        [warning] = app.warnings
        assert warning.code == "play-unheard"
        assert warning.message == "nobody listened to any of its topics: /chat, /cmd_vel"
