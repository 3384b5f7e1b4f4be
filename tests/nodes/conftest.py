"""A small world for nodes that need one."""

import pytest


@pytest.fixture
def stage():
    """An empty stage, metres, Z up."""
    from graph.sim.stage import open_stage

    return open_stage(None)


@pytest.fixture
def world(stage):
    """A function that opens an App on `stage` with a memory sink subscribed; closed after the test."""
    from graph.sim import App
    from graph.sim.bus import MemorySink

    opened = []

    def open_world(**options):
        app = App(stage, **options)
        opened.append(app)
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        return app

    yield open_world
    for app in opened:
        app.close()
