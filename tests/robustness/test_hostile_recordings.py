"""Recordings and folders of runs from strangers, given to every command that reads them."""

import json
import os
import shutil
import sqlite3

import lz4.frame
import pytest
import zstandard

from graph.base.errors import RunError, UserError
from graph.base.limits import raised
from graph.cli.main import main
from graph.recording.bag_source import BagSource
from graph.recording.mcap_sink import McapSink
from graph.recording.mcap_source import McapSource
from graph.recording.recovery import finish
from graph.recording.run_reader import open_run
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain
from graph.sim.messages.ros_types import serialize
from tests.support.costs import within
from tests.support.mcap_files import message, written
from tests.support.without_wing import needs_wing

TWIST = "geometry_msgs/msg/Twist"
COMMANDS = {
    "info": ("info", "{}"),
    "view": ("view", "{}"),
    "export": ("export", "{}", "--format", "csv", "--out", "{}/csv"),
    "recover": ("recover", "{}"),
}
VIEW, EXPORT = (pytest.param(name, marks=needs_wing(wing)) for name, wing in (("view", "view"), ("export", "exports")))


@pytest.fixture
def said(capsys):
    """Runs a command; gives its exit code and the lines on stderr."""

    def run(*arguments):
        code = main([*map(str, arguments)])
        lines = capsys.readouterr().err.splitlines()
        assert not any("internal error" in line or "Traceback" in line for line in lines), lines
        return code, lines

    return run


def record(path, provenance=None, topics=("/a",)):
    """Three messages on each topic."""
    bus, sink = MessageBus(), McapSink(path, provenance)
    bus.subscribe(sink)
    for number in range(3):
        for topic in topics:
            bus.publish(topic, TWIST, from_plain(TWIST, {"linear": {"x": number}}), number * 10**9)
    bus.close()
    return path


def database(path, *more, messages="data BLOB NOT NULL", rows=()):
    """A rosbag2 database of one topic, with these statements behind its tables."""
    with sqlite3.connect(path) as made:
        made.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)")
        made.execute(f"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, {messages})")
        made.execute("INSERT INTO topics VALUES (1, '/a', ?, 'cdr')", (TWIST,))
        for statement in more:
            made.execute(statement)
        for row in rows:
            made.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", row)
    made.close()
    return path


# -- writing: links ----------------------------------------------------------------------------------------------------


@needs_wing("view")
@pytest.mark.parametrize("link", ["view", "view/view.html", "view/a_000000ms.png"])
def test_a_page_is_not_written_through_a_link_of_the_run(said, tmp_path, link):
    """The attacker's line would stand on its own: the recording's metadata has line breaks."""
    run, secret = tmp_path / "run", tmp_path / "secret"
    run.mkdir()
    record(run / "run.mcap", {"file": "x\nssh-rsa attacker\n"})
    (run / "report.json").write_text("{}")
    secret.mkdir() if link == "view" else secret.write_text("keys")
    (run / link).parent.mkdir(exist_ok=True)
    (run / link).symlink_to(secret)
    code, lines = said("view", run)
    if link.endswith(".png"):  # this recording has no pictures
        assert code == 0
        assert not any(line.strip() == "ssh-rsa attacker" for line in (run / "view/view.html").read_text().splitlines())
    else:
        assert code == 2
        assert "is a link, and nothing is written through links" in lines[-1]
    assert secret.read_text() == "keys" if secret.is_file() else os.listdir(secret) == []


def test_recovering_a_folder_leaves_linked_recordings_alone(said, tmp_path):
    run = tmp_path / "run"
    run.mkdir()
    elsewhere = record(tmp_path / "elsewhere.mcap")
    unfinished = elsewhere.read_bytes()[:-40]
    elsewhere.write_bytes(unfinished)
    (run / "run.mcap").symlink_to(elsewhere)
    code, lines = said("recover", run)
    assert code == 2
    assert "run.mcap is a link" in lines[-1]
    assert elsewhere.read_bytes() == unfinished


