"""Every way of driving an App gives the same frames, to the last byte and stamp."""

from __future__ import annotations

import asyncio

import pytest

import sensors.replicator as rep
from graph.sim import App
from sensors import Lidar, LidarSensor, parse_generic_model_output_data

GMO = "generic-model-output"
UPDATES = 24
PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Wall": {"type": "Cube", "size": 2, "translate": [6, 0, 1], "rotate": [0, 0, 17]},
    "/World/Ball": {
        "type": "Sphere", "radius": 0.4, "translate": [3, 0, 1.4], "rigid_body": True, "velocity": [0.5, 1, 0],
    },
}  # fmt: skip


async def _awaited(app):
    for _ in range(UPDATES):
        await app.next_update_async()


async def _stepped(app):
    for _ in range(UPDATES):
        await app.orchestrator.step_async()


async def _stepped_on(app):
    for _ in range(UPDATES):
        await app.orchestrator.step_async(pause_timeline=False)


async def _two_waiting(app):
    """Two coroutines that wait for every update share it."""
    await asyncio.gather(_awaited(app), _awaited(app))


async def _mixed(app):
    """A coroutine that waits while another runs updates itself."""

    async def runs():
        for _ in range(UPDATES):
            app.update()
            await asyncio.sleep(0)

    await asyncio.gather(_awaited(app), runs())


DRIVERS = {
    "update(n)": lambda app: app.update(UPDATES),
    "update": lambda app: [app.update() for _ in range(UPDATES)],
    "update_app": lambda app: app.update_app(steps=UPDATES),
    "next_update_async": lambda app: asyncio.run(_awaited(app)),
    "next_update_async, two tasks": lambda app: asyncio.run(_two_waiting(app)),
    "next_update_async beside update": lambda app: asyncio.run(_mixed(app)),
    "update_app_async": lambda app: asyncio.run(app.update_app_async(steps=UPDATES)),
    "orchestrator.step": lambda app: [app.orchestrator.step() for _ in range(UPDATES)],
    "orchestrator.step, playing on": lambda app: [app.orchestrator.step(pause_timeline=False) for _ in range(UPDATES)],
    "orchestrator.step_async": lambda app: asyncio.run(_stepped(app)),
    "orchestrator.step_async, playing on": lambda app: asyncio.run(_stepped_on(app)),
}


def run(drive, **options):
    """What two lidars deliver, and the clocks at the end."""
    with App(physics_hz=240, loop_hz=60, **options) as app:
        app.add_prims(PRIMS)
        log = []
        for path, rate in (("/World/Lidar", 10.0), ("/World/Slices", 0.0)):
            options = {"tick_rate": rate, "translations": [0, 0, 1], "aux_output_level": "BASIC"}
            lidar = Lidar.create(path, config="Example_Rotary_2D", app=app, **options)
            sensor = LidarSensor(lidar, annotators=[GMO])
            product = next(each for each in app.rendering.products.values() if each.camera_path == path)
            product.writers.append(lambda frame, sensor=sensor: log.append(bytes(sensor.get_data(GMO)[0])))
        app.play()
        drive(app)
        app.deliver_frames()
        return log, app.update_index, app.simulation.time, app.timeline.current_time, app.loop_time


@pytest.fixture(scope="module")
def reference():
    return {parity: run(DRIVERS["update(n)"], parity=parity) for parity in ("documented", "isaacsim-6.0.1")}


@pytest.mark.parametrize("driver", [name for name in DRIVERS if name != "update(n)"])
def test_all_drivers_give_identical_bytes_stamps_and_clocks(driver, reference):
    log, updates, *clocks = run(DRIVERS[driver])
    assert (updates, clocks) == (UPDATES, list(reference["documented"][2:]))
    assert log == reference["documented"][0]


@pytest.mark.parametrize("driver", ["next_update_async", "orchestrator.step", "orchestrator.step_async"])
def test_in_the_product_s_profile_too(driver, reference):
    """Frames arrive one update late there; the orchestrator fetches them, so they are the same frames in all."""
    log, updates, *clocks = run(DRIVERS[driver], parity="isaacsim-6.0.1")
    assert (updates, clocks) == (UPDATES, list(reference["isaacsim-6.0.1"][2:]))
    assert log == reference["isaacsim-6.0.1"][0]


def test_the_frames_are_worth_comparing(reference):
    log = [parse_generic_model_output_data(data) for data in reference["documented"][0]]
    whole = [gmo for gmo in log if gmo.scanComplete]
    assert [gmo.timestampNs for gmo in whole] == [0, 100_000_000, 200_000_000, 300_000_000]
    assert len(log) == UPDATES + 4
    assert all(gmo.numElements > 200 for gmo in whole)
    assert len(set(reference["documented"][0])) == len(log)


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_step_returns_after_the_attached_writers_fired(parity):
    with App(parity=parity) as app:
        app.add_prims(PRIMS)
        lidar = Lidar.create("/World/Lidar", config="Example_Rotary_2D", translations=[0, 0, 1], app=app)
        LidarSensor(lidar, annotators=[GMO])
        (product,) = app.rendering.products.values()
        seen = []
        product.writers.append(lambda frame: seen.append(frame.timestamp_ns))
        counts = []
        for _ in range(12):
            app.orchestrator.step()
            counts.append(len(seen))
        warm_up = {"documented": 0, "isaacsim-6.0.1": 2}[parity]
        assert counts == [(number + warm_up) // 6 for number in range(1, 13)]


def test_replicators_orchestrator_is_that_of_the_current_app():
    with App(), App() as app:
        rep.orchestrator.step()
        asyncio.run(rep.orchestrator.step_async(pause_timeline=False))
        assert (app.update_index, app.timeline.is_playing()) == (2, True)


def test_next_render_simulation_async_waits_for_n_frames_and_warns():
    with App() as app:
        app.add_prims(PRIMS)
        lidar = Lidar.create("/World/Lidar", config="Example_Rotary_2D", translations=[0, 0, 1], app=app)
        LidarSensor(lidar, annotators=[GMO])
        (product,) = app.rendering.products.values()
        app.play()
        asyncio.run(app.next_render_simulation_async([product.path], 3))
        assert (product.frames, app.update_index) == (3, 18)
        (warning,) = [each for each in app.warnings if each.code == "next-render-simulation-deprecated"]
        assert "update_app_async" in warning.message


@pytest.mark.parametrize("rate", [10.0, 0.0])
@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
def test_a_step_of_no_time_gives_a_whole_scan_of_the_world_as_it_stands(rate, motion):
    """Every lidar scans a whole turn at time 0, twice with the same hits, though no physics step was run."""
    with App(physics_hz=240, loop_hz=60, fidelity={"lidar.motion": motion}) as app:
        app.add_prims(PRIMS)
        options = {"tick_rate": rate, "translations": [0, 0, 1], "aux_output_level": "BASIC"}
        sensor = LidarSensor(
            Lidar.create("/World/Lidar", config="Example_Rotary_2D", app=app, **options), annotators=[GMO]
        )
        scans = []
        for _ in range(2):
            app.orchestrator.step(delta_time=0)
            scans.append(parse_generic_model_output_data(sensor.get_data(GMO)[0]))
        assert [(gmo.timestampNs, gmo.scanComplete) for gmo in scans] == [(0, True), (0, True)]
        assert scans[0].numElements == scans[1].numElements > 200
        assert (scans[0].z == scans[1].z).all()
        assert app.simulation.get_num_physics_steps() == 0
