"""Rays drawn into pictures: one of each compute, in the folder of the run."""

import pytest

from graph import ComputeError
from graph.testing import run_node

RAYS = {"beamOrigins": [[0, 0, 0], [0, 1, 0]], "beamEndPoints": [[2, 0, 0], [2, 1, 0]], "numRays": 2}


def draw(app, **inputs):
    return run_node("DebugDrawRayCast", inputs={**RAYS, **inputs}, pulses={"exec": [0, 1]}, updates=2, app=app)


def test_each_compute_writes_a_picture_into_the_runs_folder(world, tmp_path):
    app = world()
    app.output_folder = tmp_path
    draw(app)
    files = sorted(file.name for file in (tmp_path / "debug_view").iterdir())
    assert [name[-11:] for name in files] == ["_000000.png", "_000001.png"]


def test_without_a_folder_it_warns_once_and_writes_nothing(world, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trace = draw(world())
    assert [one.code for one in trace.warnings] == ["debug-view-unavailable"]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"beamEndPoints": [[2, 0, 0]]}, "2 beamOrigins and 1 beamEndPoints; give as many of each"),
        ({"color": [2.0, 0, 0, 1]}, "is not r, g, b, a from 0 to 1"),
        ({"beamWidth": -1.0}, "width is a length of 0 m or more"),
    ],
)
def test_what_cannot_be_drawn_is_reported_in_a_line(world, tmp_path, wrong, message):
    app = world()
    app.output_folder = tmp_path
    with pytest.raises(ComputeError, match=message):
        draw(app, **wrong)
