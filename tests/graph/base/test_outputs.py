"""Files are written whole or not at all, never through a link; only regular files are read."""

import errno
import os
import stat
import sys

import pytest

from graph.base.errors import UserError
from graph.base.inputs import opened, read, read_text, start_of
from graph.base.limits import OverLimit, raised
from graph.base.outputs import (
    LinkError,
    changed,
    created,
    make_folder,
    make_output,
    replacing,
    replacing_text,
    write,
)

posix = pytest.mark.skipif(sys.platform == "win32", reason="links and pipes of POSIX")


def test_a_file_takes_its_place_when_it_is_whole(tmp_path):
    file = tmp_path / "a"
    file.write_bytes(b"earlier")
    with replacing(file) as stream:
        stream.write(b"later")
        assert file.read_bytes() == b"earlier"
    assert file.read_bytes() == b"later"
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt(), ValueError("wrong")])
def test_what_goes_wrong_leaves_the_earlier_file_alone(tmp_path, error):
    file = tmp_path / "a"
    file.write_bytes(b"earlier")

    def fail():
        with replacing(file) as stream:
            stream.write(b"la")
            raise error

    with pytest.raises(type(error)):
        fail()
    assert file.read_bytes() == b"earlier"
    assert os.listdir(tmp_path) == ["a"]


@posix
@pytest.mark.parametrize("way", [lambda path: write(path, b"x"), created, changed, lambda path: make_folder(path, "b")])
@pytest.mark.parametrize("there", [True, False])
def test_nothing_is_written_through_a_link(tmp_path, way, there):
    target = tmp_path / "target"
    if there:
        target.write_bytes(b"secret")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").symlink_to(target)
    path = tmp_path / "a" if way.__name__ == "<lambda>" and way.__code__.co_names[0] == "make_folder" else None
    with pytest.raises(LinkError, match=r"b is a link, and nothing is written through links"):
        way(path or tmp_path / "a" / "b")
    assert target.exists() is there
    assert not there or target.read_bytes() == b"secret"


@posix
def test_a_folder_below_what_is_read_is_reached_through_no_link(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "run" / "pages").symlink_to(tmp_path / "elsewhere")
    for out in ("run/pages", "run/pages/more", "run/../run/pages"):
        with pytest.raises(LinkError):
            make_output(tmp_path / out, tmp_path / "run")
    # A link that the user names, outside of what is read, is the user's own.
    (tmp_path / "mine").symlink_to(tmp_path / "elsewhere")
    assert make_output(tmp_path / "mine" / "made", tmp_path / "run").is_dir()
    assert (tmp_path / "elsewhere" / "made").is_dir()


@posix
def test_a_pipe_is_neither_read_nor_written(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for way in (opened, lambda path: write(path, b""), created):
        with pytest.raises(OSError, match="not a regular file"):
            way(tmp_path / "pipe")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_a_folder_is_no_file(tmp_path):
    for way in (opened, lambda path: write(path, b""), created):
        with pytest.raises(OSError, match=r"folder|directory"):
            way(tmp_path)


@posix
def test_a_file_with_two_names_is_not_changed_in_place(tmp_path):
    (tmp_path / "a").write_bytes(b"")
    os.link(tmp_path / "a", tmp_path / "b")
    with pytest.raises(UserError, match="has another name too"):
        changed(tmp_path / "a")
    write(tmp_path / "a", b"new")
    assert (tmp_path / "b").read_bytes() == b""


@posix
def test_permissions_stay_and_new_files_follow_the_umask(tmp_path):
    (tmp_path / "a").write_bytes(b"")
    (tmp_path / "a").chmod(0o600)
    before = os.umask(0o027)
    try:
        write(tmp_path / "a", b"x")
        write(tmp_path / "b", b"x")
    finally:
        os.umask(before)
    assert [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in "ab"] == [0o600, 0o640]


def test_a_name_as_long_as_the_system_allows_can_be_written(tmp_path):
    write(tmp_path / ("n" * 255), b"x")
    assert os.listdir(tmp_path) == ["n" * 255]


def test_text_keeps_its_line_ends(tmp_path):
    with replacing_text(tmp_path / "a") as stream:
        stream.write("a\r\nb\n\udcff")
    assert (tmp_path / "a").read_bytes() == b"a\r\nb\n\\udcff"


def test_no_more_of_a_file_is_read_than_the_limit(tmp_path):
    """A sparse file of 20 GB takes no space on disk, and 20 GB in memory if it is read whole."""
    file = tmp_path / "sparse"
    with file.open("wb") as stream:
        stream.truncate(20_000_000_000)
    assert start_of(file, 3) == b"\0\0\0"
    with raised({"file.json": 1000}), pytest.raises(OverLimit, match=r"sparse is too large.*--limit file\.json=N"):
        read(file, "file.json")


def test_text_that_is_not_utf8_is_a_mistake_of_the_user(tmp_path):
    (tmp_path / "a").write_bytes(b"\xff")
    with pytest.raises(UserError, match="not UTF-8"):
        read_text(tmp_path / "a", "file.json")
