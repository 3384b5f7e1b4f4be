"""Viewports: their cameras and render products are there, nothing is shown."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import app, kit
from graph.sim.usd import Sdf, UsdGeom

from .transforms import look_at_quaternion
from .xforms import put

__all__ = [
    "ViewportAPI",
    "ViewportManager",
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
PERSPECTIVE = "/OmniverseKit_Persp"


class ViewportAPI:
    """The one viewport: a camera and a size; its render product is made when a script asks for it."""

    def __init__(self, title: str = "Viewport", camera: str = PERSPECTIVE, resolution: Any = (1280, 720)) -> None:
        self.title = self.name = title
        self._camera, self._size = camera, tuple(resolution)
        self.updates_enabled = self.visible = True
        self.id = title
        self.frame_info: dict[str, Any] = {}

    @property
    def viewport_api(self) -> ViewportAPI:
        return self

    @property
    def stage(self) -> Any:
        return app().stage

    @property
    def camera_path(self) -> Any:
        return Sdf.Path(self._camera)

    @camera_path.setter
    def camera_path(self, path: Any) -> None:
        self._camera = str(path)

    def get_active_camera(self) -> Any:
        return self.camera_path

    def set_active_camera(self, path: Any) -> None:
        self._camera = str(path)

    @property
    def resolution(self) -> tuple[int, int]:
        return self._size

    @resolution.setter
    def resolution(self, size: Any) -> None:
        self._size = tuple(size)

    def set_texture_resolution(self, resolution: Any) -> None:
        self._size = tuple(resolution)

    def get_texture_resolution(self) -> tuple[int, int]:
        return self._size

    @property
    def render_product_path(self) -> str:
        from sensors.products import render_product

        return render_product(app(), self._camera, self._size).path

    def get_render_product_path(self) -> str:
        return self.render_product_path

    async def wait_for_rendered_frames(self, additional_frames: int = 0) -> None:
        await kit().next_update()

    async def wait_for_render_settings_change(self) -> None:
        await kit().next_update()

    def schedule_capture(self, *_: Any, **__: Any) -> None:
        tell_inert("omni.kit.viewport.utility.ViewportAPI.schedule_capture")

    @inert("omni.kit.viewport.utility")
    def destroy(self) -> None:
        return None


def get_active_viewport(usd_context_name: str = "") -> ViewportAPI:
    return kit().singleton(ViewportAPI, ViewportAPI)


def get_active_viewport_window(*_: Any, **__: Any) -> ViewportAPI:
    return get_active_viewport()


def get_active_viewport_and_window(*_: Any, **__: Any) -> tuple[ViewportAPI, ViewportAPI]:
    return get_active_viewport(), get_active_viewport()


def get_viewport_from_window_name(window_name: Any = None) -> ViewportAPI:
    return get_active_viewport()


def create_viewport_window(
    name: Any = None, *_: Any, width: int = 1280, height: int = 720, camera_path: Any = None, **__: Any
) -> Any:
    return ViewportAPI(str(name or "Viewport 2"), str(camera_path or PERSPECTIVE), (width, height))


def create_viewport_for_camera(
    viewport_name: str, camera_prim_path: str, width: int = 1280, height: int = 720, *_: Any, **__: Any
) -> ViewportAPI:
    return ViewportAPI(viewport_name, camera_prim_path, (width, height))


def frame_viewport_selection(*_: Any, **__: Any) -> bool:
    tell_inert("omni.kit.viewport.utility.frame_viewport_selection")
    return False


def capture_viewport_to_file(*_: Any, **__: Any) -> None:
    tell_inert("omni.kit.viewport.utility.capture_viewport_to_file")


def add_aov_to_viewport(*_: Any, **__: Any) -> bool:
    tell_inert("omni.kit.viewport.utility.add_aov_to_viewport")
    return True


def set_camera_view(
    eye: Any = None, target: Any = None, camera_prim_path: str = PERSPECTIVE, viewport_api: Any = None, **_: Any
) -> None:
    """Places the camera, which a camera sensor on it sees."""
    prim = app().stage.GetPrimAtPath(str(camera_prim_path))
    if prim and eye is not None:
        turn = None if target is None else look_at_quaternion(list(eye), list(target))
        from graph.sim.usd import Usd

        session = app().stage.GetSessionLayer()
        layer = session if session.GetPrimAtPath(prim.GetPath()) else app().stage.GetEditTarget().GetLayer()
        with Usd.EditContext(app().stage, layer):
            put(prim, position=list(eye), orientation=turn)


def get_camera_position(camera_prim: Any) -> Any:
    from .xforms import world_parts

    return world_parts(str(camera_prim.GetPath()))[0]


def get_camera_target(camera_prim: Any) -> Any:
    from .xforms import get_world_pose

    position, orientation = get_world_pose(camera_prim)
    from .transforms import quat_to_rot_matrix

    return position.numpy() - quat_to_rot_matrix(orientation)[:, 2]


def get_intrinsics_matrix(viewport_api: Any) -> Any:
    import numpy as np

    camera = UsdGeom.Camera(app().stage.GetPrimAtPath(str(viewport_api.camera_path)))
    width, height = viewport_api.resolution
    focal, aperture = camera.GetFocalLengthAttr().Get(), camera.GetHorizontalApertureAttr().Get()
    pixels = width * focal / aperture
    return np.array([[pixels, 0, width / 2], [0, pixels, height / 2], [0, 0, 1]])


def set_intrinsics_matrix(viewport_api: Any, intrinsics_matrix: Any, focal_length: float = 1.0) -> None:
    camera = UsdGeom.Camera(app().stage.GetPrimAtPath(str(viewport_api.camera_path)))
    width, height = viewport_api.resolution
    camera.CreateFocalLengthAttr().Set(float(focal_length))
    camera.CreateHorizontalApertureAttr().Set(float(width * focal_length / intrinsics_matrix[0, 0]))
    camera.CreateVerticalApertureAttr().Set(float(height * focal_length / intrinsics_matrix[1, 1]))


def set_active_viewport_camera(camera_path: str, *_: Any) -> None:
    get_active_viewport().set_active_camera(camera_path)


def get_viewport_names(*_: Any) -> list[str]:
    return ["Viewport"]


def get_num_viewports(*_: Any) -> int:
    return 1


def get_id_from_index(index: int) -> Any:
    return index


def get_window_from_id(id: Any, *_: Any) -> Any:
    return get_active_viewport()


@inert("omni.kit.viewport.utility")
def destroy_all_viewports(*_: Any, **__: Any) -> None:
    return None


class ViewportManager:
    @classmethod
    def set_camera_view(
        cls, camera: Any, *, eye: Any = None, target: Any = None, relative_tracking: bool = False
    ) -> None:
        path = camera if isinstance(camera, str) else str(camera.GetPath())
        set_camera_view(_plain(eye), _plain(target), path)

    @classmethod
    def get_viewport_api(cls, render_product_or_viewport: Any = None) -> ViewportAPI:
        return get_active_viewport()

    @classmethod
    def get_camera(cls, render_product_or_viewport: Any = None) -> Any:
        return UsdGeom.Camera(app().stage.GetPrimAtPath(str(get_active_viewport().camera_path)))

    @classmethod
    def set_camera(cls, camera: Any, *, render_product_or_viewport: Any = None) -> None:
        get_active_viewport().set_active_camera(camera if isinstance(camera, str) else str(camera.GetPath()))

    @classmethod
    def get_resolution(cls, render_product_or_viewport: Any = None) -> tuple[int, int]:
        return get_active_viewport().resolution

    @classmethod
    def set_resolution(cls, resolution: Any, *, render_product_or_viewport: Any = None) -> None:
        get_active_viewport().set_texture_resolution(resolution)

    @classmethod
    def get_render_product(cls, render_product_or_viewport: Any = None) -> Any:
        from graph.sim.usd import UsdRender

        return UsdRender.Product(app().stage.GetPrimAtPath(get_active_viewport().render_product_path))

    @classmethod
    def create_viewport_window(
        cls, *, camera: Any = PERSPECTIVE, title: Any = None, resolution: Any = (1280, 720)
    ) -> Any:
        path = camera if isinstance(camera, str) else str(camera.GetPath())
        return ViewportAPI(str(title or "Viewport 2"), path, resolution)

    @classmethod
    @inert("isaacsim.core.rendering_manager")
    def destroy_viewport_windows(cls, *, include: Any = None, exclude: Any = None) -> list[str]:
        return []

    @classmethod
    def get_viewport_windows(cls, *, include: Any = None, exclude: Any = None) -> list[Any]:
        return [get_active_viewport()]

    @classmethod
    def wait_for_viewport(
        cls, *, viewport: Any = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        kit().update()
        return True, 1

    @classmethod
    async def wait_for_viewport_async(
        cls, *, viewport: Any = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        await kit().next_update()
        return True, 1


def _plain(values: Any) -> Any:
    return None if values is None else [float(one) for one in (values.numpy() if hasattr(values, "numpy") else values)]
