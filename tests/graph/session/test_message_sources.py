"""`--play`: files of messages as text, and what is said of wrong ones."""

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.files.played import load_played
from graph.session.message_sources import files_of, open_sources, play_into, remapping, warn_unheard
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
        ("a.yaml", "- {topic: a, type: std_msgs/msg/Empty}", "a.yaml:1:3: at: None is not a time; give seconds"),
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
        ("a.txt", "", "messages are played from .mcap, .db3, .yaml, .json and .jsonl files, folders of runs"),
    ],
)
def test_what_is_wrong_is_reported_with_its_place(tmp_path, monkeypatch, name, text, message):
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


def a_bag(folder, *, storage="sqlite3"):
    """A rosbag2 recording of two /chat messages at 100 s and 100.5 s of a wall clock of 2024."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = "std_msgs/msg/String"
    plugin = StoragePlugin.SQLITE3 if storage == "sqlite3" else StoragePlugin.MCAP
    start = 1_700_000_000 * 10**9
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/chat", kind, typestore=store)
        for at, text in ((0, "a"), (5 * 10**8, "b")):
            writer.write(connection, start + at, store.serialize_cdr(store.types[kind](text), kind))
    return folder


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_rosbag2_folder_is_played(tmp_path, storage):
    (source,) = open_sources([a_bag(tmp_path / "bag", storage=storage)])
    assert source.topics() == {"/chat": "std_msgs/msg/String"}
    assert source.start_ns() == 1_700_000_000 * 10**9
    assert [(entry.time_ns - source.start_ns(), entry.load().data) for entry in source] == [(0, "a"), (5 * 10**8, "b")]
    source.close()


def test_a_bare_db3_file_is_played(tmp_path):
    (file,) = a_bag(tmp_path / "bag").glob("*.db3")
    (source,) = open_sources([file])
    assert [entry.load().data for entry in source] == ["a", "b"]


def test_folders_and_databases_that_are_not_recordings_are_one_line(tmp_path, monkeypatch):
    import sqlite3

    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "packed").mkdir()
    (tmp_path / "packed" / "a.db3.zstd").write_bytes(b"x")
    (tmp_path / "text.db3").write_text("no database, but some text" * 100)
    with sqlite3.connect(tmp_path / "view.db3") as database:
        database.execute("CREATE VIEW topics AS SELECT 1")
    with pytest.raises(UserError) as refused:
        open_sources(["empty", "packed", "text.db3", "view.db3", "gone.db3"])
    lines = str(refused.value).splitlines()
    assert len(lines) == 5
    for line, said in zip(
        lines,
        (
            "no recording is in this folder",
            "is compressed",
            "not a readable rosbag2",
            "views or triggers",
            "No such file",
        ),
        strict=True,
    ):
        assert said in line


def test_the_help_says_how_messages_are_written(capsys):
    from graph.cli.main import main

    assert main(["run", "--help"]) == 0
    assert "`graph help live-and-recordings`" in " ".join(capsys.readouterr().out.split())
    assert main(["help", "robot"]) == 0
    assert "topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {" in capsys.readouterr().out


def test_remapped_topics_are_played_under_their_new_names(tmp_path):
    (source,) = open_sources([write(tmp_path, "a.yaml", YAML)], remapping(["cmd_vel:=/robot/cmd_vel"]))
    assert source.topics() == {"/robot/cmd_vel": "geometry_msgs/msg/Twist", "/chat": "std_msgs/msg/String"}
    assert [entry.topic for entry in source] == ["/robot/cmd_vel", "/robot/cmd_vel", "/chat"]
    with App() as app:
        play_into(app, [source])
        app.play()
        heard = app.bus.listen("/robot/cmd_vel", "geometry_msgs/msg/Twist")
        app.update(60)
        assert heard.take().message.linear.x == 0


def test_a_recorded_run_is_played_on_another_topic(tmp_path):
    (source,) = open_sources([a_bag(tmp_path / "bag")], {"/chat": "/talk"})
    assert [(entry.topic, entry.load().data) for entry in source] == [("/talk", "a"), ("/talk", "b")]
    assert files_of([source])
    source.close()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["/a=/b"], "--remap /a=/b: write it as OLD:=NEW"),
        (["/a:="], "--remap /a:=: write it as OLD:=NEW"),
        (["/a:=/b", "a:=/c"], "--remap a:=/c: /a already goes to /b"),
        (["/cmd_val:=/b"], "--remap /cmd_val:=/b: the files of --play have no topic /cmd_val; did you mean"),
    ],
)
def test_a_wrong_remapping_is_one_line(tmp_path, options, said):
    with pytest.raises(UserError) as refused:
        open_sources([write(tmp_path, "a.yaml", YAML)], remapping(options))
    assert str(refused.value).startswith(said)


def test_a_remapping_without_a_file_to_play_is_refused():
    with pytest.raises(UserError, match="--remap /a:=/b: it is for the topics of --play; give --play too"):
        open_sources([], remapping(["/a:=/b"]))
