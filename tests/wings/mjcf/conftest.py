"""Model files and the scenes they open as."""

from __future__ import annotations

import pytest

from wings.mjcf.scene import open_mjcf


@pytest.fixture
def quadruped(tmp_path):
    """The main file of the quadruped."""
    from tests.support.mjcf_robots import write_quadruped

    return write_quadruped(tmp_path)


@pytest.fixture
def model(tmp_path):
    """Writes a model's text to a file: model("<worldbody>...</worldbody>") -> path."""

    def write(body, name="model.xml"):
        file = tmp_path / name
        file.write_text(body if body.lstrip().startswith("<mujoco") else f"<mujoco>\n{body}\n</mujoco>\n")
        return file

    return write


@pytest.fixture
def opened(model):
    """The scene of a model's text, and the warnings it gave."""

    def load(body, **options):
        warnings = []
        return open_mjcf(model(body), warn=lambda *warning: warnings.append(warning), **options), warnings

    return load
