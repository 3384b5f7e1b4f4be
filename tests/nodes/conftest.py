"""A small world for nodes that need one."""

import pytest


@pytest.fixture
def stage():
    """An empty stage, metres, Z up."""
    from graph.sim.scene.stage import open_stage

    return open_stage(None)


@pytest.fixture
def world(stage):
    """A function that opens an App on `stage` with a memory sink subscribed; closed after the test."""
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

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


@pytest.fixture
def lidar(stage):
    """A function that puts a lidar at the origin of `stage`, between walls 4 m ahead (+x) and 2 m to the left (+y)."""
    from pxr import UsdGeom

    from sensors.configs import author_config

    for name, place in (("Ahead", (5, 0, 0)), ("Left", (0, 3, 0))):
        wall = UsdGeom.Cube.Define(stage, f"/World/{name}")
        wall.GetSizeAttr().Set(2)
        wall.AddTranslateOp().Set(place)

    def make(config="Example_Rotary_2D", path="/World/Lidar", **attributes):
        prim = stage.DefinePrim(path, "OmniLidar")
        author_config(prim, config)
        for name, value in attributes.items():
            prim.GetAttribute(f"omni:sensor:{name.replace('__', ':')}").Set(value)
        return path

    return make
