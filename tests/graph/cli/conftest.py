from types import SimpleNamespace

import pytest

from graph.cli.main import main


@pytest.fixture
def graph(capsys):
    """Runs the command in this process; gives its exit code and what it wrote."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return SimpleNamespace(code=code, out=out, err=err)

    return run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
