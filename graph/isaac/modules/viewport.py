"""`omni.kit.viewport.utility` and `isaacsim.core.utils.viewports`: cameras and render products; nothing is shown."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.isaac.outcomes import tell_inert
from graph.isaac.session import app, kit
from graph.sim.usd import Gf, Sdf, Usd, UsdGeom
from nodes.isaac.viewports import DEFAULT, PERSPECTIVE, SIZE, open_viewport, viewports_of
from sensors.products import place_product

from .transforms import look_at_quaternion, rotation_order
from .xforms import put

__all__ = [
    "ViewportAPI",
    "add_aov_to_viewport",
    "capture_viewport_to_file",
    "create_viewport_for_camera",
    "create_viewport_window",
    "destroy_all_viewports",
    "frame_viewport_selection",
    "get_active_viewport",
    "get_active_viewport_and_window",
    "get_active_viewport_window",
    "get_camera_position",
    "get_camera_target",
    "get_id_from_index",
    "get_intrinsics_matrix",
    "get_num_viewports",
    "get_viewport_from_window_name",
    "get_viewport_names",
    "get_window_from_id",
    "set_active_viewport_camera",
    "set_camera_view",
    "set_intrinsics_matrix",
]


class ViewportAPI:
    """A viewport, the one that nodes have by that name too; its render product is made when a script asks for it."""

    def __init__(self, title: str = DEFAULT, camera: str = "", resolution: Any = None) -> None:
        self.title = self.name = title
        self._held = open_viewport(app(), title)
        self._show(camera or self._held.camera, tuple(resolution or self._held.size))
        self.updates_enabled = self.visible = True
        self.id = title
        self.frame_info: dict[str, Any] = {}

    @property
    def viewport_api(self) -> ViewportAPI:
        return self

    @property
    def stage(self) -> Any:
        return app().stage

    def _show(self, camera: str, size: Any) -> None:
        """Gives the viewport a camera and a size, and its render product, if there is one, too."""
        held, product = self._held, app().rendering.products.get(self._held.path)
        held.camera, held.size = camera, tuple(size)
        if product is not None and camera and (product.camera_path, product.resolution) != (camera, held.size):
            place_product(app().world, held.path, camera, held.size)

    @property
    def camera_path(self) -> Any:
        return Sdf.Path(self._held.camera or PERSPECTIVE)

    @camera_path.setter
    def camera_path(self, path: Any) -> None:
        self._show(str(path), self._held.size)

    def get_active_camera(self) -> Any:
        return self.camera_path

    def set_active_camera(self, path: Any) -> None:
        self.camera_path = path

    @property
    def resolution(self) -> tuple[int, int]:
        return self._held.size

    @resolution.setter
    def resolution(self, size: Any) -> None:
        self._show(self._held.camera, size)

    def set_texture_resolution(self, resolution: Any) -> None:
        self.resolution = resolution

    def get_texture_resolution(self) -> tuple[int, int]:
        return self._held.size

    @property
    def render_product_path(self) -> str:
        held, camera = self._held, str(self.camera_path)
        product = app().rendering.products.get(held.path)
        if product is None or not product.camera_path:
            camera = camera if app().stage.GetPrimAtPath(camera) else PERSPECTIVE  # of a stage that is closed
            place_product(app().world, held.path, camera, held.size)
        return held.path

    def get_render_product_path(self) -> str:
        return self.render_product_path

    async def wait_for_rendered_frames(self, additional_frames: int = 0) -> None:
        await kit().next_update()

    async def wait_for_render_settings_change(self) -> None:
        await kit().next_update()

    def schedule_capture(self, *_: Any, **__: Any) -> None:
        tell_inert("omni.kit.viewport.utility.ViewportAPI.schedule_capture")

    def destroy(self) -> None:
        held = viewports()
        held[:] = [one for one in held if one is not self]
        viewports_of(app()).pop(self.title, None)


def viewports() -> list[ViewportAPI]:
    """The open ones, those that nodes have made too; there is one from the start."""
    found, titles = kit().viewports, [one.title for one in kit().viewports]
    found += [ViewportAPI(name) for name in list(viewports_of(app())) if name not in titles]
    return found


def opened(title: Any = None, camera: Any = None, resolution: Any = SIZE) -> ViewportAPI:
    """A further viewport; without a title it has a number."""
    taken, number = {one.title for one in viewports()}, 2
    while f"Viewport {number}" in taken:
        number += 1
    made = ViewportAPI(str(title or f"Viewport {number}"), str(camera or ""), resolution)
    kit().viewports.append(made)
    return made


def get_active_viewport(usd_context_name: str = "") -> Any:
    return next(iter(viewports()), None)


def get_active_viewport_window(*_: Any, **__: Any) -> Any:
    return get_active_viewport()


def get_active_viewport_and_window(*_: Any, **__: Any) -> tuple[Any, Any]:
    return get_active_viewport(), get_active_viewport()


def get_viewport_from_window_name(window_name: Any = None) -> Any:
    named = [one for one in viewports() if one.title == window_name]
    return next(iter(named), None) if window_name else get_active_viewport()


def create_viewport_window(
    name: Any = None, *_: Any, width: int = 1280, height: int = 720, camera_path: Any = None, **__: Any
) -> Any:
    return opened(name, camera_path, (width, height))


def create_viewport_for_camera(
    viewport_name: str, camera_prim_path: str, width: int = 1280, height: int = 720, *_: Any, **__: Any
) -> ViewportAPI:
    return opened(viewport_name, camera_prim_path, (width, height))


def frame_viewport_selection(*_: Any, **__: Any) -> bool:
    tell_inert("omni.kit.viewport.utility.frame_viewport_selection")
    return False


def capture_viewport_to_file(*_: Any, **__: Any) -> None:
    tell_inert("omni.kit.viewport.utility.capture_viewport_to_file")


def add_aov_to_viewport(*_: Any, **__: Any) -> bool:
    tell_inert("omni.kit.viewport.utility.add_aov_to_viewport")
    return True


def set_camera_view(
    eye: Any = None, target: Any = None, camera_prim_path: Any = PERSPECTIVE, viewport_api: Any = None, **_: Any
) -> None:
    """Places the camera, which a camera sensor on it sees."""
    prim = app().stage.GetPrimAtPath(str(camera_prim_path))
    if prim and eye is not None:
        turn = None if target is None else look_at_quaternion(list(eye), list(target)).numpy()
        put_camera(prim, list(eye), turn)


def edited(prim: Any) -> Any:
    """The context in which edits of a prim act: that of the session layer if this one has it."""
    stage = prim.GetStage()
    session = stage.GetSessionLayer()
    return Usd.EditContext(
        stage, session if session.GetPrimAtPath(prim.GetPath()) else stage.GetEditTarget().GetLayer()
    )


def put_camera(prim: Any, position: Any, orientation: Any) -> None:
    """Places a camera in the world, in the layer that has it; rotations about axes stay such."""
    with edited(prim):
        turned = [op for op in UsdGeom.Xformable(prim).GetOrderedXformOps() if rotation_order(op)]
        if not turned:
            return put(prim, position=position, orientation=orientation)
        place, turn = _below_parent(prim, position, orientation)
        UsdGeom.XformCommonAPI(prim).SetTranslate(place)
        if orientation is not None:
            order = rotation_order(turned[0])
            axes = [getattr(Gf.Vec3d, f"{axis}Axis")() for axis in reversed(order)]
            angles = dict(zip(reversed(order), _smaller(*turn.Decompose(*axes)), strict=True))
            turned[0].Set(type(turned[0].Get() or Gf.Vec3d())(*(angles[axis] for axis in "XYZ")))


def _smaller(first: float, second: float, third: float) -> tuple[float, float, float]:
    """Of the two sets of angles [degrees] that turn alike, the one that turns less in sum."""
    half = (math.remainder(first - 180, 360), math.remainder(180 - second, 360), math.remainder(third - 180, 360))
    given = (first, second, third)
    return half if sum(map(abs, half)) < sum(map(abs, given)) else given


def _below_parent(prim: Any, position: Any, orientation: Any) -> tuple[Any, Any]:
    """Translation and rotation of a place in the world."""
    w, x, y, z = map(float, (1, 0, 0, 0) if orientation is None else orientation)
    world = Gf.Matrix4d(Gf.Rotation(Gf.Quatd(w, x, y, z)), Gf.Vec3d(*map(float, position)))
    local = world * UsdGeom.Xformable(prim).ComputeParentToWorldTransform(0).GetInverse()
    return local.ExtractTranslation(), local.ExtractRotation()


def get_camera_position(camera_prim: Any) -> Any:
    from .xforms import world_parts

    return world_parts(str(camera_prim.GetPath()))[0]


def get_camera_target(camera_prim: Any) -> Any:
    from .xforms import get_world_pose

    position, orientation = get_world_pose(camera_prim)
    from .transforms import quat_to_rot_matrix

    return position.numpy() - quat_to_rot_matrix(orientation)[:, 2]


def get_intrinsics_matrix(viewport_api: Any) -> Any:
    camera = UsdGeom.Camera(app().stage.GetPrimAtPath(str(viewport_api.camera_path)))
    width, height = viewport_api.resolution
    focal, aperture = camera.GetFocalLengthAttr().Get(), camera.GetHorizontalApertureAttr().Get()
    pixels = width * focal / aperture
    return np.array([[pixels, 0, width / 2], [0, pixels, height / 2], [0, 0, 1]])


def set_intrinsics_matrix(viewport_api: Any, intrinsics_matrix: Any, focal_length: float = 1.0) -> None:
    camera = UsdGeom.Camera(app().stage.GetPrimAtPath(str(viewport_api.camera_path)))
    width, height = viewport_api.resolution
    with edited(camera.GetPrim()):
        camera.CreateFocalLengthAttr().Set(float(focal_length))
        camera.CreateHorizontalApertureAttr().Set(float(width * focal_length / intrinsics_matrix[0, 0]))
        camera.CreateVerticalApertureAttr().Set(float(height * focal_length / intrinsics_matrix[1, 1]))


def set_active_viewport_camera(camera_prim_path: str) -> None:
    get_active_viewport().set_active_camera(camera_prim_path)


def get_viewport_names(usd_context_name: str | None = None) -> list[str]:
    return [one.title for one in viewports()]


def get_num_viewports(*_: Any) -> int:
    return len(viewports())


def get_id_from_index(index: int) -> Any:
    return next((one.id for one in viewports()[index : index + 1]), None)


def get_window_from_id(id: Any, usd_context_name: str | None = None) -> Any:
    return next((one for one in viewports() if one.id == id), None)


def destroy_all_viewports(usd_context_name: Any = None, destroy_main_viewport: bool = True) -> None:
    for one in viewports()[0 if destroy_main_viewport else 1 :]:
        one.destroy()
