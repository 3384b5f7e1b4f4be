"""Attributes that are authored in the same way on the prims of all sensors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.suggest import did_you_mean
from graph.sim import entered

from .errors import SensorValueError
from .prim import write_exclude
from .sensor_types import sensor_types

if TYPE_CHECKING:
    from graph.sim.app import App


def bind_material(prim: Any, material: str | Mapping[str, Any], *, app: App | None = None) -> None:
    """Binds a non-visual material, which lidars and radars see, to a prim and its descendants.

    prim: its path, or an object with a `path`. material: a name such as "aluminum", or {"base":, "coating":,
    "attributes":} as the key `material:` of graph files takes it. It takes effect at the next play. Raises
    SensorValueError for an unknown name or a missing prim.
    """
    from graph.sim.scene import nonvisual

    stage = (app or entered.current()).stage
    path = str(getattr(prim, "path", prim))
    found = stage.GetPrimAtPath(path) if path.startswith("/") else None
    if not found:
        known = [str(each.GetPath()) for each in stage.Traverse()]
        raise SensorValueError(f"material: there is no prim {path}{did_you_mean(path, known)}")
    try:
        names = nonvisual.parse(material)
    except ValueError as error:
        raise SensorValueError(f"{path}: {error}") from error
    nonvisual.bind(stage, found, names)


def exclude(sensor: Any, paths: str | Iterable[str], *, app: App | None = None) -> None:
    """Hides prims, and everything below them, from a sensor; an empty list ends that.

    sensor: path of its prim, or an authoring object such as `Lidar`. app: None is the App entered last. Takes effect at
    the next play. Raises SensorValueError for a prim that is not a sensor, and for paths without a prim.
    """
    stage = (app or entered.current()).stage
    path = str(getattr(sensor, "path", sensor))
    prim = stage.GetPrimAtPath(path)
    if not prim or prim.GetTypeName() not in sensor_types():
        raise SensorValueError(f"{path} is not a sensor prim; give the path of one")
    listed = (paths,) if isinstance(paths, str) else tuple(map(str, paths))
    for target in listed:
        if not target.startswith("/") or not stage.GetPrimAtPath(target):
            known = [str(each.GetPath()) for each in stage.Traverse()]
            raise SensorValueError(f"exclude: there is no prim {target}{did_you_mean(target, known)}")
    write_exclude(prim, listed)
