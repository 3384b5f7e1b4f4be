"""Shipped radar configurations: those that Isaac Sim knows by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from sensors.configs.spelling import short_name, spellings
from sensors.errors import SensorValueError
from sensors.prim import apply_schemas, write

from .names import API, PREFIX, PRIM_TYPE, SCAN_PREFIX

if TYPE_CHECKING:
    from pxr import Usd


@dataclass(frozen=True, slots=True)
class RadarAsset:
    """One radar with one scan configuration, s001: its asset path and its attributes.

    values: attribute -> value, without the prefix; scan: those of s001. It has no variants.
    """

    path: str
    source: str
    values: Mapping[str, tuple[str, Any]]
    scan: Mapping[str, tuple[str, Any]]
    prim_type: str = PRIM_TYPE
    variants: tuple[str, ...] = ()
    products: tuple[str, ...] = ()
    default: None = None

    @property
    def spellings(self) -> tuple[str, ...]:
        """As of a lidar's asset."""
        return spellings(self.path, ())

    @property
    def short_name(self) -> str:
        """The name used in messages."""
        return short_name(self.path, ())

    @property
    def attributes(self) -> dict[str, tuple[str, Any]]:
        """Attribute -> its USD type and its value."""
        named = {f"{PREFIX}{name}": value for name, value in self.values.items()}
        return named | {f"{SCAN_PREFIX}s001:{name}": value for name, value in self.scan.items()}

    def figures(self, variant: Any = None) -> dict[str, Any]:
        """What the radar is like, as `graph sensors` lists it; it ticks in every update unless a rate is authored."""
        scan = {name: value for name, (_, value) in self.scan.items()}
        across, up, dense = scan["maxAzAngDeg"], scan["maxElAngDeg"], scan["raysPerDeg"]
        return {
            "modality": "radar",
            "scan_rate_hz": None,
            "rays_per_scan": round(2 * across * dense) * round(2 * up * dense),
            "azimuth_deg": [-across, across],
            "elevation_deg": [-up, up],
            "range_m": [0.0, scan["maxRangeM"]],
            "range_resolution_m": scan["rangeResM"],
            "velocity_resolution_mps": scan["velResMps"],
            "velocities_mps": scan["maxVelMpsSequence"],
            "wavelength_mm": self.values["waveLengthMm"][1],
        }


ASSETS = (
    RadarAsset(
        "/Isaac/Sensors/TexasInstruments/IWRL6432AOP/IWRL6432AOP.usd",
        "the asset's own values are not public; the band, 57 to 64 GHz, is that of the chip's data sheet, its middle "
        "is 4.955 mm; the rest is estimated for a short-range sensor on its package's antennas",
        {"waveLengthMm": ("float", 4.955)},
        {
            "maxRangeM": ("float", 25.0),
            "maxAzAngDeg": ("float", 70.0),
            "maxElAngDeg": ("float", 60.0),
            "raysPerDeg": ("float", 4.0),
            "rangeResM": ("float", 0.1),
            "velResMps": ("float", 0.2),
            "boreAzResDeg": ("float", 29.0),
            "boreElResDeg": ("float", 58.0),
            "elevMode": ("token", "FULL_EL"),
            "maxVelMpsSequence": ("float[]", [8.0, 9.0]),
        },
    ),
)

SUPPORTED_RADAR_CONFIGS: dict[str, list[Any]] = {asset.path: [] for asset in ASSETS}
"""Asset -> its variants."""


def author_config(prim: Usd.Prim, config: str, variant: Any = None, **where: Any) -> None:
    """Writes a shipped configuration on a radar prim, by any spelling of its name. Raises SensorValueError."""
    asset = next((one for one in ASSETS if config in one.spellings), None)
    if asset is None:
        names = [one.short_name for one in ASSETS]
        hint = did_you_mean(config, names, f"there are: {', '.join(names)}")
        raise SensorValueError(f"there is no radar configuration {config!r} in SUPPORTED_RADAR_CONFIGS{hint}")
    if variant:
        raise SensorValueError(f"radar configuration {asset.short_name} has no variants; leave {variant!r} out")
    apply_schemas(prim, ["OmniSensorAPI", API])
    for attribute, (kind, value) in asset.attributes.items():
        write(prim, attribute, kind, value)
