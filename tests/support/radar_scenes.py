"""Radars in small scenes: what they receive of canonical targets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

import numpy as np

from graph.sim import App
from graph.sim.renderer.schedule import Tick
from sensors.prim import write_aux_level
from sensors.products import render_product

RADAR = "/World/Radar"
WPM = "omni:sensor:WpmDmat:"
SCAN = "omni:sensor:WpmDmat:scan:s001:"
NARROW = {f"{SCAN}maxAzAngDeg": 20.0, f"{SCAN}maxElAngDeg": 10.0}
"""A field of view with fewer rays, as dense as by default."""


@contextmanager
def radar_world(
    prims: Mapping[str, Any] = {},
    attributes: Mapping[str, Any] = {},
    *,
    fidelity: Mapping[str, Any] = {},
    seed: int = 0,
    path: str = RADAR,
    **keys: Any,
) -> Iterator[tuple[App, Any]]:
    """An App with a radar of 60 Hz and gain 1, and its product; keys as in a graph file."""
    authored = {"omni:sensor:tickRate": 60, f"{WPM}antennaGainMode": "CONSTANT", **NARROW, **attributes}
    with App(None, physics_hz=60, loop_hz=60, fidelity=dict(fidelity), seed=seed) as app:
        app.add_prims({**prims, path: {"type": "OmniRadar", "attributes": authored, **keys}})
        write_aux_level(app.stage.GetPrimAtPath(path), "BASIC")
        product = render_product(app, path)
        product.sensor.require("test", {"xyz", "azimuth", "elevation", "distance", "scalar", "rv_ms"}, ignore_aux=True)
        app.play()
        yield app, product


def received(prims: Mapping[str, Any], attributes: Mapping[str, Any] = {}, **options: Any) -> Any:
    """(cross sections (k,) [m^2], ranges (k,) [m], faces on the way (k,)) of the cells with power, strongest first.

    By the radar equation with gain 1, before the detector and the tuning of its cross sections.
    """
    with radar_world(prims, attributes, **options) as (app, product):
        runtime, tick = product.sensor, Tick(1, Fraction(60), Fraction(0))
        tick.scene = app.world
        cube = runtime.cube(tick)
        wavelength = runtime.config.wavelength
        sections = cube.power * (4 * math.pi) ** 3 * cube.values[0] ** 4 / wavelength**2
        order = np.argsort(-sections)
        return sections[order], cube.values[0][order], cube.bounces[order]


def threshold_factor(cells: int, false_alarms: float) -> float:
    """The factor that gives this false alarm rate in exponential noise, for the mean of this many training cells.

    N (Pfa^(-1/N) - 1): the mean of N exponential powers is gamma distributed.
    """
    return float(cells * (false_alarms ** (-1.0 / cells) - 1.0))


def dbsm(section: float) -> float:
    """[dBsm] of [m^2]."""
    return 10 * math.log10(section)


def plate(side: float, distance: float, tilt_deg: float = 0.0) -> dict[str, Any]:
    """A square plate whose front is at a distance on the x axis, turned about z."""
    box = {"type": "Cube", "size": 1.0, "scale": [1e-4, side, side], "translate": [distance + 5e-5, 0, 0]}
    return {"/World/Plate": {**box, "rotate": [0, 0, tilt_deg]}}


def trihedral(leg: float, distance: float) -> dict[str, Any]:
    """A triangular corner with its apex at a distance on the x axis, open towards the origin."""
    legs = [
        np.array([-math.sqrt(1 / 3), math.sqrt(2 / 3) * math.cos(turn), math.sqrt(2 / 3) * math.sin(turn)])
        for turn in (math.pi / 2 + 2 * math.pi / 3 * np.arange(3))
    ]
    apex = np.array([distance, 0.0, 0.0])
    points = [apex, *(apex + leg * one for one in legs)]
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1]]
    return {"/World/Corner": {"type": "Mesh", "points": [p.tolist() for p in points], "faces": faces}}


def dihedral(side: float, distance: float, turn_deg: float = 0.0) -> dict[str, Any]:
    """Two square plates at a right angle, edge along z, at a distance on the x axis, turned about the edge."""
    edge, up = np.array([distance, 0.0, 0.0]), np.array([0.0, 0.0, side / 2])
    ends = [
        edge + side * np.array([-math.cos(turn), math.sin(turn), 0.0])
        for turn in np.radians([45 + turn_deg, turn_deg - 45])
    ]
    points = [edge - up, edge + up, ends[0] - up, ends[0] + up, ends[1] - up, ends[1] + up]
    faces = [[0, 2, 3, 1], [1, 5, 4, 0]]
    return {"/World/Dihedral": {"type": "Mesh", "points": [p.tolist() for p in points], "faces": faces}}
