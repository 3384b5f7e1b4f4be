"""`--write`: the block goes into the file, and nothing else changes."""

from __future__ import annotations

import json

import pytest

from graph.base.errors import UserError
from graph.files import examine
from wings.trade.writing import check_writable, with_block, write_block

NEW = {"physics.hz": "240", "lidar.motion": "continuous", "lidar.noise": "on"}

FLOW = """\
tickgraph: 1 # the format
fidelity: {lidar.motion: frozen, physics.hz: 60} # cheap
scene: {prims: {/World/Cube: {type: Cube, size: 1.0, \
translate: [0, 0, 1]}}}
"""

BLOCK = """\
tickgraph: 1
scene:
  prims:
    /World/Cube: {type: Cube,
                  size: 1.0}   # on two lines

fidelity: # knobs
  # why not more
  lidar.motion: frozen   # cheap
  mesh.tolerance: 0.01

# what runs
duration: 2
"""


@pytest.fixture
def file(tmp_path):
    def write(text, name="a.yaml"):
        path = tmp_path / name
        path.write_bytes(text.encode())
        return path

    return write


def fidelity_of(path):
    return dict(examine(path).spec.fidelity)


def test_a_block_that_is_there_keeps_its_comments_and_other_knobs(file):
    path = file(BLOCK)
    write_block(path, NEW)
    text = path.read_text()
    assert fidelity_of(path) == {
        "physics.hz": 240,
        "lidar.noise": "on",
        "lidar.motion": "continuous",
        "mesh.tolerance": 0.01,
    }
    assert text.partition("fidelity:")[0] == BLOCK.partition("fidelity:")[0]
    assert text.partition("# what runs")[2] == BLOCK.partition("# what runs")[2]
    assert "fidelity: # knobs" in text
    assert "# why not more" in text
    assert "# cheap" in text


def test_a_block_in_one_line_stays_in_one_line(file):
    path = file(FLOW)
    write_block(path, NEW)
    lines = path.read_text().splitlines()
    assert lines[0] == FLOW.splitlines()[0]
    assert lines[2:] == FLOW.splitlines()[2:]
    assert lines[1].endswith("# cheap")
    assert fidelity_of(path) == {"physics.hz": 240, "lidar.motion": "continuous", "lidar.noise": "on"}


def test_a_new_block_stands_behind_the_clock(file):
    text = "tickgraph: 1\nscene: {}\n# rates\nclock:\n  loop_hz: 60\n  # half\n\n# graphs\ngraphs: {}\n"
    path = file(text)
    write_block(path, {"tlas": "frame"})
    assert path.read_text() == text.replace("loop_hz: 60\n", "loop_hz: 60\nfidelity:\n  tlas: frame\n")


def test_a_new_block_ends_a_file_without_anything_behind(file):
    path = file("tickgraph: 1\nscene: {}")
    write_block(path, {"tlas": "frame"})
    assert path.read_text() == "tickgraph: 1\nscene: {}\nfidelity:\n  tlas: frame\n"


def test_json_keeps_its_keys_in_order(file):
    path = file(json.dumps({"tickgraph": 1, "fidelity": {"tlas": "frame"}, "scene": {}}), "a.json")
    write_block(path, NEW)
    assert [*json.loads(path.read_text())] == ["tickgraph", "fidelity", "scene"]
    assert fidelity_of(path) == {"tlas": "frame", "physics.hz": 240, "lidar.motion": "continuous", "lidar.noise": "on"}


def test_checking_changes_nothing(file):
    for text in (BLOCK, FLOW):
        path = file(text)
        check_writable(path)
        assert path.read_text() == text


@pytest.mark.parametrize(("name", "text"), [("a.usda", "#usda 1.0\n"), ("a.yaml", "{tickgraph: 1}\n")])
def test_what_cannot_be_written_in_place_is_refused(file, name, text):
    with pytest.raises(UserError, match="paste the block"):
        check_writable(file(text, name))


def test_the_lines_of_windows_stay(file):
    path = file(BLOCK.replace("\n", "\r\n"))
    assert with_block(path, {}).startswith("tickgraph: 1\r\nscene:")


def test_every_line_of_a_block_ends_as_those_of_windows_do(file):
    for text in (BLOCK, FLOW, "tickgraph: 1\nscene: {}\n"):
        changed = with_block(file(text.replace("\n", "\r\n")), NEW)
        assert changed.count("\n") == changed.count("\r\n")


def test_a_new_block_stands_before_the_end_of_the_document(file):
    path = file("---\ntickgraph: 1\nscene: {}\n...\n")
    write_block(path, {"tlas": "frame"})
    assert path.read_text() == "---\ntickgraph: 1\nscene: {}\nfidelity:\n  tlas: frame\n...\n"


def test_knobs_of_a_block_without_any_stand_before_its_comments(file):
    path = file("tickgraph: 1\nfidelity: # knobs\n# rates\nclock: {loop_hz: 60}\n")
    write_block(path, {"tlas": "frame"})
    assert path.read_text() == "tickgraph: 1\nfidelity: # knobs\n  tlas: frame\n# rates\nclock: {loop_hz: 60}\n"


def test_new_knobs_stand_before_the_comments_at_the_end_of_a_block(file):
    path = file("tickgraph: 1\nfidelity:\n  physics.hz: 60\n\n# the end\n")
    write_block(path, {"physics.hz": "240", "tlas": "frame"})
    assert path.read_text() == "tickgraph: 1\nfidelity:\n  tlas: frame\n  physics.hz: 240\n\n# the end\n"


@pytest.mark.parametrize("text", ['{"tickgraph": 1, "fidelity": null}', '\ufeff{"tickgraph": 1}'])
def test_json_without_knobs_or_with_a_byte_order_mark_gets_them(file, text):
    path = file(text, "a.json")
    write_block(path, {"tlas": "frame"})
    assert path.read_text().startswith("\ufeff") == text.startswith("\ufeff")
    assert fidelity_of(path) == {"tlas": "frame"}


@pytest.mark.parametrize(("name", "text"), [("a.json", '{"tickgraph": 1, '), ("a.json", "[1]"), ("a.yaml", "a: [\n")])
def test_what_is_wrong_with_a_broken_file_is_told_when_it_is_opened(file, name, text):
    path = file(text, name)
    check_writable(path)
    with pytest.raises(UserError, match="paste the block"):
        write_block(path, NEW)
