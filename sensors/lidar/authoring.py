"""Lidar: one lidar prim, created or wrapped, with its attributes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import exact
from graph.base.errors import UserError
from graph.sim import settings as keys
from sensors import prim as on_prim
from sensors.channels import AuxLevel
from sensors.errors import SensorValueError
from sensors.prim import TICK_RATE
from sensors.xform import Vector, local_pose, place, world_pose

from .config import LidarConfig
from .names import CORE_API, PREFIX, PRIM_TYPE, STATE_PREFIX
from .prim import STATE_API, attribute_kind, read_config, write_config

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim import App
    from sensors.configs.catalog import Variant


class Lidar:
    """Wraps the lidar prim at a path, or creates a missing one.

    path: a prim path, or a regular expression that matches one prim. aux_output_level: NONE, BASIC, EXTRA or FULL.
    tick_rate [Hz] writes omni:sensor:tickRate, accumulate_outputs omni:sensor:Core:accumulateOutputs. None leaves each
    of the three as the prim has it; a new one has NONE, the profile's rate of a bare lidar, and accumulates.
    schemas: API schemas to apply, "Name" or "Name:instance". attributes: name to value; they replace the arguments; an
    attribute that the prim does not have is skipped with a warning. positions (world) or translations (local),
    orientations w, x, y, z, scales: shape (n,) or (1, n), stage units. app: None is the App entered last. Raises
    SensorValueError (a UserError and a ValueError).
    """

    def __init__(
        self,
        path: str,
        *,
        aux_output_level: str | None = None,
        tick_rate: float | Fraction | None = None,
        accumulate_outputs: bool | None = None,
        schemas: Sequence[str] | None = None,
        attributes: Mapping[str, Any] | None = None,
        positions: Vector = None,
        translations: Vector = None,
        orientations: Vector = None,
        scales: Vector = None,
        reset_xform_op_properties: bool = True,
        app: App | None = None,
    ) -> None:
        from graph.sim import App

        if aux_output_level is not None and aux_output_level not in AuxLevel.__members__:
            raise SensorValueError(
                f"aux_output_level {aux_output_level!r} is not one of {', '.join(AuxLevel.__members__)}"
            )
        self.app: App = app if app is not None else App.current()
        attributes = dict(attributes or {})
        self.path, existed = _resolve(self.app.stage, path)
        schemas = list(schemas or ())
        for name in on_prim.unknown_schemas(schemas):
            self._warn("unknown-schema", f"there is no API schema {name}; nothing comes of it", name)
        if existed:
            self._check_wrapped()
            on_prim.apply_schemas(self.prim, schemas)
        else:
            _define(self.app.stage, self.path)
            bare = self.app.settings.rate(keys.BARE_LIDAR_TICK_RATE)
            if tick_rate is None and bare and TICK_RATE not in attributes:
                tick_rate = bare
            on_prim.apply_schemas(self.prim, [*schemas, *_implied_schemas(attributes)])
        self._write_rates(tick_rate, accumulate_outputs, attributes, wrapped=existed)
        self._write_attributes(attributes, created=not existed)
        if aux_output_level is not None or not existed:
            on_prim.write_aux_level(self.prim, aux_output_level or "NONE")
        if reset_xform_op_properties and not existed and translations is None and positions is None:
            translations = (0.0, 0.0, 0.0)
        place(self.prim, positions=positions, translations=translations, orientations=orientations, scales=scales)

    @classmethod
    def create(
        cls,
        path: str,
        *,
        config: str | None = None,
        usd_path: str | None = None,
        variant: Variant = None,
        accumulate_outputs: bool | None = None,
        app: App | None = None,
        **options: Any,
    ) -> Lidar:
        """A lidar from a shipped configuration, from a vendor profile's .json file, or from a USD asset.

        config: any spelling of a name in SUPPORTED_LIDAR_CONFIGS, or the path of a profile; it authors tickRate =
        scanRateBaseHz unless tick_rate says otherwise. usd_path: an asset that holds a lidar; a .usda is
        referenced as the prim itself, any other below an Xform, whose first lidar is wrapped. variant: a name, or
        {variant set: name}. Other options as in the constructor. Raises SensorValueError.
        """
        from graph.sim import App

        app = app if app is not None else App.current()
        if config is not None and usd_path is not None:
            raise SensorValueError(f"{path}: give config or usd_path, not both")
        for name, value, kinds in (("config", config, (str,)), ("variant", variant, (str, Mapping))):
            if value is not None and not isinstance(value, kinds):
                also = ", or a mapping of variant sets to names" if Mapping in kinds else ""
                raise SensorValueError(f"{path}: {name} {value!r} is not a name{also}")
        if config is not None:
            _write_config(app.stage, path, config, variant)
        elif usd_path is not None:
            path = _reference(app.stage, path, usd_path, variant)
        return cls(path, accumulate_outputs=accumulate_outputs, app=app, **options)

    # -- reading -----------------------------------------------------------------------------------------------------

    @property
    def prim(self) -> Usd.Prim:
        """The prim."""
        return self.app.stage.GetPrimAtPath(self.path)

    @property
    def prims(self) -> list[Usd.Prim]:
        """The one prim, as a list."""
        return [self.prim]

    @property
    def paths(self) -> list[str]:
        """The one path, as a list."""
        return [self.path]

    @property
    def aux_output_level(self) -> str:
        """NONE, BASIC, EXTRA or FULL."""
        return on_prim.read_aux_level(self.prim).name

    @property
    def config(self) -> LidarConfig:
        """The configuration that the prim describes now."""
        return read_config(self.prim)

    @property
    def tick_rate(self) -> Fraction:
        """How often the sensor ticks [Hz]; 0 is every update."""
        return on_prim.read_tick_rate(self.prim, self.app.settings.rate(keys.BARE_LIDAR_TICK_RATE))

    def get_local_poses(self) -> tuple[np.ndarray, np.ndarray]:
        """Translations (1, 3) and orientations (1, 4) w, x, y, z below the parent, stage units."""
        translation, orientation = local_pose(self.prim)
        return translation[None], orientation[None]

    def get_world_poses(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (1, 3) and orientations (1, 4) w, x, y, z in the world, stage units, as authored on the stage."""
        position, orientation = world_pose(self.prim)
        return position[None], orientation[None]

    def set_local_poses(self, translations: Vector = None, orientations: Vector = None) -> None:
        """Places the prim below its parent; parts that are not given stay unchanged."""
        place(self.prim, translations=translations, orientations=orientations)

    def set_world_poses(self, positions: Vector = None, orientations: Vector = None) -> None:
        """Places the prim in the world; parts that are not given stay unchanged."""
        if positions is None and orientations is not None:
            positions = world_pose(self.prim)[0]
        place(self.prim, positions=positions, orientations=orientations)

    # -- inside ------------------------------------------------------------------------------------------------------

    def _check_wrapped(self) -> None:
        """Raises SensorValueError for a prim of another type; this one has the core schema built in."""
        kind = self.prim.GetTypeName()
        if kind != PRIM_TYPE:
            raise SensorValueError(f"{self.path} is a {kind or 'typeless prim'}, not an {PRIM_TYPE}")

    def _write_rates(
        self,
        tick_rate: float | Fraction | None,
        accumulate: bool | None,
        attributes: Mapping[str, Any],
        *,
        wrapped: bool,
    ) -> None:
        accumulate_name = f"{PREFIX}accumulateOutputs"
        if tick_rate is not None:
            try:
                rate = exact.rate(tick_rate)
            except (ValueError, TypeError):
                rate = Fraction(-1)
            if rate < 0:
                raise SensorValueError(f"tick_rate {tick_rate!r}: give a rate in Hz, or 0 to render in every update")
            if TICK_RATE in attributes:
                self._warn("attribute-wins", f"attributes give {TICK_RATE}; tick_rate={float(rate):g} is ignored")
            else:
                on_prim.write(self.prim, TICK_RATE, "float", float(rate))
        elif wrapped and TICK_RATE not in attributes and self.tick_rate != self.config.scan_rate_base_hz:
            self._warn(
                "lidar-partial-scan",
                f"tickRate is {float(self.tick_rate):g} Hz, scanRateBaseHz is "
                f"{float(self.config.scan_rate_base_hz):g} Hz: give tick_rate= for whole scans",
            )
        if accumulate is not None:
            if accumulate_name not in attributes:
                on_prim.write(self.prim, accumulate_name, "bool", bool(accumulate))
            elif not accumulate:
                self._warn("attribute-wins", f"attributes give {accumulate_name}; accumulate_outputs is ignored")

    def _write_attributes(self, attributes: Mapping[str, Any], *, created: bool) -> None:
        for name, value in attributes.items():
            kind = attribute_kind(name)
            if self.prim.GetAttribute(name) or (created and kind):
                try:
                    on_prim.write(self.prim, name, kind or "token", value)
                except SensorValueError:
                    raise
                except Exception as error:  # numpy and USD may raise anything for values of other types
                    wanted = self.prim.GetAttribute(name).GetTypeName() if self.prim.GetAttribute(name) else kind
                    raise SensorValueError(f"{self.path}.{name} cannot be {value!r}: its type is {wanted}") from error
            elif kind:
                on_prim.write(self.prim, name, kind, value)
            else:
                self._warn("unknown-attribute", f"the prim has no attribute {name}; it is skipped", name)

    def _warn(self, code: str, message: str, detail: str = "") -> None:
        self.app.warn(code, f"{self.path}.{detail}" if detail else self.path, message)


