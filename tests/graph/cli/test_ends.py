"""How commands end: closed streams, early signals, one run a folder, what an earlier run left."""

import fcntl
import json
import os
import signal
import subprocess
import sys

import pytest
from mcap.reader import make_reader

from graph.cli.main import main
from tests.support.programs import started

GRAPH = [sys.executable, "-m", "graph"]
SMALL = """
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
    connections:
      - tick.tick -> clock.execIn
      - time.simulationTime -> clock.timeStamp
"""


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "small.yaml"
    file.write_text(SMALL)
    return file


def count(recording):
    with recording.open("rb") as stream:
        return sum(1 for _ in make_reader(stream).iter_messages())


@pytest.mark.parametrize("closed", ["2>&-", ">&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_a_stream_that_the_shell_closed_changes_nothing_of_what_is_recorded(tmp_path, file, closed):
    command = f"{sys.executable} -m graph run {file} --updates 30 --out"
    assert subprocess.run(["sh", "-c", f"{command} {tmp_path}/a"], check=False, capture_output=True).returncode == 0
    ended = subprocess.run(["sh", "-c", f"{command} {tmp_path}/b {closed}"], check=False, capture_output=True)
    assert ended.returncode == 0
    assert (tmp_path / "a/run.mcap").read_bytes() == (tmp_path / "b/run.mcap").read_bytes()
    assert json.loads((tmp_path / "b/report.json").read_text())["updates"] == 30


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_the_command_is_still_being_imported_is_one_line(number):
    program = (
        "import builtins, os, sys; whole = builtins.__import__\n"
        "def held(name, *rest):\n"
        f"    if name == 'main': os.kill(os.getpid(), {int(number)})\n"
        "    return whole(name, *rest)\n"
        "builtins.__import__ = held\n"
        "from graph.cli import command\n"
        "sys.exit(command())"
    )
    with started("-c", program, stderr=subprocess.PIPE, text=True) as process:
        _, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (130, "graph: interrupted\n")


def test_the_run_says_what_it_wrote_and_where(tmp_path, file, capsys):
    out = tmp_path / "out"
    assert main(["run", str(file), "--updates", "30", "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert f"wrote {out}/run.mcap (30 messages, 0.0 MB) and {out}/report.json" in lines
    assert lines[-1] == f"next: graph view {out}"
    assert main(["run", str(file), "--updates", "30", "--out", str(out), "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["updates"] == 30
    assert "wrote " in said.err


def test_the_recording_says_what_made_it(tmp_path, file):
    import hashlib

    assert main(["run", str(file), "--updates", "3", "--seed", "7", "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out/run.mcap").open("rb") as stream:
        (metadata,) = make_reader(stream).iter_metadata()
    assert metadata.name == "tickgraph"
    assert metadata.metadata["sha256"] == hashlib.sha256(SMALL.encode()).hexdigest()
    assert (metadata.metadata["file"], metadata.metadata["seed"]) == ("small.yaml", "7")


def test_a_run_that_ends_well_takes_the_place_of_the_earlier_one(tmp_path, file):
    out = tmp_path / "out"
    for updates in (30, 12):
        assert main(["run", str(file), "--updates", str(updates), "--out", str(out)]) == 0
        assert count(out / "run.mcap") == updates
    assert sorted(one.name for one in out.iterdir()) == ["report.json", "run.mcap"]


def test_a_run_that_fails_at_once_leaves_the_earlier_recording(tmp_path, file, capsys):
    out = tmp_path / "out"
    main(["run", str(file), "--updates", "30", "--out", str(out)])
    before = {one.name: one.read_bytes() for one in out.iterdir()}
    failing = tmp_path / "failing.yaml"
    failing.write_text(FAILS_AT_ONCE)
    capsys.readouterr()
    assert main(["run", str(failing), "--updates", "30", "--out", str(out)]) == 1
    assert {one.name: one.read_bytes() for one in out.iterdir()} == before
    assert f"this run recorded nothing; {out} is as the earlier run left it" in capsys.readouterr().out


def test_a_run_that_fails_later_keeps_both(tmp_path, file, capsys):
    out = tmp_path / "out"
    main(["run", str(file), "--updates", "30", "--out", str(out)])
    failing = tmp_path / "failing.yaml"
    failing.write_text(FAILS_LATER)
    capsys.readouterr()
    assert main(["run", str(failing), "--updates", "30", "--out", str(out)]) == 1
    assert count(out / "run.previous.mcap") == 30
    assert 0 < count(out / "run.mcap") < 30
    assert (
        f"the earlier run's files are kept: {out}/run.previous.mcap, {out}/report.previous" in capsys.readouterr().out
    )


FAILS_AT_ONCE = """
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      zero: {type: ConstantDouble, inputs: {value: 0}}
      divide: {type: Divide, inputs: {a: {type: double, value: 1}}}
      late: {type: ROS2PublishClock, inputs: {topicName: late}}
    connections: [tick.tick -> late.execIn, zero.value -> divide.b, divide.result -> late.timeStamp]
"""
FAILS_LATER = FAILS_AT_ONCE.replace(
    "    connections: [tick.tick -> late.execIn, zero.value -> divide.b, divide.result -> late.timeStamp]",
    """      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      wait: {type: Countdown, inputs: {duration: 5}}
    connections:
      - tick.tick -> [clock.execIn, wait.execIn]
      - wait.finished -> late.execIn
      - zero.value -> divide.b
      - divide.result -> late.timeStamp
      - time.simulationTime -> clock.timeStamp""",
)


def test_a_folder_that_another_run_holds_is_refused(tmp_path, file, capsys):
    out = tmp_path / "out"
    out.mkdir()
    handle = os.open(out, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        assert main(["run", str(file), "--updates", "3", "--out", str(out)]) == 2
    finally:
        os.close(handle)
    assert capsys.readouterr().err == (
        f"graph: {out}: another run is recording into this folder; name another folder, or let that run end\n"
    )
    assert not list(out.iterdir())


@pytest.mark.parametrize("name", ["a" * 251 + ".mcap", "x/" * 1500 + "run.mcap"])
def test_a_recording_whose_name_is_too_long_is_refused(tmp_path, file, capsys, name):
    file.write_text(SMALL + f"record: {{mcap: {name}}}\n")
    assert main(["run", str(file), "--updates", "3", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "File name too long" in said or "longer than" in said


@pytest.mark.parametrize("name", ["report.json", "./report.json", "x/../report.json", "report.previous.json"])
def test_the_recording_cannot_have_the_reports_name(file, capsys, name):
    file.write_text(SMALL + f"record: {{mcap: {name}}}\n")
    assert main(["check", str(file)]) == 2
    assert "record.mcap" in capsys.readouterr().err


def test_recover_mends_in_place_or_beside(tmp_path, file, capsys):
    out = tmp_path / "out"
    main(["run", str(file), "--updates", "90", "--out", str(out)])
    torn = tmp_path / "torn.mcap"
    torn.write_bytes((out / "run.mcap").read_bytes()[:-30])
    before = torn.read_bytes()
    capsys.readouterr()
    assert main(["recover", str(torn), "--out", str(tmp_path / "mended.mcap")]) == 0
    assert capsys.readouterr().out == f"{tmp_path}/mended.mcap: index rebuilt over 90 messages, up to 1.500000000 s\n"
    assert torn.read_bytes() == before
    assert main(["recover", str(torn)]) == 0
    assert count(torn) == count(tmp_path / "mended.mcap") == 90
    capsys.readouterr()
    assert main(["recover", str(torn)]) == 0
    assert "nothing was changed (90 messages)" in capsys.readouterr().out


def test_recover_refuses_what_it_cannot_mend(tmp_path, capsys):
    other = tmp_path / "other.mcap"
    other.write_text("no recording")
    assert main(["recover", str(tmp_path / "none.mcap")]) == 2
    assert main(["recover", str(other)]) == 2
    assert main(["recover", str(other), "--out", str(tmp_path / "copy.mcap")]) == 2
    assert main(["recover", str(other), "--out", str(other)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 4
    assert said.count("not an MCAP recording") == 2
    assert sorted(one.name for one in tmp_path.iterdir()) == ["other.mcap"]
