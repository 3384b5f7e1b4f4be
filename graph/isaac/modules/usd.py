"""`omni.usd`: the stage of the App."""

from __future__ import annotations

from enum import IntEnum
from pathlib import Path
from typing import Any

from graph.base.errors import UserError
from graph.isaac import saving
from graph.isaac.assets import found_asset, local_path, missing
from graph.isaac.events import EventStream
from graph.isaac.outcomes import inert
from graph.isaac.session import app, app_or_none, kit
from graph.sim.scene.assets import stand_in
from graph.sim.usd import Gf, Sdf, Usd, UsdGeom, UsdUtils

from .references import take_addresses

__all__ = [
    "Selection",
    "StageEventType",
    "StageRenderingEventType",
    "StageState",
    "UsdContext",
    "UsdContextInitialLoadSet",
    "check_ancestral",
    "create_material_input",
    "duplicate_prim",
    "get_context",
    "get_context_from_stage",
    "get_local_transform_SRT",
    "get_local_transform_matrix",
    "get_prim_at_path",
    "get_stage_next_free_path",
    "get_world_transform_matrix",
    "is_path_valid",
    "make_path_relative_to_current_edit_target",
    "resolve_paths",
]
take_addresses(found_asset)
StageEventType = IntEnum(
    "StageEventType",
    "SAVED SAVE_FAILED OPENING OPENED OPEN_FAILED CLOSING CLOSED SELECTION_CHANGED ASSETS_LOADED ASSETS_LOAD_ABORTED "
    "GIZMO_TRACKING_CHANGED MDL_PARAM_LOADED SETTINGS_LOADED SETTINGS_SAVING OMNIGRAPH_START_PLAY OMNIGRAPH_STOP_PLAY "
    "SIMULATION_START_PLAY SIMULATION_STOP_PLAY ANIMATION_START_PLAY ANIMATION_STOP_PLAY DIRTY_STATE_CHANGED "
    "ASSETS_LOADING ACTIVE_LIGHT_COUNTS_CHANGED HIERARCHY_CHANGED HYDRA_GEOSTREAMING_STARTED",
    start=0,
)
StageRenderingEventType = IntEnum("StageRenderingEventType", "NEW_FRAME HYDRA_ENGINE_FRAMES_COMPLETE", start=0)
StageState = IntEnum("StageState", "CLOSED OPENING OPENED CLOSING", start=0)
UsdContextInitialLoadSet = IntEnum("UsdContextInitialLoadSet", "LOAD_ALL LOAD_NONE", start=0)


class Selection:
    def __init__(self) -> None:
        self._paths: list[str] = []

    def get_selected_prim_paths(self, *_: Any) -> list[str]:
        return list(self._paths)

    def set_selected_prim_paths(self, paths: list[str], *_: Any, **__: Any) -> bool:
        self._paths = list(map(str, paths))
        return True

    def clear_selected_prim_paths(self, *_: Any) -> bool:
        self._paths = []
        return True

    def set_prim_path_selected(self, path: str, selected: bool, *_: Any) -> bool:
        self._paths = [one for one in self._paths if one != path] + [path] * selected
        return True


