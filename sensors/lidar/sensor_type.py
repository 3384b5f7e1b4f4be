"""The registration of lidars as a sensor type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.exact import shortest
from sensors.prim import read_tick_rate, reading_problems
from sensors.sensor_types import SensorType, register_sensor_type

from .annotators import ANNOTATORS
from .names import MODALITY, PRIM_TYPE
from .prim import read_config, write_config

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.view import WorldView

    from .runtime import LidarRuntime

RULES = {
    "whole": "tick = scan rate: whole scans, one a tick",
    "partial": "tick is not the scan rate: each update in which physics steps gives the firings since the last",
    "slices": "accumulateOutputs off: each update in which physics steps gives the firings since the last",
}


def _runtime(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> LidarRuntime:
    from .runtime import LidarRuntime

    return LidarRuntime(scene, prim_path, resolution)


def _check(prim: Usd.Prim) -> Iterator[str]:
    return reading_problems(prim, read_config, read_tick_rate)


def _author(prim: Usd.Prim, config: str, variant: Any = None, **where: Any) -> None:
    from sensors.configs.catalog import load

    write_config(prim, load(config, variant, **where))


def _facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    from graph.sim.settings import BARE_LIDAR_TICK_RATE

    from .pattern import firing_pattern

    config = read_config(prim)
    rays, rate = len(firing_pattern(config)), config.scan_rate_base_hz
    return {
        "tick_rate_hz": read_tick_rate(prim, scene.settings.rate(BARE_LIDAR_TICK_RATE)),
        "scan_rate_hz": rate,
        "accumulates": config.accumulate_outputs,
        "rays_per_scan": rays,
        "rays_per_second": rays * rate,
        "range_offset_m": config.range_offset_m,
        "noise": scene.fidelity.lidar_noise,
    }


def _rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    accumulates = "" if facts["accumulates"] else ", accumulateOutputs off"
    tick, scan = shortest(facts["tick_rate_hz"]), shortest(facts["scan_rate_hz"])
    yield "rates", f"tick {tick} Hz, scan {scan} Hz{accumulates}"
    rays, second = facts["rays_per_scan"], float(Fraction(facts["rays_per_second"]))
    yield "rays", f"{rays:,} a scan, {second:,.0f} a second at its scan rate"
    if offset := facts["range_offset_m"]:
        added = "added to ranges" if facts["noise"] else "not added: lidar.noise is off, so ranges are exact"
        yield "rangeOffsetM", f"{offset:g} m, {added}"


register_sensor_type(
    SensorType(
        PRIM_TYPE,
        _runtime,
        modality=MODALITY,
        example="config: Example_Rotary",
        annotators=ANNOTATORS,
        check=_check,
        author=_author,
        facts=_facts,
        rows=_rows,
        rules=RULES,
    )
)