@pytest.mark.parametrize("name", ["run.mcap", "report.json"])
def test_a_run_is_not_written_through_a_link_of_its_folder(said, tmp_path, name):
    (tmp_path / "g.yaml").write_text("tickgraph: 1\n")
    (tmp_path / "out").mkdir()
    (tmp_path / "secret").write_text("keys")
    (tmp_path / "out" / name).symlink_to(tmp_path / "secret")
    code, lines = said("run", tmp_path / "g.yaml", "--updates", "1", "--out", tmp_path / "out")
    assert code == 2
    assert f"{name} is a link" in lines[-1]
    assert (tmp_path / "secret").read_text() == "keys"


@needs_wing("exports")
@pytest.mark.parametrize("place", ["csv", "csv/a.csv"])
def test_an_export_is_not_written_through_a_link_of_the_run(said, tmp_path, place):
    run = tmp_path / "run"
    run.mkdir()
    record(run / "run.mcap")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a.csv").write_text("keys")
    (run / place).parent.mkdir(exist_ok=True)
    (run / place).symlink_to(tmp_path / "folder" if place == "csv" else tmp_path / "folder" / "a.csv")
    code, lines = said("export", run, "--format", "csv", "--out", run / "csv")
    assert code == 2
    assert "is a link" in lines[-1]
    assert (tmp_path / "folder" / "a.csv").read_text() == "keys"


# -- reading: pipes and devices ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["report.json", "metadata.yaml", "run.mcap", "run.db3"])
@pytest.mark.parametrize("kind", ["pipe", "device", "sparse", "folder"])
@pytest.mark.parametrize("command", ["info", VIEW, EXPORT, "recover"])
def test_what_is_no_regular_file_is_not_read(said, tmp_path, name, kind, command):
    run = tmp_path / "run"
    run.mkdir()
    record(run / "good.mcap")
    if kind == "pipe":
        os.mkfifo(run / name)
    elif kind == "device":
        (run / name).symlink_to("/dev/zero")
    elif kind == "folder":
        (run / name).mkdir()
    else:
        with (run / name).open("wb") as file:
            file.truncate(20_000_000_000)
    with within(20):
        code, _ = said(*(one.format(run) for one in COMMANDS[command]))
    assert code in (0, 1, 2)


# -- reading: work -----------------------------------------------------------------------------------------------------


def test_an_index_that_names_a_chunk_again_and_again_is_refused(tmp_path):
    path = written(tmp_path / "x.mcap", message(600), compression="", repeats=1000)
    with pytest.raises(UserError, match="its index names chunks that overlap or are not in it"):
        McapSource(path)


def test_a_chunk_that_unpacks_to_far_more_than_the_file_is_counted(tmp_path):
    plain = message(1_000_000)
    packed = zstandard.compress(plain)  # to less than a 255th
    path = written(tmp_path / "x.mcap", packed, compression="zstd", size=len(plain), starts=(0,) * 5)
    assert len(list(McapSource(path))) == 5
    said = r"far more than its size.*recording\.unpacked"
    with raised({"recording.unpacked": 1}), pytest.raises(RunError, match=said):
        list(McapSource(path))


def test_messages_of_some_bytes_each_are_counted(tmp_path):
    """31 zeros a message pack to less than a byte."""
    packed = lz4.frame.compress(message(0) * 100_000)
    path = written(tmp_path / "x.mcap", packed, compression="lz4")
    with raised({"recording.messages": 1000}):
        assert path.stat().st_size < 100_000 - 1000
        with pytest.raises(RunError, match=r"far more messages than its size.*recording\.messages"):
            list(McapSource(path))
        path.write_bytes(path.read_bytes()[:-40])
        with pytest.raises(UserError, match=r"recording\.messages"):
            finish(path)


@pytest.mark.parametrize(
    ("more", "column"),
    [
        ((), "data BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL"),
        (("CREATE VIEW other AS SELECT 1",), "data BLOB"),
        (("CREATE VIRTUAL TABLE other USING fts5(a)",), "data BLOB"),
    ],
)
@pytest.mark.parametrize("command", ["info", VIEW])
def test_a_database_that_computes_what_is_read_is_refused(said, tmp_path, more, column, command):
    code, lines = said(command, database(tmp_path / "run.db3", *more, messages=column))
    assert code == 2
    assert "which no rosbag2 recording has" in lines[-1]


