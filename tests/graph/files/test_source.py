import os

import pytest

from graph.base import limits
from graph.base.errors import Mark, UserError
from graph.files import load, loads
from graph.files.source import Source

SMALL = b"tickgraph: 1\ngraphs: {/G: {nodes: {n: 5}}}\n"


def problems(path):
    with pytest.raises(UserError) as caught:
        load(path)
    return [str(problem) for problem in caught.value.problems]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder, data, name="a.yaml"):
    (folder / name).write_bytes(data)
    return name


def test_offsets_become_lines_and_columns_from_one_for_every_line_break():
    source = Source("f", "ab\ncd\r\nef\rgh")
    assert [source.mark(at) for at in (0, 1, 3, 7, 8, 10, 11)] == [
        Mark("f", 1, 1),
        Mark("f", 1, 2),
        Mark("f", 2, 1),
        Mark("f", 3, 1),
        Mark("f", 3, 2),
        Mark("f", 4, 1),
        Mark("f", 4, 2),
    ]


def test_a_missing_file_is_named_with_its_nearest_neighbour(folder):
    write(folder, SMALL, "yard.yaml")
    assert problems("yrad.yaml") == ['yrad.yaml: no such file; did you mean "yard.yaml"?']
    assert problems("nowhere/x.yaml") == ["nowhere/x.yaml: no such file"]
    told = "graphs/yard.yaml: no such file; a shipped example is written by: graph new yard graphs"
    assert problems("graphs/yard.yaml") == [told]


def test_a_folder_is_not_a_file(folder):
    (folder / "sub.yaml").mkdir()
    assert problems("sub.yaml") == ["sub.yaml is a folder; name a graph file (.yaml, .json or .usda) in it"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_says_so(folder):
    (folder / write(folder, SMALL)).chmod(0)
    assert problems("a.yaml") == ["a.yaml cannot be read: Permission denied"]


def test_a_pipe_is_refused_without_being_opened(folder):
    os.mkfifo(folder / "p.yaml")
    assert problems("p.yaml") == ["p.yaml is not a regular file; a graph file is text on disk"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("robot.xml", "this is not a graph file; name an MJCF model in a graph file: scene: {mjcf: ...}"),
        ("lidar.py", "this is a script, which runs only if you ask for it: graph exec"),
        ("notes.txt", "a graph file ends in .yaml, .yml, .json, .usda, .usd or .usdc"),
    ],
)
def test_other_files_are_distinguished(folder, name, reason):
    write(folder, SMALL, name)
    assert problems(name) == [f"{name}: {reason}"]


@pytest.mark.parametrize("name", ["a.yaml", "a.json"])
@pytest.mark.parametrize("data", [b"", b" \n\t\n", b"\xef\xbb\xbf"])
def test_an_empty_file_says_how_a_graph_file_starts(folder, name, data):
    assert problems(write(folder, data, name)) == [
        f'{name}:1:1: the file is empty; a graph file starts with "tickgraph: 1"'
    ]


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (b"\x7fELF\x02\x01\x01\0\0", "a.yaml:1:1: this is a binary file; a graph file is YAML or JSON text"),
        ("tickgraph: 1".encode("utf-16"), "a.yaml:1:1: this is UTF-16 text; save it as UTF-8"),
        ("tickgraph: 1".encode("utf-32"), "a.yaml:1:1: this is UTF-32 text; save it as UTF-8"),
        ("a: 1\nb: ü\n".encode("latin-1"), "a.yaml:2:4: byte 0xFC is not UTF-8; save the file as UTF-8"),
        (b"a: 1\nb: \x1b[31m\n", "a.yaml:2:4: character U+001B is not allowed here; is this a text file?"),
    ],
)
def test_what_is_not_utf8_text_is_refused(folder, data, line):
    assert problems(write(folder, data)) == [line]


def test_a_byte_order_mark_and_windows_line_ends_change_nothing(folder):
    plain = problems(write(folder, SMALL))
    assert plain == ['a.yaml:2:26: node "n" must be a type id or a mapping with a type, found number 5']
    assert problems(write(folder, b"\xef\xbb\xbf" + SMALL.replace(b"\n", b"\r\n"))) == plain


@pytest.mark.parametrize(("name", "said"), [("a.yaml", "YAML, or write it as JSON"), ("a.json", "JSON; the limit")])
def test_files_above_the_limits_are_refused_before_they_are_parsed(folder, name, said):
    size = limits.most("file.yaml" if name == "a.yaml" else "file.json")
    with (folder / name).open("wb") as stream:
        stream.write(b"[[[[")
        stream.truncate(size + 1)
    [problem] = problems(name)
    assert problem.startswith(f"{name} is too much {said}")
    with (folder / name).open("wb") as stream:
        stream.write(b"{}".ljust(size))
    assert "too much" not in str(problems(name))


def test_text_is_limited_like_files():
    with limits.raised({"file.yaml": 100}), pytest.raises(UserError, match=r"--limit file\.yaml=N"):
        loads("#" * 101)


@pytest.mark.parametrize("name", ["a\0b.yaml", "x" * 300 + ".yaml"])
def test_a_name_that_no_file_can_have_is_one_line(name):
    [problem] = problems(name)
    assert "no such file" in problem or "File name too long" in problem
