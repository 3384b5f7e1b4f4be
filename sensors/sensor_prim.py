"""The authoring object of a sensor: one prim, created or wrapped, with its attributes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from graph.base import exact
from graph.base.suggesting import Suggesting
from graph.sim import entered
from graph.sim.scene.prim_paths import is_path

from . import prim as on_prim
from .errors import SensorValueError
from .prim import TICK_RATE
from .xform import Vector, local_pose, place, world_pose

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.app import App
    from graph.sim.renderer.view import WorldView


class SensorPrim(Suggesting):
    """Base of the classes that wrap the sensor prim at a path, or create a missing one; see `Lidar` and `Radar`.

    A subclass names the type of its prims, the schema that they need, its auxiliary levels and the word for it.
    Raises SensorValueError (a UserError and a ValueError).
    """

    prim_type: ClassVar[str]
    schema: ClassVar[str]
    aux_levels: ClassVar[tuple[str, ...]]
    word: ClassVar[str]

    def __init__(
        self,
        path: str | Sequence[str],
        *,
        aux_output_level: str | None = None,
        tick_rate: float | Fraction | None = None,
        schemas: str | Sequence[str] | None = None,
        attributes: Mapping[str, Any] | None = None,
        positions: Vector = None,
        translations: Vector = None,
        orientations: Vector = None,
        scales: Vector = None,
        reset_xform_op_properties: bool = True,
        app: App | None = None,
    ) -> None:
        if aux_output_level is not None and aux_output_level not in self.aux_levels:
            raise SensorValueError(f"aux_output_level {aux_output_level!r} is not one of {', '.join(self.aux_levels)}")
        self.scene: WorldView = (entered.current() if app is None else app).world
        self.path, existed = resolve(self.scene.stage, path, self.word)
        if not isinstance(attributes, Mapping | None):
            raise SensorValueError(
                f"{self.path}: attributes are a mapping of names to values, not {type(attributes).__name__}"
            )
        attributes = dict(attributes or {})
        schemas = [schemas] if isinstance(schemas, str) else list(schemas or ())
        on_prim.check_instances(self.path, schemas)
        for name in on_prim.unknown_schemas(schemas):
            self._warn("unknown-schema", f"there is no API schema {name}; nothing comes of it", name)
        if existed:
            self._check_wrapped()
            on_prim.apply_schemas(self.prim, schemas)
        else:
            self.check_creation()
            self.define(self.scene.stage, self.path)
            if tick_rate is None and TICK_RATE not in attributes:
                tick_rate = self.bare_rate() or None
            on_prim.apply_schemas(self.prim, [*schemas, *self.implied_schemas(attributes)])
        self._write_rate(tick_rate, attributes)
        self.write_arguments(attributes, tick_rate=tick_rate, wrapped=existed)
        self._write_attributes(attributes, created=not existed)
        if aux_output_level is not None or not existed:
            on_prim.write_aux_level(self.prim, aux_output_level or "NONE")
        if reset_xform_op_properties and not existed and translations is None and positions is None:
            translations = (0.0, 0.0, 0.0)
        place(self.prim, positions=positions, translations=translations, orientations=orientations, scales=scales)

    @classmethod
    def create(
        cls,
        path: str | Sequence[str],
        *,
        config: str | None = None,
        usd_path: str | Path | None = None,
        variant: str | Mapping[str, str] | None = None,
        app: App | None = None,
        **options: Any,
    ) -> Self:
        """A sensor from a shipped configuration, or from a USD asset.

        config: a name among the supported configurations. usd_path: an asset that holds such a sensor; a .usda is
        referenced as the prim itself, any other below an Xform, whose first one is wrapped. variant: a name, or
        {variant set: name}. Other options as in the constructor. Raises SensorValueError.
        """
        app = app if app is not None else entered.current()
        path = one_path(path, cls.word)
        if config is not None and usd_path is not None:
            raise SensorValueError(f"{path}: give config or usd_path, not both")
        for name, value, kinds, words in (
            ("config", config, (str,), "a name"),
            ("usd_path", usd_path, (str, Path), "the path of a file"),
            ("variant", variant, (str, Mapping), "a name, or a mapping of variant sets to names"),
        ):
            if value is not None and not isinstance(value, kinds):
                raise SensorValueError(f"{path}: {name} {value!r} is not {words}")
        if config is not None:
            cls.write_config(app.stage, path, config, variant)
        elif usd_path is not None:
            path = _reference(app.stage, path, str(usd_path), variant, cls.prim_type)
        return cls(path, app=app, **options)

    # -- for subclasses ----------------------------------------------------------------------------------------------

    def check_creation(self) -> None:
        """Raises an error if such a prim cannot be created; not called for wrapping one."""

    @classmethod
    def define(cls, stage: Usd.Stage, path: str) -> Usd.Prim:
        """Makes the prim, with Xforms for missing parents."""
        from graph.sim.usd import Sdf, UsdGeom

        for ancestor in Sdf.Path(path).GetParentPath().GetPrefixes():
            if not stage.GetPrimAtPath(ancestor):
                UsdGeom.Xform.Define(stage, ancestor)
        prim = stage.DefinePrim(path, cls.prim_type)
        on_prim.apply_schemas(prim, ["OmniSensorAPI", cls.schema])
        return prim

    @classmethod
    def write_config(cls, stage: Usd.Stage, path: str, config: str, variant: str | Mapping[str, str] | None) -> None:
        """Authors a shipped configuration on the prim at a path. Raises SensorValueError for an unknown one."""
        raise SensorValueError(f"{path}: there is no {cls.word} configuration {config!r}")

    def implied_schemas(self, attributes: Iterable[str]) -> list[str]:
        """Instances of schemas that the names of attributes imply."""
        return []

    def attribute_kind(self, name: str) -> str | None:
        """USD value type of an attribute that such sensors may have, by its full name; None for others."""
        return "float" if name == TICK_RATE else None

    def write_arguments(self, attributes: Mapping[str, Any], *, tick_rate: object, wrapped: bool) -> None:
        """Authors the arguments of the subclass; `attributes` replace them."""

    def bare_rate(self) -> Fraction:
        """The tick rate [Hz] of a prim that authors none."""
        return Fraction(0)

    # -- reading -----------------------------------------------------------------------------------------------------

    @property
    def prim(self) -> Usd.Prim:
        """The prim."""
        return self.scene.stage.GetPrimAtPath(self.path)

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
    def tick_rate(self) -> Fraction:
        """How often the sensor ticks [Hz]; 0 is every update."""
        return on_prim.read_tick_rate(self.prim, self.bare_rate())

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
        """Raises SensorValueError for a prim of another type; this one has its schema built in."""
        check_type(self.prim, self.prim_type)

    def _write_rate(self, tick_rate: float | Fraction | None, attributes: Mapping[str, Any]) -> None:
        if tick_rate is None:
            return
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

    def _write_attributes(self, attributes: Mapping[str, Any], *, created: bool) -> None:
        for name, value in attributes.items():
            kind = self.attribute_kind(name)
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
        self.scene.warn(code, f"{self.path}.{detail}" if detail else self.path, message)


def check_type(prim: Usd.Prim, wanted: str) -> None:
    """Raises SensorValueError for a prim of another type."""
    if (kind := prim.GetTypeName()) != wanted:
        raise SensorValueError(f"{prim.GetPath()} is of type {kind or 'none'}, not {wanted}")


def one_path(path: Any, word: str) -> str:
    """The path or expression that is given, a str or a Sdf.Path, also as a list of one; word: for the sensor.

    Raises SensorValueError for anything else.
    """
    if isinstance(path, list | tuple):
        if len(path) != 1:
            raise SensorValueError(f"{len(path)} paths are given; a {word} is exactly one prim")
        path = path[0]
    return _path_text(path)


def _path_text(path: Any) -> str:
    from graph.sim.usd import Sdf

    if not isinstance(path, str | Sdf.Path):
        told = repr(path) if isinstance(path, int | float | None) else f"a {type(path).__name__}"
        raise SensorValueError(f"{told} is not the path of a prim, such as /World/Sensor")
    return str(path)


def resolve(stage: Usd.Stage, path: str | Sequence[str], word: str) -> tuple[str, bool]:
    """(prim path, whether the prim exists) of a path or regular expression; word: for the sensor."""
    matches = matching_paths(stage, path := one_path(path, word))
    if len(matches) > 1:
        raise SensorValueError(f"{path!r} matches {len(matches)} prims; a {word} is exactly one")
    return matches[0], bool(stage.GetPrimAtPath(matches[0]))


def matching_paths(stage: Usd.Stage, path: Any) -> list[str]:
    """An absolute path itself; of a regular expression, the prims that it matches, in the stage's order.

    Raises SensorValueError where nothing matches.
    """
    from graph.sim.usd import Sdf

    path = _path_text(path)
    if is_path(path) and Sdf.Path(path).IsAbsolutePath():
        return [path]
    try:
        pattern = re.compile(path)
    except re.error as error:
        raise SensorValueError(f"{path!r} is neither a prim path nor a regular expression ({error})") from error
    matches = [str(prim.GetPath()) for prim in stage.Traverse() if pattern.fullmatch(str(prim.GetPath()))]
    if not matches:
        raise SensorValueError(
            f"{path!r} is not an absolute prim path, and as a regular expression (.* is any text) it matches no prim"
        )
    return matches


def _reference(
    stage: Usd.Stage, path: str, usd_path: str, variant: str | Mapping[str, str] | None, prim_type: str
) -> str:
    """References a USD asset; returns the path of the sensor of this type in it."""
    from graph.sim.usd import Usd

    if not Path(usd_path).is_file():
        raise SensorValueError(f"usd_path {usd_path}: there is no such file")
    as_itself = usd_path.endswith(".usda")
    prim = stage.DefinePrim(path, prim_type if as_itself else "Xform")
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
        if candidate.GetTypeName() == prim_type:
            return str(candidate.GetPath())
    raise SensorValueError(f"usd_path {usd_path}: it holds no {prim_type}")
