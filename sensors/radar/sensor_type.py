"""What radars are to the rest of TickGraph: their registration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.exact import shortest
from sensors.annotators.outputs import empty_outputs, extract_point_cloud
from sensors.annotators.types import AnnotatorType, Reading, with_info
from sensors.channels import CHANNELS, Channel
from sensors.prim import read_tick_rate, reading_problems
from sensors.sensor_types import SensorType, register_sensor_type

from .configs import author_config
from .names import AUX_LEVELS, MODALITY, PRIM_TYPE
from .prim import read_config

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.view import WorldView

    from .runtime import RadarRuntime

CHANNEL_NAMES = ("xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs", "flags", "rv_ms")
BOUNCES = Channel("bounces", np.dtype("u1"), doc="faces that the wave met on its way, from 1; 0: a false alarm; ours")


def _runtime(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> RadarRuntime:
    from .runtime import RadarRuntime

    return RadarRuntime(scene, prim_path, resolution)


def _check(prim: Usd.Prim) -> Iterator[str]:
    return reading_problems(prim, read_config, read_tick_rate)


def _facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    config = read_config(prim)
    scans = [
        {
            "name": scan.name,
            "rays": int(np.prod(scan.grid(scene.fidelity.radar_rays))),
            "range_cells": scan.ranges().count,
            "velocity_cells": [scan.velocities(limit).count for limit in scan.cycles],
            "azimuth_cells": scan.azimuths().count,
            "elevation_cells": scan.heights().count,
        }
        for scan in config.scans
    ]
    return {"tick_rate_hz": read_tick_rate(prim), "cfar": config.cfar_mode, "scans": scans}


def _blind(scene: WorldView, prim: Usd.Prim) -> str:
    """Says that the knob radar.rays gives a scan fewer rays than its attribute asks for."""
    rays = scene.fidelity.radar_rays
    for scan in read_config(prim).scans:
        across, _ = scan.grid(rays)
        dense = across / (2.0 * scan.max_az_ang_deg)
        if rays and dense < scan.rays_per_deg:
            return (
                f"Its scan {scan.name} has {dense:.2g} rays per degree by radar.rays={rays}, where raysPerDeg asks for "
                f"{scan.rays_per_deg:g}: give radar.rays more, or leave it out"
            )
    return ""


def _rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    yield "rates", f"tick {shortest(facts['tick_rate_hz'])} Hz, one scan a frame"
    for scan in facts["scans"]:
        velocities = " or ".join(f"{count}" for count in dict.fromkeys(scan["velocity_cells"]))
        yield (
            f"scan {scan['name']}",
            f"{scan['rays']:,} rays; cells: {scan['range_cells']} of range, {velocities} of velocity, "
            f"{scan['azimuth_cells']} of azimuth, {scan['elevation_cells']} of elevation; CFAR {facts['cfar']}",
        )


CLOUD = ("data", "azimuth", "elevation", "distance", "intensity", "timestamp", "radialVelocityMS")


def _point_cloud(reading: Reading) -> dict[str, Any]:
    frame, found = reading.frame, empty_outputs(CLOUD)
    if frame is not None:
        found |= extract_point_cloud(frame)
    found["rcs"] = found["intensity"] if reading.options["outputIntensity"] else found.pop("intensity")
    told = with_info(found, reading)
    if frame is not None:
        told["info"] |= {**frame.facts, "numDetections": frame.count}
    return told


ANNOTATORS = (
    AnnotatorType(
        "IsaacCreateRTXRadarPointCloud",
        _point_cloud,
        lambda reading: ("xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs"),
        options=dict.fromkeys(("outputIntensity", "outputTimestamp", "outputRadialVelocityMS"), False),
        optional=True,
        modality=MODALITY,
    ),
)
"""Points [m] as "data", "rcs" [dBsm], "radialVelocityMS" at level BASIC, angles, distances and times, whatever the
options; with outputIntensity "rcs" as "intensity", too. "info" also has the scan, its cycle and its limits.
"""


register_sensor_type(
    SensorType(
        PRIM_TYPE,
        _runtime,
        modality=MODALITY,
        channels=(*(CHANNELS[name] for name in CHANNEL_NAMES), BOUNCES),
        annotators=ANNOTATORS,
        aux_levels=AUX_LEVELS,
        check=_check,
        author=author_config,
        facts=_facts,
        rows=_rows,
        blind=_blind,
    )
)
