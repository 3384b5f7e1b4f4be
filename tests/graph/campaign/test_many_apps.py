"""Many Apps in one process share what static scenes and profiles decide, and free it with the last of them."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

from graph.sim import App
from graph.sim.messages.bus import CountingSink
from sensors.raycast.triangles import alive
from tests.support.places import ROOT

MOST_MB = 30
"""A further App of the yard holds 17 MB of arrays and objects; its own copies of everything would be 52 MB."""


def played():
    app = App.from_file(str(ROOT / "graphs/yard.yaml"))
    app.bus.subscribe(CountingSink())
    app.play()
    app.update(steps=7)  # every sensor has rendered
    return app


@pytest.fixture
def first():
    app = played()
    yield app
    app.close()


def test_a_further_app_of_the_yard_holds_only_its_own_state(first):
    scenes = alive()
    tracemalloc.start(1)
    try:
        second = played()
        gc.collect()
        assert tracemalloc.get_traced_memory()[0] < MOST_MB * 1e6
        assert alive() == scenes  # it casts at the structures of the first
        second.close()
        del second
        gc.collect()
        assert tracemalloc.get_traced_memory()[0] < MOST_MB * 1e6 / 3
    finally:
        tracemalloc.stop()
    assert alive() == scenes


def test_what_apps_shared_is_freed_with_the_last(first):
    held = alive()
    second = played()
    first.close()
    assert alive() == held
    second.close()
    del second
    gc.collect()
    assert alive() < held