def _resolve(stage: Usd.Stage, path: str) -> tuple[str, bool]:
    """(prim path, whether the prim exists) of a path or regular expression."""
    from graph.sim.usd import Sdf

    if Sdf.Path.IsValidPathString(path) and Sdf.Path(path).IsAbsolutePath():
        return path, bool(stage.GetPrimAtPath(path))
    try:
        pattern = re.compile(path)
    except re.error as error:
        raise SensorValueError(f"{path!r} is neither a prim path nor a regular expression ({error})") from error
    matches = [str(prim.GetPath()) for prim in stage.Traverse() if pattern.fullmatch(str(prim.GetPath()))]
    if len(matches) > 1:
        raise SensorValueError(f"{path!r} matches {len(matches)} prims; a lidar is exactly one")
    if not matches:
        raise SensorValueError(f"{path!r} is not an absolute prim path, and no prim matches it")
    return matches[0], True


def _define(stage: Usd.Stage, path: str) -> Usd.Prim:
    from graph.sim.usd import Sdf, UsdGeom

    for ancestor in Sdf.Path(path).GetParentPath().GetPrefixes():
        if not stage.GetPrimAtPath(ancestor):
            UsdGeom.Xform.Define(stage, ancestor)
    prim = stage.DefinePrim(path, PRIM_TYPE)
    on_prim.apply_schemas(prim, ["OmniSensorAPI", CORE_API])
    return prim


