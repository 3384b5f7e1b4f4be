"""Small worlds of the cases: an App that plays inline prims, and what its sensors see."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import App
from graph.sim.scene.stage import open_stage
from sensors.frame import Frame
from sensors.lidar.config import EmitterState, LidarConfig
from sensors.lidar.prim import write_config
from sensors.prim import write_aux_level
from sensors.products import render_product

from .case import refusal

Prims = Mapping[str, Mapping[str, Any]]

GRAVITY = 9.81
WEIGHTLESS: Prims = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
GROUND: Prims = {"/Ground": {"type": "Plane"}}
OFFSETS = (0.0, 1e3, 1e6, 1e8)
"""Distances from the origin along each axis [m]."""
SENSOR = "/Sensor"
NORMALS = "/app/sensors/nv/lidar/publishNormals"


@contextmanager
def playing(prims: Prims, hz: Any = 240, loop: Any = 60, stage: Any = None, **knobs: Any) -> Iterator[App]:
    """An App that plays these prims; knobs: of fidelity, with "_" for the first "."."""
    fidelity = {name.replace("_", ".", 1): value for name, value in knobs.items()}
    with App(stage, physics_hz=hz, loop_hz=loop, fidelity=fidelity, settings={NORMALS: True}) as app:
        app.add_prims(prims)
        app.play()
        yield app


def unplayable(prims: Prims, updates: int = 0, **options: Any) -> str:
    """The line with which these prims are refused, at play or within some updates; empty if they are not."""

    def play() -> None:
        with playing(prims, **options) as app:
            app.update(updates)

    return refusal(play)


def cube(size: float, place: Any, **keys: Any) -> dict[str, Any]:
    """A cube at a place [stage units]."""
    return {"type": "Cube", "size": size, "translate": [float(one) for one in place], **keys}


def body(size: float, place: Any, **keys: Any) -> dict[str, Any]:
    """A cube that is a rigid body."""
    return cube(size, place, rigid_body=True, **keys)


def ahead(place: Any, distance: float) -> Any:
    """(3,) so far along x from a place."""
    return np.asarray(place, float) + np.array([distance, 0.0, 0.0])


def mesh(points: Any, faces: Any, **keys: Any) -> dict[str, Any]:
    """A mesh of these faces."""
    return {"type": "Mesh", "points": np.asarray(points, float).tolist(), "faces": [*map(list, faces)], **keys}


def beams(azimuth: Any, elevation: Any = 0.0, **fields: Any) -> LidarConfig:
    """A lidar that sends all these beams [deg] at once, 10 times a second, from 0 to 10 km, without dropping a miss."""
    azimuth, elevation = np.broadcast_arrays(np.asarray(azimuth, float), np.asarray(elevation, float))
    fields = {"near_range_m": 0.0, "far_range_m": 1e4, "min_reflection_range_m": 1e4, "min_reflectance": 0.0, **fields}
    return LidarConfig(
        scan_type="SOLID_STATE",
        pattern_firing_rate_hz=Fraction(10),
        emitter_states=(EmitterState(azimuth_deg=azimuth, elevation_deg=elevation),),
        skip_dropping_invalid_points=True,
        **fields,
    )


def seen(kind: str, prims: Prims, channels: str, place: Any = (0, 0, 0), *, metre: float = 1.0, **keys: Any) -> Frame:
    """The newest frame, after a few updates, of a sensor of this type at a place [stage units].

    metre: in stage units. keys: `stage`, `config` of a lidar, `updates`; others are of the prim.
    """
    config, stage = keys.pop("config", None), keys.pop("stage", None) or open_stage()
    updates = keys.pop("updates", 6)
    stage.SetMetadata("metersPerUnit", 1 / metre)
    with App(stage, physics_hz=60, loop_hz=60, settings={NORMALS: True}) as app:
        app.add_prims({**prims, SENSOR: {"type": kind, "translate": [float(one) for one in place], **keys}})
        prim = app.stage.GetPrimAtPath(SENSOR)
        if config is not None:
            write_config(prim, config)
        write_aux_level(prim, "FULL")
        product = render_product(app, SENSOR, (16, 16))
        product.sensor.require("stability", set(channels.split()), ignore_aux=True)
        app.play()
        app.update(updates)
        if product.frame is None:
            raise RunError(f"no frame in {updates} updates")
        frame: Frame = product.frame
        return frame


def ranges(prims: Prims, azimuth: Any, elevation: Any = 0.0, place: Any = (0, 0, 0), **fields: Any) -> Any:
    """The ranges [m] of a lidar's beams."""
    return channel(seen("OmniLidar", prims, "distance", place, config=beams(azimuth, elevation, **fields)), "distance")


def channel(frame: Frame, name: str) -> Any:
    """A channel as float64."""
    return frame.channel(name).astype(np.float64)


def directions(azimuth: Any, elevation: Any = 0.0) -> Any:
    """(n, 3) unit vectors of angles [deg]."""
    a, e = np.radians(np.broadcast_arrays(np.asarray(azimuth, float), np.asarray(elevation, float)))
    return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)


def worst(found: Any, wanted: Any) -> float:
    """The largest difference; NaN if any is missing."""
    return float(np.abs(np.asarray(found) - wanted).max())
