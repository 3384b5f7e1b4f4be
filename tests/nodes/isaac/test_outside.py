"""Environment variables and files: only what the user allows."""

import pytest

from graph import ComputeError
from graph.testing import run_node


def environment(name):
    trace = run_node("IsaacReadEnvVar", inputs={"envVar": name})
    return trace.value("value"), [one.code for one in trace.warnings]


def test_a_variable_that_the_user_allows_is_read(monkeypatch):
    monkeypatch.setenv("ROBOT_NAME", "carter")
    monkeypatch.setenv("TICKGRAPH_ALLOW_ENV", "OTHER, ROBOT_NAME")
    assert environment("ROBOT_NAME") == ("carter", [])
    assert environment("OTHER") == ("", [])
    assert environment("") == ("", [])


def test_any_other_variable_reads_as_empty_and_warns(monkeypatch):
    monkeypatch.setenv("SECRET", "x")
    monkeypatch.delenv("TICKGRAPH_ALLOW_ENV", raising=False)
    assert environment("SECRET") == ("", ["environment-not-allowed"])


@pytest.fixture
def allowed(tmp_path, world):
    """A world whose graph file lies in `tmp_path`/graphs, with notes.txt in there and secret.txt beside it."""
    folder = tmp_path / "graphs"
    folder.mkdir()
    (folder / "notes.txt").write_text("grüß dich\n", encoding="utf-8")
    (folder / "raw.bin").write_bytes(b"\xff\xfe\xff")
    (tmp_path / "secret.txt").write_text("no")
    (folder / "link.txt").symlink_to(tmp_path / "secret.txt")
    app = world()
    app.folders = (folder,)
    return app


def read(app, path):
    trace = run_node("IsaacReadFilePath", inputs={"path": str(path)}, app=app)
    return trace.value("fileContents"), [one.code for one in trace.warnings]


def test_a_file_below_the_graph_files_folder_is_read(allowed):
    assert read(allowed, "notes.txt") == ("grüß dich\n", [])
    assert read(allowed, allowed.folders[0] / "notes.txt") == ("grüß dich\n", [])


def test_a_file_below_another_allowed_folder_is_read(allowed, tmp_path):
    allowed.folders = (*allowed.folders, tmp_path)
    assert read(allowed, tmp_path / "secret.txt") == ("no", [])


@pytest.mark.parametrize("path", ["", "gone.txt", "."])
def test_without_a_file_the_text_is_empty_and_the_node_warns(allowed, path):
    assert read(allowed, path) == ("", ["file-missing"])


@pytest.mark.parametrize("path", ["../secret.txt", "/etc/hostname", "link.txt"])
def test_a_file_elsewhere_is_refused_also_through_a_link(allowed, path):
    with pytest.raises(ComputeError, match="lies outside graphs/, the graph file's folder"):
        read(allowed, path)


def test_what_is_not_a_text_is_refused(allowed):
    with pytest.raises(ComputeError, match=r"raw\.bin is not UTF-8 text"):
        read(allowed, "raw.bin")


def test_a_graph_without_a_file_reads_none(world):
    with pytest.raises(ComputeError, match="was not loaded from a file, so no folder is allowed"):
        read(world(), "notes.txt")


def test_an_opened_graph_file_allows_its_own_folder(tmp_path):
    from graph.sim import App

    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "g.yaml").write_text("tickgraph: 1\ngraphs: {}\n")
    with App.from_file(tmp_path / "g.yaml") as app:
        assert read(app, "notes.txt") == ("hello", [])
