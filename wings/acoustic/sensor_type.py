"""What acoustic sensors are to the rest of TickGraph: their sensor type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.exact import shortest
from sensors.channels import CHANNELS
from sensors.prim import read_tick_rate, reading_problems
from sensors.sensor_types import SensorType

from .config import read_config
from .names import AUX_LEVELS, MODALITY, OWN_CHANNELS, PRIM_TYPE

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.view import WorldView

    from .runtime import AcousticRuntime


def _runtime(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> AcousticRuntime:
    from .runtime import AcousticRuntime

    return AcousticRuntime(scene, prim_path, resolution)


def _check(prim: Usd.Prim) -> Iterator[str]:
    return reading_problems(prim, read_config, read_tick_rate)


def _facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    from .waves import SPEED_OF_SOUND

    config = read_config(prim)
    return {
        "tick_rate_hz": read_tick_rate(prim),
        "mounts": len(config.mounts),
        "signal_ways": len(config.ways),
        "samples_per_way": config.samples,
        "rays_per_mount": config.counts[0] * config.counts[1],
        "reach_m": SPEED_OF_SOUND * config.samples * config.sample_duration / 2,
    }


def _rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    rate = facts["tick_rate_hz"]
    yield "rates", f"tick {shortest(rate)} Hz" if rate else "tick 0: every update"
    yield (
        "signals",
        f"{facts['signal_ways']} of {facts['samples_per_way']} samples, mounts: {facts['mounts']}, "
        f"{facts['rays_per_mount']:,} rays each, to {facts['reach_m']:.3g} m",
    )


ACOUSTIC = SensorType(
    PRIM_TYPE,
    _runtime,
    modality=MODALITY,
    channels=(*OWN_CHANNELS, *(CHANNELS[name] for name in ("scalar", "timeOffsetNs", "flags"))),
    aux_levels=AUX_LEVELS,
    check=_check,
    facts=_facts,
    rows=_rows,
)
