"""Shipped radar configurations: those that Isaac Sim knows by name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.suggest import did_you_mean
from sensors.errors import SensorValueError
from sensors.prim import apply_schemas, write

from .names import API, PREFIX, SCAN_PREFIX

if TYPE_CHECKING:
    from pxr import Usd

SUPPORTED_RADAR_CONFIGS: dict[str, list[Any]] = {
    "/Isaac/Sensors/TexasInstruments/IWRL6432AOP/IWRL6432AOP.usd": [],
}
"""Asset -> its variants."""

_VALUES: dict[str, dict[str, tuple[str, Any]]] = {
    # The asset's own values are not public. The band, 57 to 64 GHz, is that of the chip's data sheet: its middle is
    # 4.955 mm. The rest is estimated for a short-range sensor on its package's antennas.
    "IWRL6432AOP": {
        f"{PREFIX}waveLengthMm": ("float", 4.955),
        f"{SCAN_PREFIX}s001:maxRangeM": ("float", 25.0),
        f"{SCAN_PREFIX}s001:maxAzAngDeg": ("float", 70.0),
        f"{SCAN_PREFIX}s001:maxElAngDeg": ("float", 60.0),
        f"{SCAN_PREFIX}s001:raysPerDeg": ("float", 4.0),
        f"{SCAN_PREFIX}s001:rangeResM": ("float", 0.1),
        f"{SCAN_PREFIX}s001:velResMps": ("float", 0.2),
        f"{SCAN_PREFIX}s001:boreAzResDeg": ("float", 29.0),
        f"{SCAN_PREFIX}s001:boreElResDeg": ("float", 58.0),
        f"{SCAN_PREFIX}s001:elevMode": ("token", "FULL_EL"),
        f"{SCAN_PREFIX}s001:maxVelMpsSequence": ("float[]", [8.0, 9.0]),
    }
}


def author_config(prim: Usd.Prim, config: str, variant: Any = None, **where: Any) -> None:
    """Writes a shipped configuration on a radar prim, by its asset's path or name. Raises SensorValueError."""
    name = Path(config).stem.replace(" ", "_")
    if name not in _VALUES:
        hint = did_you_mean(name, _VALUES, f"there are: {', '.join(_VALUES)}")
        raise SensorValueError(f"there is no radar configuration {config!r} in SUPPORTED_RADAR_CONFIGS{hint}")
    if variant:
        raise SensorValueError(f"radar configuration {name} has no variants; leave {variant!r} out")
    apply_schemas(prim, ["OmniSensorAPI", API])
    for attribute, (kind, value) in _VALUES[name].items():
        write(prim, attribute, kind, value)