class UsdContext:
    def __init__(self) -> None:
        self.selection = Selection()

    def get_stage(self) -> Any:
        found = app_or_none()
        return None if found is None or kit().stage_closed else found.stage

    def get_stage_id(self) -> int:
        cache = UsdUtils.StageCache.Get()
        return int(cache.Insert(app().stage).ToLongInt())

    def get_stage_url(self) -> str:
        return kit().stage_url or f"anon:{id(app().stage):x}:World0.usd"

    def get_stage_state(self) -> Any:
        return StageState["CLOSED" if kit().stage_closed else "OPENED"]

    def get_name(self) -> str:
        return ""

    def new_stage(self, on_finish_fn: Any = None) -> bool:
        return _take(None, on_finish_fn)

    def open_stage(self, url: str, on_finish_fn: Any = None, load_set: Any = None) -> bool:
        return _take(str(url), on_finish_fn)

    def reopen_stage(self, on_finish_fn: Any = None, load_set: Any = None) -> bool:
        return _take(kit().stage_url or None, on_finish_fn)

    def close_stage(self, on_finish_fn: Any = None) -> bool:
        done = _take(None)
        kit().stage_closed = True
        return _told(on_finish_fn, done)

    async def new_stage_async(self) -> tuple[bool, str]:
        return await _later(None)

    async def open_stage_async(self, url: str, load_set: Any = None) -> tuple[bool, str]:
        return await _later(str(url))

    async def close_stage_async(self) -> tuple[bool, str]:
        return self.close_stage(), ""

    async def reopen_stage_async(self) -> tuple[bool, str]:
        return await _later(kit().stage_url or None)

    def save_stage(self, on_finish_fn: Any = None) -> bool:
        return bool(kit().stage_url) and _told(on_finish_fn, save(kit().stage_url, flat=False))

    def save_as_stage(self, url: str, on_finish_fn: Any = None) -> bool:
        return _told(on_finish_fn, save(url))

    def export_as_stage(self, url: str, on_finish_fn: Any = None) -> bool:
        return _told(on_finish_fn, save(url))

    async def save_as_stage_async(self, url: str) -> tuple[bool, str, list[str]]:
        done = save(url)
        return done, "" if done else f"{url} cannot be written", [url] if done else []

    async def export_as_stage_async(self, url: str) -> tuple[bool, str]:
        done = save(url)
        return done, "" if done else f"{url} cannot be written"

    def get_stage_loading_status(self) -> tuple[str, int, int]:
        return "", 0, 0

    def can_open_stage(self) -> bool:
        return True

    can_close_stage = can_save_stage = is_writable = can_open_stage

    def is_new_stage(self) -> bool:
        return not kit().stage_url

    def has_pending_edit(self) -> bool:
        return False

    @inert("omni.usd")
    def set_pending_edit(self, _: bool) -> None:
        return None

    def get_selection(self) -> Selection:
        return self.selection

    def get_timeline(self) -> Any:
        from .timeline import get_timeline_interface

        return get_timeline_interface()

    def get_stage_event_stream(self) -> EventStream:
        return kit().stage_events

    def get_rendering_event_stream(self) -> EventStream:
        return kit().other_events

    def stage_event_name(self, event: Any) -> str:
        return f"omni.usd:{StageEventType(event).name.lower()}"

    def stage_event_type(self, event: str) -> Any:
        return StageEventType[event.rpartition(":")[2].upper()]

    def stage_rendering_event_name(self, event: Any, immediate: bool = False) -> str:
        return f"omni.usd:rendering:{StageRenderingEventType(event).name.lower()}"

    @inert("omni.usd")
    def disable_save_to_recent_files(self) -> None: ...

    @inert("omni.usd")
    def enable_save_to_recent_files(self) -> None: ...

    def compute_path_world_transform(self, path: str) -> list[float]:
        matrix = get_world_transform_matrix(app().stage.GetPrimAtPath(path))
        return [matrix[row][column] for row in range(4) for column in range(4)]

    def compute_path_world_bounding_box(self, path: str) -> tuple[Any, Any]:
        box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default", "render", "proxy"])
        found = box.ComputeWorldBound(app().stage.GetPrimAtPath(path)).ComputeAlignedRange()
        return found.GetMin(), found.GetMax()


_CONTEXT = UsdContext()


def get_context(name: str = "") -> UsdContext:
    return _CONTEXT


def get_context_from_stage(stage: Any) -> UsdContext | None:
    found = app_or_none()
    return _CONTEXT if found is not None and found.stage == stage else None


def _take(url: str | None, on_finish: Any = None) -> bool:
    """Opens a file, or an empty stage; what belongs to the former stage ends."""
    from graph.isaac.viewports import author_cameras
    from graph.session.restage import open_scene

    present, beside = app(), kit()
    beside.stage_events.dispatch(StageEventType["CLOSING"])
    beside.dispatcher.dispatch_event("omni.usd:closing", {})
    try:
        if url is None:
            present.take_stage(None)
        else:
            file = local_path(url)
            if file is None and (found := stand_in(url)) is not None:
                code, message = found.note()
                present.take_stage(None)
                present.stage.GetRootLayer().TransferContent(found.layer)
                present.warn(code, "the stage", f"{url}: {message}")
            elif file is None:
                missing(url, "the stage")
                return _told(on_finish, False)
            else:
                open_scene(present, file)
                saving.opened(present.stage, file)
    except UserError as error:
        present.warn("stage-not-opened", url or "new stage", str(error))
        return _told(on_finish, False)
    beside.stage_url, beside.stage_closed = url or "", False
    beside.singletons.clear()
    author_cameras(present.stage)
    for event in ("CLOSED", "OPENED", "ASSETS_LOADED"):
        beside.stage_events.dispatch(StageEventType[event])
        beside.dispatcher.dispatch_event(f"omni.usd:{event.lower()}", {})
    return _told(on_finish, True)


async def _later(url: str | None) -> tuple[bool, str]:
    done = _take(url)
    return done, "" if done else f"{url} cannot be opened"


def _told(on_finish: Any, done: bool) -> bool:
    if on_finish is not None:
        on_finish(done, "" if done else "failed")
    return done


