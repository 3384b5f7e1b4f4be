"""A closed App is freed with its last reference; opening and closing again and again keeps the memory."""

import gc
import weakref
from contextlib import contextmanager

import pytest

from graph import Controller
from graph.sim import App
from tests.support.without_wing import needs_wing

BALL = {"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 2], "rigid_body": True}}
SLACK = 25
"""Python objects that one cycle may leave: USD keeps a wrapper of each stage's layers, MuJoCo one of each model."""


@contextmanager
def no_collector():
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def ball(**options):
    app = App(**options)
    app.add_prims(BALL)
    return app


OPENED = {
    "empty": App,
    "a ball": ball,
    "a ball, Fabric off": lambda: ball(fidelity={"fabric": "off"}),
    "profile of the product": lambda: ball(parity="isaacsim-6.0.1"),
    "MJCF": lambda: App.from_file("graphs/arm.yaml"),
    "a lidar": lambda: App.from_file("graphs/quickstart.yaml"),
    "sixteen nodes, two lidars": lambda: App.from_file("graphs/yard.yaml"),
}


@pytest.mark.parametrize(
    "opened", [pytest.param(name, marks=needs_wing("mjcf")) if name == "MJCF" else name for name in OPENED]
)
def test_a_closed_app_goes_with_its_last_reference(opened):
    """Without the garbage collector: App, world, engine, Fabric and products."""
    with OPENED[opened]() as app:  # some libraries keep the frames of what has imported them, until they are collected
        app.play()
        app.update(12)
    del app
    with no_collector():
        app = OPENED[opened]()
        with app:
            app.play()
            app.update(12)
            parts = [app, app.world, app.fabric, app.simulation, app.rendering, app.timeline, app.driver, app.settings]
            parts += [part for part in (app.physics, app.live) if part is not None]
            parts += [product.sensor for product in app.rendering.products.values()]
        gone = [weakref.ref(part) for part in parts]
        names = [type(part).__name__ for part in parts]
        del app, parts
        assert [name for name, part in zip(names, gone, strict=True) if part() is not None] == []


def test_a_world_that_is_stopped_frees_its_engine_at_once():
    with no_collector(), ball() as app:
        app.play()
        app.update()
        engine, live = weakref.ref(app.physics), weakref.ref(app.live)
        app.stop()
        assert engine() is None
        assert live() is None


def test_two_hundred_apps_leave_nothing_behind():
    """Open, play, update, close: the collector never runs, and at most SLACK objects a cycle are left."""

    def cycle():
        with ball() as app:
            app.play()
            app.update(2)

    for _ in range(5):
        cycle()
    with no_collector():
        before = len(gc.get_objects())
        for _ in range(200):
            cycle()
        assert len(gc.get_objects()) - before < 200 * SLACK


def test_nodes_created_and_deleted_again_and_again_are_freed():
    """By the next update, which compiles the edits; the collector frees a node's few objects, which know each other."""
    keys = Controller.Keys
    with App() as app:
        app.play()
        Controller.edit({"graph_path": "/World/Sum"}, {keys.CREATE_NODES: [("kept", "ConstantDouble")]})

        def pairs(count):
            for _ in range(count):
                Controller.edit("/World/Sum", {keys.CREATE_NODES: [("node", "ConstantDouble")]})
                Controller.edit("/World/Sum", {keys.DELETE_NODES: ["node"]})

        pairs(100)
        gc.collect()
        before = len(gc.get_objects())
        pairs(2000)
        app.update()
        gc.collect()  # those that waited for the update are old
        assert len(gc.get_objects()) - before < 200
