"""`isaacsim.core.utils.stage`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.isaac.assets import local_path
from graph.isaac.outcomes import inert
from graph.isaac.session import app, kit
from graph.sim.usd import UsdGeom

from . import stage as new
from .stage import delete_prim, is_stage_loading, use_stage
from .usd import get_context, get_stage_next_free_path, save

__all__ = [
    "add_reference_to_stage",
    "clear_stage",
    "close_stage",
    "create_new_stage",
    "create_new_stage_async",
    "create_new_stage_in_memory",
    "delete_prim",
    "get_current_stage",
    "get_current_stage_id",
    "get_next_free_path",
    "get_stage_units",
    "get_stage_up_axis",
    "is_stage_loading",
    "open_stage",
    "open_stage_async",
    "print_stage_prim_paths",
    "remove_deleted_references",
    "save_stage",
    "set_livesync_stage",
    "set_stage_units",
    "set_stage_up_axis",
    "traverse_stage",
    "update_stage",
    "update_stage_async",
    "use_stage",
]


def get_current_stage(fabric: bool = False) -> Any:
    return new.get_current_stage(backend="fabric" if fabric else None)


def remove_deleted_references() -> None:
    """Removes references to files that are not there."""
    for prim in get_current_stage().Traverse():
        for spec in prim.GetPrimStack():
            gone = [one for one in spec.referenceList.prependedItems if one.assetPath and not local_path(one.assetPath)]
            for one in gone:
                prim.GetReferences().RemoveReference(one)


def add_reference_to_stage(usd_path: str, prim_path: str, prim_type: str = "Xform") -> Any:
    return new.add_reference_to_stage(usd_path, prim_path, prim_type=prim_type)


def get_current_stage_id() -> int:
    return new.get_stage_id(new.usd_stage())


def get_next_free_path(path: str, parent: str | None = None) -> str:
    full = f"{parent.rstrip('/')}/{path.lstrip('/')}" if parent else path
    return get_stage_next_free_path(app().stage, full, False)


def get_stage_units() -> float:
    return float(UsdGeom.GetStageMetersPerUnit(get_current_stage()))


def set_stage_units(stage_units_in_meters: float) -> None:
    new.set_stage_units(meters_per_unit=stage_units_in_meters)


def get_stage_up_axis() -> str:
    return str(UsdGeom.GetStageUpAxis(get_current_stage()))


def set_stage_up_axis(axis: str = "z") -> None:
    UsdGeom.SetStageUpAxis(get_current_stage(), axis.upper())


def clear_stage(predicate: Callable[[str], bool] | None = None) -> None:
    stage = get_current_stage()
    kept = ("/", "/Render", "/OmniverseKit")
    for prim in list(stage.GetPseudoRoot().GetChildren()):
        path = str(prim.GetPath())
        if not path.startswith(kept[1:]) and (predicate is None or predicate(path)):
            stage.RemovePrim(path)


def create_new_stage() -> Any:
    return new.create_new_stage()


async def create_new_stage_async() -> None:
    new.create_new_stage()
    await kit().next_update()


def create_new_stage_in_memory() -> Any:
    from graph.sim.scene.stage import open_stage as opened

    return opened()


def open_stage(usd_path: str) -> bool:
    return get_context().open_stage(usd_path)


async def open_stage_async(usd_path: str) -> tuple[bool, str]:
    return await get_context().open_stage_async(usd_path)


def save_stage(usd_path: str, save_and_reload_in_place: bool = True) -> bool:
    return save(usd_path)


def close_stage(callback_fn: Any = None) -> bool:
    return get_context().close_stage(callback_fn)


def update_stage() -> None:
    kit().update()


async def update_stage_async() -> None:
    await kit().next_update()


def traverse_stage(fabric: bool = False) -> Any:
    return get_current_stage().Traverse()


def print_stage_prim_paths(fabric: bool = False) -> None:
    for prim in get_current_stage().Traverse():
        print(prim.GetPath())


@inert("isaacsim.core.utils.stage")
def set_livesync_stage(usd_path: str, enable: bool) -> bool:
    return False
