"""How far a radar's rays are from what many more of them give: `python tests/benchmarks/converge_radar.py [SCENE...]`.

The reference follows every ray of a fan with several times as many rays. A cell is detected if it has more power than
its neighbours, so a small difference in power changes which cells are detected: the distance in power is printed, too.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from bench_radar import RADAR, SPEED, YARD, hall

from graph.sim import App
from graph.sim.renderer.schedule import Tick
from sensors import render_product
from sensors.radar.antenna import Antenna
from sensors.radar.cube import Cube
from sensors.radar.detector import Detections, detections, range_velocity
from sensors.radar.noise import Noise
from sensors.radar.rays import Sampling
from sensors.radar.runtime import RadarRuntime
from sensors.radar.scans import Scans

SCENES = {"yard": 16, "hall": 4, "driving": 4}
"""Scene -> how many times as many rays its reference has."""

BEFORE = Sampling(stride=2, share=4, neighbours=False)
SETTINGS = {
    "as before: stride 2, share 4": BEFORE,
    "the default: stride 2, share 8": Sampling(),
    "share 16": replace(Sampling(), share=16),
    "a ray for each sight": replace(Sampling(), neighbours=False),
    "stride 1": replace(Sampling(), stride=1),
    "stride 3": replace(Sampling(), stride=3),
    "rays / 2": replace(Sampling(), rays=2),
    "rays / 4": replace(Sampling(), rays=4),
}
"""What is measured; the rays of these are what the default's are divided by."""


@dataclass(frozen=True)
class Seen:
    """What a sampling brings of one state: its cube, detections, and the processor time of its second frame [s]."""

    cube: Cube
    detections: Detections
    seconds: float


@dataclass(frozen=True)
class Distance:
    """How far a sampling is from a reference.

    overlap: power that both have in the same cells of range and velocity, of that of the reference. decibels: median
    difference in cells that either detects in. recall, precision: of detections within a cell; rcs: median difference
    of their cross sections [dB].
    """

    overlap: float
    decibels: float
    recall: float
    precision: float
    rcs: float


def playing(scene: str) -> tuple[App, RadarRuntime, Tick]:
    """A scene after some frames, its radar, and the tick of the last."""
    if scene == "yard":
        app, path, frames = App.from_file(YARD), "/World/Robot/Chassis/radar", 6
    else:
        app, path, frames = App(None, physics_hz=60, loop_hz=60), RADAR, 30
        app.add_prims(hall(SPEED if scene == "driving" else 0.0))
    sensor = render_product(app, path).sensor
    assert isinstance(sensor, RadarRuntime)
    ticks: list[Tick] = []
    measure = sensor.measure

    def noted(tick: Tick) -> Any:
        ticks.append(tick)
        return measure(tick)

    sensor.measure = noted  # type: ignore[method-assign]
    sensor.require("convergence", ("distance",), ignore_aux=True)
    app.play()
    while len(ticks) < frames:
        app.update()
    return app, sensor, ticks[-1]


def seen(sensor: RadarRuntime, tick: Tick, sampling: Sampling) -> Seen:
    """What a sampling brings."""
    scan, scans, pose = sensor.config.scans[0], Scans(sensor, sampling), sensor.pose(tick.poses)
    antenna, cube = Antenna(scan.wavelength, scan.power_factor), scans.cube(tick, pose, 0, 0)
    begin = time.process_time()
    scans.cube(tick, pose, 0, 1)  # with other velocities, so that it is not kept
    seconds = time.process_time() - begin
    return Seen(cube, detections(cube, scan, antenna, Noise(0, sensor.path, 0), four=False), seconds)


def distance(reference: Seen, other: Seen) -> Distance:
    """How far one is from the reference."""
    grid = reference.cube.grid
    first, second = range_velocity(reference.cube), range_velocity(other.cube)
    cells = np.zeros(first.shape, bool)
    for one in (reference.detections, other.detections):
        places = [(one.range_m, grid.range_m), (one.velocity, grid.velocity)]
        at = [np.clip((value - axis.low) / axis.width, 0, axis.count - 1).astype(int) for value, axis in places]
        cells[tuple(at)] = True
    decibels = 10.0 * np.log10(np.maximum(second[cells], 1e-22) / np.maximum(first[cells], 1e-22))
    wanted, found = reference.detections, other.detections
    free, gaps = np.ones(len(found.rcs), bool), []
    for row in np.argsort(-wanted.rcs):
        away = np.stack(
            [
                np.abs(found.range_m - wanted.range_m[row]) / grid.range_m.width,
                np.abs(found.velocity - wanted.velocity[row]) / grid.velocity.width,
                np.abs(np.sin(found.azimuth) - np.sin(wanted.azimuth[row])) / grid.azimuth.width,
            ]
        ).max(axis=0, initial=0.0)
        near = np.flatnonzero(free & (away < 1.0))
        if len(near):
            best = near[np.argmin(away[near])]
            free[best] = False
            gaps.append(abs(found.rcs[best] - wanted.rcs[row]))
    return Distance(
        float(np.minimum(first, second).sum() / first.sum()),
        float(np.median(np.abs(decibels))),
        len(gaps) / max(len(wanted.rcs), 1),
        len(gaps) / max(len(found.rcs), 1),
        float(np.median(gaps)) if gaps else np.nan,
    )


def main(scenes: list[str]) -> None:
    """Prints the distance of each setting in each scene."""
    for scene in scenes or SCENES:
        app, sensor, tick = playing(scene)
        across, up = sensor.config.scans[0].grid(None)
        dense = SCENES[scene] * across * up
        reference = seen(sensor, tick, Sampling(dense, stride=1, neighbours=False))
        print(f"{scene}: {across * up:,} rays, reference {dense:,}, {len(reference.detections.rcs)} detections")
        print(f"  {'':32} overlap  cells dB  recall  precision  RCS dB  ms")
        halved = {"half of the reference, stride 1": Sampling(dense // 2, stride=1, neighbours=False)}
        chosen = {name: replace(one, rays=across * up // (one.rays or 1)) for name, one in SETTINGS.items()}
        for name, sampling in (halved | chosen).items():
            other = seen(sensor, tick, sampling)
            one = distance(reference, other)
            print(
                f"  {name:32} {one.overlap:7.3f} {one.decibels:9.2f} {one.recall:7.2f} {one.precision:10.2f} "
                f"{one.rcs:7.2f} {other.seconds * 1e3:4.0f}",
                flush=True,
            )
        app.close()


if __name__ == "__main__":
    main(sys.argv[1:])