def save(url: str, *, flat: bool = True) -> bool:
    """Writes the stage, flattened or with its references, to a local file."""
    from graph.base.outputs import check_no_link

    if "://" in url:
        app().warn("stage-not-saved", url, "remote addresses cannot be written; give a local file")
        return False
    try:
        if not flat and (file := local_path(url)) is not None:
            saving.write(app().stage, Path(file))
            return True
        check_no_link(Path(url))
        if not app().stage.Flatten().Export(url):
            raise OSError("USD cannot write this file")
    except (OSError, UserError) as error:
        app().warn("stage-not-saved", url, str(error))
        return False
    return True


def get_prim_at_path(path: Any, usd_context_name: Any = "") -> Any:
    return app().stage.GetPrimAtPath(path)


def is_path_valid(path: Any) -> bool:
    return bool(Sdf.Path.IsValidPathString(str(path)))


def create_material_input(
    prim: Any,
    name: str,
    value: Any,
    vtype: Any,
    def_value: Any = None,
    min_value: Any = None,
    max_value: Any = None,
    display_name: str | None = None,
    display_group: str | None = None,
    color_space: str | None = None,
) -> Any:
    """Sets an input of a shader, or of the shader of a material; creates it first where it is missing."""
    from graph.sim.usd import UsdShade

    material = UsdShade.Material(prim)
    found = (
        (material.ComputeSurfaceSource(context)[0] for context in ("mdl", "")) if material else (UsdShade.Shader(prim),)
    )
    shader = next(filter(None, found), None)
    if shader is None:
        raise ValueError(f"{prim.GetPath()} is neither a shader nor a material with one")
    made = shader.CreateInput(name, vtype)
    made.Set(value)
    limits = {key: one for key, one in (("min", min_value), ("max", max_value)) if one is not None}
    for key, one in (("default", def_value), ("range", limits or None)):
        if one is not None:
            made.GetAttr().SetCustomDataByKey(key, one)
    for put, text in ((made.SetDisplayGroup, display_group), (made.GetAttr().SetDisplayName, display_name)):
        if text:
            put(text)
    if color_space:
        made.GetAttr().SetColorSpace(color_space)
    return made


def check_ancestral(prim: Any) -> bool:
    while prim := prim.GetParent():
        if prim.HasAuthoredReferences() or prim.HasAuthoredPayloads():
            return True
    return False


def get_stage_next_free_path(stage: Any, path: Any, prepend_default_prim: bool, source_prim: Any = None) -> str:
    text = str(path) if str(path).startswith("/") else f"/{path}"
    default = stage.GetDefaultPrim()
    if prepend_default_prim and default and not text.startswith(f"{default.GetPath()}/"):
        text = f"{default.GetPath()}{text}"
    free, number = text, 1
    while stage.GetPrimAtPath(free):
        free, number = f"{text}_{number:02}", number + 1
    return free


def get_world_transform_matrix(prim: Any, time_code: Any = None) -> Any:
    """Of the prim's present pose: a moving body's is in Fabric."""
    found = app_or_none()
    path = str(prim.GetPath())
    if found is not None and found.fabric.body_of(path) is not None:
        return Gf.Matrix4d(*(float(one) for one in found.fabric.world_matrix(path).T.reshape(-1)))
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time_code or Usd.TimeCode.Default())


def get_local_transform_matrix(prim: Any, time_code: Any = None) -> Any:
    return UsdGeom.Xformable(prim).GetLocalTransformation(time_code or Usd.TimeCode.Default())


def get_local_transform_SRT(prim: Any, time: Any = None) -> tuple[Any, Any, Any, Any]:
    made = Gf.Transform(get_local_transform_matrix(prim, time))
    angles = made.GetRotation().Decompose(Gf.Vec3d.ZAxis(), Gf.Vec3d.YAxis(), Gf.Vec3d.XAxis())
    return made.GetScale(), Gf.Vec3d(angles[2], angles[1], angles[0]), Gf.Vec3i(0, 1, 2), made.GetTranslation()


def duplicate_prim(stage: Any, prim_path: Any, path_to: Any, duplicate_layers: bool = True) -> bool:
    layer = stage.GetEditTarget().GetLayer()
    source = next((one for one in stage.GetLayerStack() if one.GetPrimAtPath(prim_path)), layer)
    return bool(Sdf.CopySpec(source, Sdf.Path(str(prim_path)), layer, Sdf.Path(str(path_to))))


@inert("omni.usd")
def resolve_paths(src_layer_identifier: str, dst_layer_identifier: str, *_: Any, **__: Any) -> None:
    return None


def make_path_relative_to_current_edit_target(path: str, *_: Any, **__: Any) -> str:
    return path
