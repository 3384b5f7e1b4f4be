"""Radar: one radar prim, created or wrapped, with its attributes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError
from graph.sim import settings as keys
from sensors.sensor import PointSensor
from sensors.sensor_prim import SensorPrim, check_type, resolve

from .config import RadarConfig, ScanConfig
from .configs import author_config
from .names import API, AUX_LEVELS, PREFIX, PRIM_TYPE, SCAN_API, SCAN_PREFIX, attribute_name
from .prim import read_config
from .runtime import RadarRuntime

if TYPE_CHECKING:
    from pxr import Usd


class MotionBvhOff(RunError, RuntimeError):  # noqa: N818  (it names what happened)
    """A radar cannot be created while Motion BVH is off, where that is required."""


class Radar(SensorPrim):
    """Wraps the radar prim at a path, or creates a missing one.

    path: a prim path, or a regular expression that matches one prim. aux_output_level: NONE or BASIC; tick_rate [Hz]
    writes omni:sensor:tickRate; None leaves either as the prim has it. schemas: API schemas to apply, "Name" or
    "Name:instance". attributes: name to value; they replace the arguments; names of further scan configurations bring
    their schema; an attribute that the prim does not have is skipped with a warning. positions (world) or translations
    (local), orientations w, x, y, z, scales: shape (n,) or (1, n), stage units. app: None is the App entered last.
    Raises SensorValueError (a UserError and a ValueError), and MotionBvhOff (a RuntimeError) where a radar is created
    while the setting /tickgraph/radarNeedsMotionBvh is on and /renderer/raytracingMotion/enabled is off.
    """

    prim_type = PRIM_TYPE
    schema = API
    aux_levels = AUX_LEVELS
    word = "radar"

    @property
    def config(self) -> RadarConfig:
        """The configuration that the prim describes now."""
        return read_config(self.prim)

    def check_creation(self) -> None:
        """Raises MotionBvhOff where Motion BVH is required and off."""
        settings = self.scene.settings
        if settings.get(keys.RADAR_NEEDS_MOTION_BVH) and not settings.get(keys.MOTION_BVH, False):
            raise MotionBvhOff(
                f"{self.path}: a radar needs Motion BVH; set {keys.MOTION_BVH} to true before it is created, or "
                f"{keys.RADAR_NEEDS_MOTION_BVH} to false"
            )

    @classmethod
    def write_config(cls, stage: Usd.Stage, path: str, config: str, variant: Any) -> None:
        """Authors a shipped configuration on the prim at a path."""
        path, existed = resolve(stage, path, cls.word)
        prim = stage.GetPrimAtPath(path) if existed else cls.define(stage, path)
        check_type(prim, PRIM_TYPE)
        author_config(prim, config, variant)

    def implied_schemas(self, attributes: Iterable[str]) -> list[str]:
        """Scan configurations that attribute names bring with them."""
        instances = {
            name.removeprefix(SCAN_PREFIX).split(":")[0] for name in attributes if name.startswith(SCAN_PREFIX)
        }
        return [f"{SCAN_API}:{instance}" for instance in sorted(instances)]

    def attribute_kind(self, name: str) -> str | None:
        """USD value type of an attribute that radars have, by its full name; None for others."""
        if name.startswith(SCAN_PREFIX):
            return _kinds(ScanConfig).get(name.rpartition(":")[2])
        return _kinds(RadarConfig).get(name.removeprefix(PREFIX)) or super().attribute_kind(name)


def _kinds(kind: type[Any]) -> dict[str, str]:
    """Attribute -> USD value type of the fields of a configuration."""
    types = {bool: "bool", int: "uint", float: "float", str: "token", tuple: "float[]"}
    fields = [one for one in dataclasses.fields(kind) if one.name not in ("name", "scans", "without_effect")]
    return {attribute_name(one.name): types[type(one.default)] for one in fields}


class RadarSensor(PointSensor[Radar, RadarRuntime]):
    """Renders a radar: `RadarSensor(radar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Radar

    @property
    def radar(self) -> Radar:
        """The Radar."""
        return self.authoring_object
