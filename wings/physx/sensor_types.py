"""PhysX sensors as sensor types."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.base.exact import shortest
from sensors.sensor_types import SensorType

from .names import BEAM_CHANNELS, BEAM_TIME, LIDAR, LIGHT_BEAM

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView


def _lidar(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> Sensor:
    from .lidar import PhysxLidarRuntime

    return PhysxLidarRuntime(scene, prim_path, resolution)


def _light_beam(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> Sensor:
    from .light_beam import LightBeamRuntime

    return LightBeamRuntime(scene, prim_path, resolution)


def _lidar_facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    from .lidar import read_config

    config = read_config(prim)
    return {"rotation_rate_hz": config.rotation_rate, "rows": config.rows, "columns": config.columns}


def _lidar_rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    rate = facts["rotation_rate_hz"]
    yield "rates", f"turns at {shortest(rate)} Hz" if rate else "all beams at once"
    yield "rays", f"{facts['columns']:,} x {facts['rows']:,} a scan (columns x rows)"


def _beam_facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    from .light_beam import read_config

    config = read_config(prim)
    return {"beams": config.count, "range_m": list(config.ranges)}


def _beam_rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    nearest, farthest = facts["range_m"]
    yield "rays", f"{facts['beams']:,}, {nearest:g} to {farthest:g} m"


def _problems(facts: Callable[[Any, Usd.Prim], Any]) -> Callable[[Usd.Prim], Iterator[str]]:
    def check(prim: Usd.Prim) -> Iterator[str]:
        try:
            facts(None, prim)
        except UserError as error:
            yield str(error)

    return check


LIDAR_TYPE = SensorType(
    LIDAR,
    _lidar,
    channels=(*BEAM_CHANNELS, BEAM_TIME),
    check=_problems(_lidar_facts),
    facts=_lidar_facts,
    rows=_lidar_rows,
    read_by="IsaacReadLidarPointCloud or IsaacReadLidarBeams",
)
LIGHT_BEAM_TYPE = SensorType(
    LIGHT_BEAM,
    _light_beam,
    channels=BEAM_CHANNELS,
    check=_problems(_beam_facts),
    facts=_beam_facts,
    rows=_beam_rows,
    read_by="IsaacReadLightBeam",
)
