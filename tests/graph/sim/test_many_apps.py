"""Many Apps in one process share what static scenes and profiles decide, and free it with the last of them."""

from __future__ import annotations

import gc
import sys
import weakref

import pytest

from graph.sim import App
from graph.sim.messages.bus import CountingSink
from sensors.raycast.triangles import alive
from tests.support.many_apps import further_app_mb
from tests.support.places import ROOT

YARD = str(ROOT / "graphs/yard.yaml")
MOST_MB = 40
"""A further App of the yard added 21 MB; 57 where each had its own planes and rays."""


@pytest.mark.skipif(sys.platform != "linux", reason="the size of the process is read in /proc")
def test_a_further_app_of_the_yard_adds_only_its_own_state():
    assert further_app_mb(YARD) < MOST_MB


def test_structures_are_shared_and_freed_with_the_last_app():
    def played():
        app = App.from_file(YARD)
        app.bus.subscribe(CountingSink())
        app.play()
        app.update(steps=7)  # every sensor has rendered
        return app

    gc.collect()
    none = alive()
    first = played()
    known = weakref.ref(first)
    one = alive() - none
    second = played()
    assert alive() - none < 2 * one
    first.close()
    del first
    gc.collect()
    assert known() is None
    assert alive() - none == one
    second.close()
    del second
    gc.collect()
    assert alive() == none
