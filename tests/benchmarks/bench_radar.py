"""What a radar costs: whole App updates against the bare casts that they contain."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from measure import Row, ratio

from graph.sim import App
from sensors import render_product
from sensors.raycast.rays import RayBundle
from sensors.raycast.world import CastWorld

TITLE = "Radar: 384,000 rays, a hall with 40 boxes of three materials"
RADAR = "/World/Radar"


def hall() -> dict[str, dict[str, Any]]:
    """Rough ground, a wall 48 m away, boxes in between, and the radar."""
    random = np.random.default_rng(0)
    prims: dict[str, dict[str, Any]] = {"/World/Ground": {"type": "Plane", "material": "asphalt"}}
    for number in range(40):
        azimuth, distance = np.radians(random.uniform(-70, 70)), random.uniform(5, 45)
        prims[f"/World/Box{number}"] = {
            "type": "Cube",
            "size": 1.0,
            "scale": random.uniform(0.3, 3, 3).tolist(),
            "translate": [float(distance * np.cos(azimuth)), float(distance * np.sin(azimuth)), 0.5],
            "rotate": [0, 0, float(random.uniform(0, 90))],
            "material": ("concrete", "steel", "wood")[number % 3],
        }
    wall = {"type": "Cube", "size": 1.0, "scale": [1, 100, 10], "translate": [48, 0, 5], "material": "concrete"}
    radar = {"type": "OmniRadar", "translate": [0, 0, 1], "attributes": {"omni:sensor:tickRate": 60}}
    return {**prims, "/World/Wall": wall, RADAR: radar}


def measure(quick: bool) -> Iterator[Row]:
    """A radar that renders in every update, and one that is not due."""
    rounds = 3 if quick else 11
    with App(None, physics_hz=60, loop_hz=60) as app:
        app.add_prims(hall())
        product = render_product(app, RADAR)
        product.sensor.require("benchmark", ["azimuth", "elevation", "distance", "scalar", "rv_ms"], ignore_aux=True)
        app.play()
        app.update(steps=2)
        casts = _casts_of(app)
        yield Row("an update with a frame, all bounces / its casts", ratio(app.update, casts, rounds))
    with App(None, physics_hz=60, loop_hz=60, fidelity={"radar.bounces": 1}) as app:
        app.add_prims(hall())
        product = render_product(app, RADAR)
        product.sensor.require("benchmark", ["azimuth", "elevation", "distance", "scalar", "rv_ms"], ignore_aux=True)
        app.play()
        app.update(steps=2)
        casts = _casts_of(app)
        yield Row("the same with radar.bounces=1", ratio(app.update, casts, rounds))


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
