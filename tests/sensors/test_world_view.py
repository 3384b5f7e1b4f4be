"""Sensors see their world alone: what they need comes with the tick, and nothing that they hold leads to an App."""

import gc
from types import FunctionType, ModuleType

import numpy as np
import pytest

from graph.sim import App
from graph.sim.phases import Subscribers
from graph.sim.renderer.products import RenderProduct
from graph.sim.settings import Settings
from sensors.raycast import shared
from tests.support.places import ROOT

OTHERS = (Subscribers, Settings, RenderProduct, ModuleType, type)
"""What calls others back: nodes, writers and subscribers, which may hold the App."""


def reached_from(start):
    """Everything to which an object refers, directly or through others, but for what is behind `OTHERS`."""
    found, waiting = {id(start): start}, [start]
    while waiting:
        one = waiting.pop()
        for other in gc.get_referents(one):
            is_code = isinstance(one, FunctionType) and other is one.__globals__
            if id(other) not in found and not is_code and not isinstance(other, OTHERS):
                found[id(other)] = other
                waiting.append(other)
    return list(found.values())


@pytest.mark.parametrize("motion", ["frozen", "continuous"])
def test_a_sensor_that_has_measured_leads_to_its_world_and_to_no_app(motion):
    with App.from_file(ROOT / "graphs" / "yard.yaml", fidelity={"lidar.motion": motion}) as app:
        app.play()
        app.update(12)
        sensors = [product.sensor for product in app.rendering.products.values()]
        assert {type(sensor).__name__ for sensor in sensors} == {"LidarRuntime", "RadarRuntime", "CameraRuntime"}
        for sensor in sensors:
            reached = reached_from(sensor)
            assert any(one is app.world for one in reached)
            assert not any(isinstance(one, App) for one in reached)


def test_a_scan_resolves_what_it_casts_against_once(monkeypatch):
    """Ten whole scans a second, so one in six updates."""
    resolved, cast_world = [], shared.cast_world
    monkeypatch.setattr("sensors.lidar.scans.cast_world", lambda scene: resolved.append(scene) or cast_world(scene))
    with App.from_file(ROOT / "graphs" / "lidar_point_cloud.yaml") as app:
        app.play()
        app.update()
        [product] = app.rendering.products.values()
        product.sensor.require("test", {"distance", "matId", "velocities"}, ignore_aux=True)
        app.update(59)
        assert product.frames == 10
        assert resolved == [app.world] * 10


def test_what_was_made_of_the_geometry_ends_with_it():
    with App() as app:
        app.add_prims({"/Wall": {"type": "Cube", "translate": [5, 0, 0]}})
        app.play()
        first = shared.cast_world(app.world)
        assert shared.cast_world(app.world) is first
        np.testing.assert_array_equal(shared.surface_ids(first), shared.surface_ids(first))
        app.forget_geometry()
        assert shared.cast_world(app.world) is not first
        app.stop()
        assert app.world.derived == {}
