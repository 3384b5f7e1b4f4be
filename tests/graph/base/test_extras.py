"""The command that adds an extra fits the installation: a checkout, a wheel from a file, a package index."""

import json
import sys
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest

from graph.base import extras


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """An installation in an environment, from a URL; `pip` on the path is this Python's."""

    def make(url):
        (tmp_path / "lib").mkdir(exist_ok=True)
        text = json.dumps({"url": url}) if url else None
        monkeypatch.setattr(extras, "ROOT", tmp_path / "lib")
        found = SimpleNamespace(read_text=lambda name: text)
        monkeypatch.setattr(metadata, "distribution", lambda name: found)
        monkeypatch.setattr(extras.shutil, "which", lambda name: str(Path(sys.executable).parent / "pip"))

    return make


def test_a_checkout_is_installed_from_its_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(extras.shutil, "which", lambda name: str(Path(sys.executable).parent / "pip"))
    monkeypatch.chdir(extras.ROOT)
    assert extras.install_command("foxglove") == "pip install -e '.[foxglove]'"
    monkeypatch.chdir(tmp_path)
    assert extras.install_command("foxglove") == f"pip install -e '{extras.ROOT}[foxglove]'"


def test_an_index_is_asked_by_name_and_a_file_again_as_long_as_it_is_there(installed, tmp_path):
    installed(None)
    assert extras.install_command("view") == "pip install 'tickgraph[view]'"
    wheel = tmp_path / "tickgraph-0.1.0-py3-none-any.whl"
    installed(wheel.as_uri())
    assert extras.install_command("view") == "pip install 'tickgraph[view]'"
    wheel.touch()
    assert extras.install_command("view") == f"pip install '{wheel}[view]'"


def test_where_pip_is_that_of_another_python_this_one_is_named(installed, monkeypatch, tmp_path):
    """With its whole path, outside of the folder that it is in."""
    installed(None)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(extras.shutil, "which", lambda name: "/usr/bin/pip")
    assert extras.install_command("view") == f"{sys.executable} -m pip install 'tickgraph[view]'"
