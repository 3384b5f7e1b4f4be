"""What cameras are to the rest of TickGraph: their registration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.exact import shortest
from sensors.prim import read_tick_rate, reading_problems
from sensors.sensor_types import SensorType, register_sensor_type

from .annotators import ANNOTATORS
from .channels import CHANNELS
from .names import AUX_LEVELS, CROSS_CAMERA, MODALITY, PRIM_TYPE
from .noise import ATTRIBUTES

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.renderer.view import WorldView

    from .runtime import CameraRuntime

ANY_SIZE = (1280, 720)


def _runtime(scene: WorldView, prim_path: str, resolution: tuple[int, int]) -> CameraRuntime:
    from .runtime import CameraRuntime

    return CameraRuntime(scene, prim_path, resolution)


def _check(prim: Usd.Prim) -> Iterator[str]:
    from .config import read_config

    def read(prim: Usd.Prim) -> object:
        """Without its tables: which files may be read is known when the sensor is made."""
        return read_config(prim, ANY_SIZE, 1.0, tables=False)

    return reading_problems(prim, read, read_tick_rate)


def _author(prim: Usd.Prim, config: str, variant: Any = None, **where: Any) -> None:
    from sensors.configs.cameras import author_camera

    author_camera(prim, config, variant, **where)


def _facts(scene: WorldView, prim: Usd.Prim) -> dict[str, Any]:
    from .config import read_config
    from .lens_models import lens_model

    config = read_config(prim, ANY_SIZE, scene.meters_per_unit, scene.folders)
    return {
        "tick_rate_hz": read_tick_rate(prim),
        "lens": lens_model(prim) or "pinhole",
        "focal_length": config.focal_length,
        "horizontal_aperture": config.apertures[0],
        "clipping_m": [config.near, config.far],
    }


def _rows(facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    rate = facts["tick_rate_hz"]
    yield "rates", f"tick {shortest(rate)} Hz" if rate else "tick 0: every update"
    near, far = facts["clipping_m"]
    yield (
        "lens",
        f"{facts['lens']}, focal length {facts['focal_length']:g}, aperture {facts['horizontal_aperture']:g}, "
        f"shows {near:g} to {far:g} m",
    )


register_sensor_type(
    SensorType(
        PRIM_TYPE,
        _runtime,
        modality=MODALITY,
        channels=CHANNELS,
        annotators=ANNOTATORS,
        attributes={**ATTRIBUTES, CROSS_CAMERA: "string"},
        aux_levels=AUX_LEVELS,
        check=_check,
        author=_author,
        facts=_facts,
        rows=_rows,
    )
)