def _implied_schemas(attributes: Mapping[str, Any]) -> list[str]:
    """Emitter states that attribute names imply."""
    instances = {name.removeprefix(STATE_PREFIX).split(":")[0] for name in attributes if name.startswith(STATE_PREFIX)}
    return [f"{STATE_API}:{instance}" for instance in sorted(instances)]


def _write_config(stage: Usd.Stage, path: str, config: str, variant: Variant) -> None:
    from sensors.configs.catalog import load

    try:
        found = load(config, variant)
    except UserError as error:
        raise SensorValueError(error.problems) from error
    path, existed = _resolve(stage, path)
    prim = stage.GetPrimAtPath(path) if existed else _define(stage, path)
    if prim.GetTypeName() != PRIM_TYPE:
        raise SensorValueError(f"{path} is a {prim.GetTypeName() or 'typeless prim'}, not an {PRIM_TYPE}")
    write_config(prim, found)


def _reference(stage: Usd.Stage, path: str, usd_path: str, variant: Variant) -> str:
    """References a USD asset; returns the path of the lidar in it."""
    from graph.sim.usd import Usd

    if not Path(usd_path).is_file():
        raise SensorValueError(f"usd_path {usd_path}: there is no such file")
    as_itself = usd_path.endswith(".usda")
    prim = stage.DefinePrim(path, PRIM_TYPE if as_itself else "Xform")
    prim.GetReferences().AddReference(str(Path(usd_path).resolve()))
    for set_name, name in ({"sensor": variant} if isinstance(variant, str) else dict(variant or {})).items():
        if not prim.GetVariantSets().HasVariantSet(set_name):
            there = ", ".join(prim.GetVariantSets().GetNames()) or "none"
            raise SensorValueError(f"{usd_path} has no variant set {set_name}; there are: {there}")
        names = prim.GetVariantSet(set_name).GetVariantNames()
        if name not in names:
            raise SensorValueError(f"{usd_path} has no {set_name} variant {name!r}; there are: {', '.join(names)}")
        prim.GetVariantSet(set_name).SetVariantSelection(name)
    for candidate in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        if candidate.GetTypeName() == PRIM_TYPE:
            return str(candidate.GetPath())
    raise SensorValueError(f"usd_path {usd_path}: it holds no {PRIM_TYPE}")
