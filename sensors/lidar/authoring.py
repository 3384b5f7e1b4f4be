"""Lidar: one lidar prim, created or wrapped, with its attributes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.sim import settings as keys
from sensors import prim as on_prim
from sensors.channels import AuxLevel
from sensors.errors import SensorValueError
from sensors.prim import TICK_RATE
from sensors.sensor import PointSensor
from sensors.sensor_prim import SensorPrim, check_type, resolve

from .config import LidarConfig
from .names import CORE_API, PREFIX, PRIM_TYPE, STATE_PREFIX
from .prim import STATE_API, attribute_kind, read_config, write_config
from .runtime import LidarRuntime

if TYPE_CHECKING:
    from pxr import Usd

    from sensors.configs.catalog import Variant


class Lidar(SensorPrim):
    """Wraps the lidar prim at a path, or creates a missing one.

    path: a prim path, or a regular expression that matches one prim. aux_output_level: NONE, BASIC, EXTRA or FULL.
    tick_rate [Hz] writes omni:sensor:tickRate, accumulate_outputs omni:sensor:Core:accumulateOutputs. None leaves each
    of the three as the prim has it; a new one has NONE, the profile's rate of a bare lidar, and accumulates.
    schemas: API schemas to apply, "Name" or "Name:instance". attributes: name to value; they replace the arguments; an
    attribute that the prim does not have is skipped with a warning. positions (world) or translations (local),
    orientations w, x, y, z, scales: shape (n,) or (1, n), stage units. app: None is the App entered last. Raises
    SensorValueError (a UserError and a ValueError).
    """

    prim_type = PRIM_TYPE
    schema = CORE_API
    aux_levels = tuple(AuxLevel.__members__)
    word = "lidar"

    def __init__(self, path: str | Sequence[str], *, accumulate_outputs: bool | None = None, **options: Any) -> None:
        self._accumulate = accumulate_outputs
        super().__init__(path, **options)

    @classmethod
    def create(cls, path: str | Sequence[str], *, accumulate_outputs: bool | None = None, **options: Any) -> Lidar:
        """A lidar from a shipped configuration, from a vendor profile's .json file, or from a USD asset.

        config: any spelling of a name in SUPPORTED_LIDAR_CONFIGS, or the path of a profile; it authors tickRate =
        scanRateBaseHz unless tick_rate says otherwise. usd_path: an asset that holds a lidar; a .usda is
        referenced as the prim itself, any other below an Xform, whose first lidar is wrapped. variant: a name, or
        {variant set: name}. Other options as in the constructor. Raises SensorValueError.

        >>> from graph.sim import App
        >>> with App() as app:
        ...     lidar = Lidar.create("/World/lidar", config="Example_Rotary", tick_rate=10.0, translations=[0, 0, 1])
        ...     lidar.path, lidar.config.scan_rate_base_hz
        ('/World/lidar', Fraction(10, 1))
        """
        return super().create(path, accumulate_outputs=accumulate_outputs, **options)

    @property
    def config(self) -> LidarConfig:
        """The configuration that the prim describes now."""
        return read_config(self.prim)

    # -- what is a lidar's own ---------------------------------------------------------------------------------------

    @classmethod
    def write_config(cls, stage: Usd.Stage, path: str, config: str, variant: Variant) -> None:
        """Authors a configuration on the prim at a path, with the tick rate of its scans."""
        from sensors.configs.catalog import load

        try:
            found = load(config, variant)
        except UserError as error:
            raise SensorValueError(error.problems) from error
        path, existed = resolve(stage, path, cls.word)
        prim = stage.GetPrimAtPath(path) if existed else cls.define(stage, path)
        check_type(prim, PRIM_TYPE)
        write_config(prim, found)

    def implied_schemas(self, attributes: Iterable[str]) -> list[str]:
        """Emitter states that attribute names bring with them."""
        instances = {
            name.removeprefix(STATE_PREFIX).split(":")[0] for name in attributes if name.startswith(STATE_PREFIX)
        }
        return [f"{STATE_API}:{instance}" for instance in sorted(instances)]

    def attribute_kind(self, name: str) -> str | None:
        """USD value type of an attribute that lidars have, by its full name; None for others."""
        return attribute_kind(name)

    def bare_rate(self) -> Fraction:
        """The tick rate [Hz] of a lidar that authors none, by the profile."""
        return self.scene.settings.rate(keys.BARE_LIDAR_TICK_RATE)

    def write_arguments(self, attributes: Mapping[str, Any], *, tick_rate: object, wrapped: bool) -> None:
        """Authors accumulateOutputs, and warns of a wrapped lidar whose tick rate is not its scan rate."""
        asked = tick_rate is not None or TICK_RATE in attributes
        if wrapped and not asked and self.tick_rate != self.config.scan_rate_base_hz:
            self._warn(
                "lidar-partial-scan",
                f"tickRate is {float(self.tick_rate):g} Hz, scanRateBaseHz is "
                f"{float(self.config.scan_rate_base_hz):g} Hz: give tick_rate= for whole scans",
            )
        name = f"{PREFIX}accumulateOutputs"
        if self._accumulate is not None:
            if name not in attributes:
                on_prim.write(self.prim, name, "bool", bool(self._accumulate))
            elif not self._accumulate:
                self._warn("attribute-wins", f"attributes give {name}; accumulate_outputs is ignored")


class LidarSensor(PointSensor[Lidar, LidarRuntime]):
    """Renders a lidar: `LidarSensor(lidar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Lidar

    @property
    def lidar(self) -> Lidar:
        """The Lidar."""
        return self.authoring_object
