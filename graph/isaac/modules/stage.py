"""`isaacsim.core.experimental.utils.stage`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from graph.isaac.assets import found_asset
from graph.isaac.session import app, app_or_none, kit
from graph.sim.usd import Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdUtils

from .backend import get_current_backend
from .usd import check_ancestral, get_context, get_stage_next_free_path, save

__all__ = [
    "add_reference_to_stage",
    "close_stage",
    "create_new_stage",
    "create_new_stage_async",
    "define_prim",
    "delete_prim",
    "generate_next_free_path",
    "generate_stage_representation",
    "get_current_stage",
    "get_stage_id",
    "get_stage_time_code",
    "get_stage_units",
    "get_stage_up_axis",
    "is_stage_loading",
    "is_stage_set",
    "move_prim",
    "open_stage",
    "open_stage_async",
    "save_stage",
    "set_stage_time_code",
    "set_stage_units",
    "set_stage_up_axis",
    "use_stage",
]
_STAGES: list[Any] = []


def usd_stage() -> Any:
    """The stage of USD that calls act on, whatever backend the script chose."""
    if _STAGES:
        return _STAGES[-1]
    found = app_or_none()
    if found is None or kit().stage_closed:
        raise ValueError("there is no stage; open one, or make SimulationApp(...) first")
    return found.stage


def asks_fabric(backend: str | None = None) -> bool:
    """Whether the script wants the objects of `usdrt`, by the argument or by `use_backend`."""
    return (backend or get_current_backend(["usd", "usdrt", "fabric"])) in ("usdrt", "fabric")


def get_current_stage(*, backend: str | None = None) -> Any:
    stage = usd_stage()
    if asks_fabric(backend):
        from . import usdrt

        return usdrt.Usd.Stage()
    return stage


@contextmanager
def use_stage(stage: Any) -> Iterator[None]:
    _STAGES.append(stage)
    try:
        yield
    finally:
        _STAGES.pop()


def is_stage_set() -> bool:
    return bool(_STAGES)


def is_stage_loading() -> bool:
    return False


def get_stage_id(stage: Any) -> int:
    """The stage's number in USD's cache, which takes it in if it is not there."""
    cache = UsdUtils.StageCache.Get()
    found = cache.GetId(stage)
    return int((found if found.IsValid() else cache.Insert(stage)).ToLongInt())


def add_reference_to_stage(
    usd_path: str,
    path: str,
    *,
    prim_type: str = "Xform",
    variants: Sequence[tuple[str, str]] | None = None,
    stage: Any = None,
) -> Any:
    stage = stage or usd_stage()
    prim = stage.GetPrimAtPath(path) or stage.DefinePrim(path, prim_type)
    refer(prim, usd_path)
    for name, choice in variants or ():
        prim.GetVariantSet(name).SetVariantSelection(choice)
    return prim


def refer(prim: Any, address: str, *, must_exist: bool = True) -> bool:
    """Adds a reference to an asset; a remote one that is not here is said once, and the prim stays empty.

    A local file that does not exist raises FileNotFoundError, or is said once as well.
    """
    file = found_asset(address, str(prim.GetPath()), must_exist=must_exist)
    if not file:
        return False
    try:
        layer = Sdf.Layer.FindOrOpen(file)
    except Exception as error:  # of USD's parser
        raise ValueError(f"{address}: USD cannot read this file: {str(error).splitlines()[-1]}") from None
    if layer is None:
        raise ValueError(f"{address}: USD cannot read this file")
    if layer.defaultPrim:
        prim.GetReferences().AddReference(file)
    else:
        first = next(iter(layer.rootPrims), None)
        prim.GetReferences().AddReference(file, first.path if first else Sdf.Path())
    return True


def open_stage(usd_path: str) -> tuple[bool, Any]:
    if get_context().open_stage(usd_path):
        return True, app().stage
    return False, None


async def open_stage_async(usd_path: str) -> tuple[bool, Any]:
    return open_stage(usd_path)


def create_new_stage(*, template: str | None = None) -> Any:
    get_context().new_stage()
    stage = app().stage
    if template is not None:
        stage.SetDefaultPrim(stage.DefinePrim("/World", "Xform"))
    if template not in (None, "empty"):
        UsdLux.DistantLight.Define(stage, "/Environment/defaultLight").CreateIntensityAttr(3000.0)
    return stage


async def create_new_stage_async(*, template: str | None = None) -> Any:
    return create_new_stage(template=template)


def close_stage() -> bool:
    return get_context().close_stage()


def save_stage(usd_path: str, save_and_reload_in_place: bool = True) -> bool:
    if not usd_path.endswith((".usd", ".usda", ".usdc", ".usdz")):
        raise ValueError(f"{usd_path} is not the name of a USD file")
    return save(usd_path)


def define_prim(path: str, type_name: str = "Xform") -> Any:
    stage = usd_stage()
    if not _is_path(path):
        raise ValueError(f"{path!r} is not the path of a prim")
    prim = stage.GetPrimAtPath(path)
    if prim and prim.GetTypeName() != type_name:
        raise RuntimeError(f"there is a {prim.GetTypeName() or 'typeless prim'} at {path}, not a {type_name}")
    return offered(prim or stage.DefinePrim(path, type_name))


def _is_path(path: Any) -> bool:
    return bool(Sdf.Path.IsValidPathString(str(path))) and str(path).startswith("/")


def offered(prim: Any) -> Any:
    """A prim as the script's backend has it: of USD, or of `usdrt`."""
    if prim is None or not asks_fabric():
        return prim
    from . import usdrt

    return usdrt.Usd.Prim(prim)


