"""What a radar costs: whole App updates against the bare casts that they contain."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from measure import Median, Row, added, ratio

from graph.sim import App
from graph.sim.settings import RAY_THREADS
from sensors import render_product
from sensors.radar.runtime import RadarRuntime
from sensors.raycast.rays import RayBundle
from sensors.raycast.world import CastWorld

TITLE = "Radar: 384,000 rays, a hall with 40 boxes of three materials"
CAR = "/World/Car"
RADAR = f"{CAR}/Radar"
YARD = Path(__file__).parents[2] / "graphs" / "yard.yaml"
SPEED = 2.0
CHANNELS = ("azimuth", "elevation", "distance", "scalar", "rv_ms")

WPM = "omni:sensor:WpmDmat:"
SCAN = f"{WPM}scan:s001:"
WAVES = {f"{SCAN}datacubeMode": "WAVEFORM"}
NOISE = {f"{SCAN}cfarNoiseMean": 1e-19, f"{SCAN}cfarNoiseSDev": 1e-19}
GAIN = {"AntennaAzDeg": [-90.0, 0.0, 90.0], "AntennaElDeg": [0.0, 0.0, 0.0], "AntennaCoGain": [-20.0, 0.0, -20.0]}
KNOBS: dict[str, dict[str, Any]] = {
    "cfarMode 4D": {f"{WPM}cfarMode": "4D"},
    "noise in cells": NOISE,
    "noise in cells, cfarMode 4D": {**NOISE, f"{WPM}cfarMode": "4D"},
    "WAVEFORM": WAVES,
    "WAVEFORM, 16 elements along azimuth": {**WAVES, f"{SCAN}arrayAzimuthElements": 16},
    "antennas by tables": {f"{SCAN}{side}{name}": values for side in ("rx", "tx") for name, values in GAIN.items()},
}
"""Attributes of the radar whose costs are shown."""


def hall(speed: float = 0.0, attributes: dict[str, Any] | None = None, kind: str = "Cube") -> dict[str, dict[str, Any]]:
    """Rough ground, a wall 48 m away, boxes in between, and the radar; it drives if it has a speed [m/s].

    attributes: more of the radar's. kind: what stands there instead of boxes.
    """
    random = np.random.default_rng(0)
    prims: dict[str, dict[str, Any]] = {"/World/Ground": {"type": "Plane", "material": "asphalt"}}
    for number in range(40):
        azimuth, distance = np.radians(random.uniform(-70, 70)), random.uniform(5, 45)
        prims[f"/World/Box{number}"] = {
            "type": kind,
            **({"size": 1.0} if kind == "Cube" else {"radius": 0.5}),
            "scale": random.uniform(0.3, 3, 3).tolist(),
            "translate": [float(distance * np.cos(azimuth)), float(distance * np.sin(azimuth)), 0.5],
            "rotate": [0, 0, float(random.uniform(0, 90))],
            "material": ("concrete", "steel", "wood")[number % 3],
        }
    wall = {"type": "Cube", "size": 1.0, "scale": [1, 100, 10], "translate": [48, 0, 5], "material": "concrete"}
    prims["/World/Wall"] = wall
    # Without gravity and contact the car keeps its speed.
    prims["/World/Physics"] = {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}
    prims[CAR] = {"type": "Cube", "size": 0.1, "translate": [0, 0, 1]}
    if speed:
        prims[CAR] |= {"rigid_body": True, "velocity": [speed, 0, 0]}
    prims[RADAR] = {
        "type": "OmniRadar",
        "exclude": [CAR],
        "attributes": {"omni:sensor:tickRate": 60, **(attributes or {})},
    }
    return prims


def measure(quick: bool) -> Iterator[Row]:
    """A radar that renders in every update: while it drives, and while nothing moves.

    The casts are those of an update in which everything is cast; where nothing moves, none is made.
    """
    rounds = 1 if quick else 41
    for name, fidelity in (("all bounces", {}), ("radar.bounces=1", {"radar.bounces": 1})):
        with _world(hall(SPEED), fidelity) as app:
            casts = _casts_of(app)
            what = f"an update with a frame, driving, {name} / its casts"
            yield Row(what, ratio(app.update, casts, rounds), 1.5)
            yield Row(f"{what}, processor time", ratio(app.update, casts, rounds, clock=time.process_time))
            standing = _world(hall(), fidelity)
            yield Row(f"the same where nothing moves, {name}", ratio(standing.update, casts, rounds), 1.5)
            standing.close()
    with _world(hall(SPEED, kind="Sphere"), {}) as app:
        what = "an update with a frame, driving, ellipsoids instead of boxes / its casts"
        yield Row(what, ratio(app.update, _casts_of(app), rounds))
    with _world(hall(SPEED), {}) as app:
        casts = _casts_of(app)
        for name, attributes in KNOBS.items():
            with _world(hall(SPEED, attributes), {}) as other:
                yield Row(
                    f"what {name} adds, in casts of a frame",
                    added(other.update, app.update, casts, max(1, rounds // 4)),
                )
    first, *frames = _yard(frames=3 if quick else 40)
    processor = Median([each * 1e3 for each, _ in frames[1:]])
    yield Row("the radar of the yard, a steady frame, processor time", processor, 75.0, "ms")
    yield Row("its first frame after a lidar's, loops compiled, processor time", first[0] * 1e3, 1000.0, "ms")
    yield Row("processor time of all threads / of its own, rays on one", Median([a / b for a, b in frames[1:]]), 1.05)


def _world(prims: dict[str, dict[str, Any]], fidelity: dict[str, Any]) -> App:
    app = App(None, physics_hz=60, loop_hz=60, fidelity=fidelity)
    app.add_prims(prims)
    render_product(app, RADAR).sensor.require("benchmark", CHANNELS, ignore_aux=True)
    app.play()
    app.update(steps=4)
    return app


def _yard(frames: int) -> list[tuple[float, float]]:
    """Processor time [s] of frames of the yard's radar, whose robot drives, and of the thread that casts all rays.

    What other libraries do on threads of their own, as BLAS does, shows as a difference, however loaded the machine is.
    """
    times: list[tuple[float, float]] = []
    with App.from_file(YARD) as app:
        app.settings.set(RAY_THREADS, 1)
        lidar, sensor = (render_product(app, f"/World/Robot/Chassis/{name}").sensor for name in ("top_lidar", "radar"))
        assert isinstance(sensor, RadarRuntime)
        lidar.require("benchmark", ("distance",), ignore_aux=True)
        app.play()
        app.update(steps=4)  # Numba, Open3D and the scene's triangles are there
        sensor.require("benchmark", CHANNELS, ignore_aux=True)
        measure = sensor.measure

        def timed(tick: Any) -> Any:
            before = time.process_time(), time.thread_time()
            found = measure(tick)
            times.append((time.process_time() - before[0], time.thread_time() - before[1]))
            return found

        sensor.measure = timed  # type: ignore[method-assign]
        while len(times) < frames:
            app.update()
    return times


def _casts_of(app: App) -> Any:
    """What casts the rays of one update again."""
    made: list[tuple[CastWorld, RayBundle, Any, bool]] = []
    cast = CastWorld.cast

    def noted(
        self: CastWorld, rays: RayBundle, poses: Any = None, *, normals: bool = False, spots: bool = False
    ) -> Any:
        table, offsets = rays.table.copy(), None if rays.offsets is None else rays.offsets.copy()
        made.append((self, RayBundle(rays.origin, table, offsets, rays.exclude, rays.reach), poses, normals))
        return cast(self, rays, poses, normals=normals, spots=spots)

    CastWorld.cast = noted  # type: ignore[method-assign]
    try:
        app.update()
    finally:
        CastWorld.cast = cast  # type: ignore[method-assign]

    def again() -> None:
        for world, rays, poses, normals in made:
            world.cast(rays, poses, normals=normals)

    return again