@pytest.mark.parametrize(
    "row",
    [
        (1, 1e300, b""),
        (1, "x", b""),
        (1, None, b""),
        (1, 0, 7),
        (1, 0, "text"),
        (1, 0, None),
        (1, 0, b"not CDR"),
        ("x", 0, b""),
        (1, -(2**63), b""),
    ],
)
@pytest.mark.parametrize("command", ["info", VIEW, EXPORT])
def test_cells_of_another_type_are_a_line(said, tmp_path, row, command):
    database(tmp_path / "run.db3", messages="data", rows=[row])
    assert said(*(one.format(tmp_path) for one in COMMANDS[command]))[0] in (0, 1, 2)


def test_rows_that_share_their_bytes_are_counted(tmp_path, monkeypatch):
    """A damaged file can let many rows name the same pages; here the file claims to be shorter than its rows."""
    data = serialize(from_plain(TWIST, {}), TWIST)
    path = database(tmp_path / "run.db3", rows=[(1, n, data) for n in range(1000)])
    source = BagSource(path)
    assert len(list(source)) == 1000
    monkeypatch.setattr("graph.recording.bag_source.FEWEST_STEPS", 0)
    monkeypatch.setattr("graph.recording.bag_source.STEPS_A_BYTE", 0)
    with pytest.raises(RunError, match="more rows than bytes for them"):
        list(source)


def test_a_cell_beyond_the_limit_is_refused(tmp_path):
    path = database(tmp_path / "run.db3", rows=[(1, 0, bytes(20_000))])
    with raised({"recording.record": 10_000}), pytest.raises((UserError, RunError), match=r"recording\.record|too big"):
        list(BagSource(path))


# -- numbers and names -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", ["Infinity", "-Infinity", "NaN", "1e999", "1" + "0" * 400, '"1e400"', "null", "[]"])
@pytest.mark.parametrize("key", ["updates", "loop_hz", "physics_steps", "physics_hz"])
@pytest.mark.parametrize("command", ["info", VIEW])
def test_a_report_may_say_any_number(said, tmp_path, number, key, command):
    record(tmp_path / "run.mcap", {"loop_hz": "1e400"})
    report = {"updates": 3, "loop_hz": "60", "physics_steps": 3, "physics_hz": "60"}
    text = json.dumps({**report, key: "@", "topics": {"/a": {"due": "@"}}}).replace('"@"', number)
    (tmp_path / "report.json").write_text(text)
    assert said(command, tmp_path)[0] == 0


@pytest.mark.parametrize("nanoseconds", [2**63, 2**64 - 1])
@pytest.mark.parametrize("command", ["info", VIEW, EXPORT])
def test_a_log_time_may_be_any_that_the_format_holds(said, tmp_path, nanoseconds, command):
    bus, sink = MessageBus(), McapSink(tmp_path / "run.mcap")
    bus.subscribe(sink)
    bus.publish("/a", TWIST, from_plain(TWIST, {}), nanoseconds)
    bus.close()
    with open_run(tmp_path, whole=False) as run:
        assert [entry.time_ns for entry in run.read()] == [2**63 - 1]
    assert said(*(one.format(tmp_path) for one in COMMANDS[command]))[0] == 0


@needs_wing("view")
def test_a_full_disk_keeps_the_earlier_page(said, tmp_path):
    resource = pytest.importorskip("resource")
    record(tmp_path / "run.mcap")
    assert said("view", tmp_path)[0] == 0
    page = (tmp_path / "view/view.html").read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(page) // 2, before[1]))
    try:
        code, lines = said("view", tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (code, len(lines)) == (1, 1)
    assert (tmp_path / "view/view.html").read_bytes() == page
    assert os.listdir(tmp_path / "view") == ["view.html"]
    shutil.rmtree(tmp_path / "view")