def _found(prim: Any) -> Any:
    """A prim of the stage, by itself or by its path. Raises ValueError if it is missing."""
    path = prim if isinstance(prim, str) else prim.GetPath()
    found = usd_stage().GetPrimAtPath(path)
    if not found:
        raise ValueError(f"{path} is not a valid prim of the stage")
    return found


def delete_prim(prim: Any) -> bool:
    found = _found(prim)
    return not check_ancestral(found) and bool(usd_stage().RemovePrim(found.GetPath()))


def move_prim(target: Any, destination: Any) -> tuple[bool, str]:
    """Moves a prim below an existing one, or to a new path below one.

    Raises ValueError for a missing target, a malformed path and a missing parent.
    """
    stage, source = usd_stage(), _found(target).GetPath()
    to = str(destination if isinstance(destination, str) else destination.GetPath())
    if not _is_path(to):
        raise ValueError(f"{to!r} is not a valid path string of a prim")
    if to == "/" or stage.GetPrimAtPath(to):
        to = f"{to.rstrip('/')}/{source.name}"
    if not stage.GetPrimAtPath(Sdf.Path(to).GetParentPath()):
        raise ValueError(f"{to} has an unexisting parent; define it first")
    editor = Usd.NamespaceEditor(stage)
    return bool(editor.MovePrimAtPath(source, to) and editor.ApplyEdits()), to


def generate_next_free_path(path: str | None = None, *, prepend_default_prim: bool = True) -> str:
    return get_stage_next_free_path(usd_stage(), "/Prim" if path in (None, "", "/") else path, prepend_default_prim)


def generate_stage_representation(mode: str = "tree") -> str:
    prims = list(usd_stage().Traverse())
    if mode == "list":
        return "\n".join(f"{prim.GetPath()} ({prim.GetTypeName()})" for prim in prims)
    return "\n".join(
        "  " * (prim.GetPath().pathElementCount - 1) + f"{prim.GetName()} ({prim.GetTypeName()})" for prim in prims
    )


def get_stage_units() -> tuple[float, float]:
    stage = usd_stage()
    return UsdGeom.GetStageMetersPerUnit(stage), UsdPhysics.GetStageKilogramsPerUnit(stage)


def set_stage_units(*, meters_per_unit: float | None = None, kilograms_per_unit: float | None = None) -> None:
    stage = usd_stage()
    if meters_per_unit is not None:
        UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
    if kilograms_per_unit is not None:
        UsdPhysics.SetStageKilogramsPerUnit(stage, kilograms_per_unit)


def get_stage_up_axis() -> str:
    return str(UsdGeom.GetStageUpAxis(usd_stage()))


def set_stage_up_axis(up_axis: str) -> None:
    UsdGeom.SetStageUpAxis(usd_stage(), up_axis.upper())


def get_stage_time_code() -> tuple[float, float, float]:
    stage = usd_stage()
    return stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()


def set_stage_time_code(
    *,
    start_time_code: float | None = None,
    end_time_code: float | None = None,
    time_codes_per_second: float | None = None,
) -> None:
    stage, timeline = usd_stage(), app().timeline
    if time_codes_per_second is not None:
        stage.SetTimeCodesPerSecond(time_codes_per_second)
        timeline.set_time_codes_per_second(time_codes_per_second)
    if start_time_code is not None:
        stage.SetStartTimeCode(start_time_code)
        timeline.set_start_time(start_time_code / timeline.get_time_codes_per_second())
    if end_time_code is not None:
        stage.SetEndTimeCode(end_time_code)
        timeline.set_end_time(end_time_code / timeline.get_time_codes_per_second())
