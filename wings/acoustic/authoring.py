"""Acoustic: one acoustic sensor prim, created or wrapped, with its attributes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sensors.sensor_prim import SensorPrim

from .config import AcousticConfig, read_config
from .names import API, AUX_LEVELS, GROUP_API, GROUP_PREFIX, MOUNT_API, MOUNT_PREFIX, PRIM_TYPE

SUPPORTED_ACOUSTIC_CONFIGS: dict[str, list[Any]] = {}
"""Shipped configurations: none, as in Isaac Sim."""


class Acoustic(SensorPrim):
    """Wraps the acoustic sensor prim at a path, or creates a missing one.

    path: a prim path, or a regular expression that matches one prim. aux_output_level: NONE or BASIC; tick_rate [Hz]
    writes omni:sensor:tickRate; None leaves either as the prim has it. schemas: API schemas to apply, "Name" or
    "Name:instance". attributes: name to value; they replace the arguments; names of further mounts and receiver groups
    bring their schema, those of firing sequences do not; an attribute that the prim does not have is skipped with a
    warning. positions (world) or translations (local), orientations w, x, y, z, scales: shape (n,) or (1, n), stage
    units. app: None is the App entered last. Raises SensorValueError (a UserError and a ValueError).
    """

    prim_type = PRIM_TYPE
    schema = API
    aux_levels = AUX_LEVELS
    word = "acoustic sensor"

    @property
    def config(self) -> AcousticConfig:
        """The configuration that the prim describes now."""
        return read_config(self.prim)

    def implied_schemas(self, attributes: Iterable[str]) -> list[str]:
        """Mounts and receiver groups that attribute names bring with them."""
        found = {
            f"{schema}:{name.removeprefix(prefix).split(':')[0]}"
            for name in attributes
            for prefix, schema in ((MOUNT_PREFIX, MOUNT_API), (GROUP_PREFIX, GROUP_API))
            if name.startswith(prefix)
        }
        return sorted(found)

    def attribute_kind(self, name: str) -> str | None:
        """USD value type of an attribute that the prim has, by its full name; None for others."""
        attribute = self.prim.GetAttribute(name)
        return str(attribute.GetTypeName()) if attribute else super().attribute_kind(name)
