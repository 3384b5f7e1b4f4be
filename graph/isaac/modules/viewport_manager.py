"""`ViewportManager` of `isaacsim.core.rendering_manager`."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from graph.isaac.results import array
from graph.isaac.session import app, kit
from graph.sim.transforms import quaternion
from graph.sim.usd import Gf, UsdGeom, UsdRender
from nodes.isaac.viewports import PERSPECTIVE

from .prim_utils import get_prim_path
from .viewport import ViewportAPI, edited, get_active_viewport, opened, put_camera, viewports
from .xforms import world_parts

__all__ = ["ViewportManager"]
INTEREST = "omni:kit:centerOfInterest"


class ViewportManager:
    """A source is a viewport, its title, or a render product by its path, prim or schema; None: the active viewport."""

    @classmethod
    def set_camera_view(
        cls, camera: Any, *, eye: Any = None, target: Any = None, relative_tracking: bool = False
    ) -> None:
        """Moves a camera and turns it to a target, or to the point of interest that its prim stores.

        relative_tracking: moves it by as much as the target is away from that point, instead of turning it.
        """
        prim = app().stage.GetPrimAtPath(get_prim_path(camera))
        position, orientation = world_parts(str(prim.GetPath()))
        stored = prim.GetAttribute(INTEREST)
        interest = array(stored.Get(), float) if stored and stored.Get() is not None else None
        goal = interest if target is None else array(target, float)
        if eye is not None:
            position = array(eye, float)
        elif relative_tracking and target is not None and interest is not None:
            position = position + goal - interest
        if goal is not None:
            orientation = _aimed(goal - position)
        put_camera(prim, position, orientation)
        if interest is not None and target is not None and goal is not None:
            stored.Set(Gf.Vec3d(*map(float, goal)))

    @classmethod
    def get_viewport_api(cls, render_product_or_viewport: Any = None) -> Any:
        if render_product_or_viewport is None:
            return get_active_viewport()
        if isinstance(render_product_or_viewport, ViewportAPI):
            return render_product_or_viewport
        return next((one for one in viewports() if one.title == render_product_or_viewport), None)

    @classmethod
    def get_render_product(cls, render_product_or_viewport: Any = None) -> Any:
        viewport = cls.get_viewport_api(render_product_or_viewport)
        path = get_prim_path(render_product_or_viewport) if viewport is None else viewport.render_product_path
        prim = app().stage.GetPrimAtPath(path) if path.startswith("/") else None
        return UsdRender.Product(prim) if prim and prim.IsA(UsdRender.Product) else None

    @classmethod
    def get_camera(cls, render_product_or_viewport: Any = None) -> Any:
        viewport, product = cls._source(render_product_or_viewport, "get the camera")
        path = viewport.camera_path if viewport else next(iter(product.GetCameraRel().GetTargets()), PERSPECTIVE)
        return UsdGeom.Camera(app().stage.GetPrimAtPath(str(path)))

    @classmethod
    def set_camera(cls, camera: Any, *, render_product_or_viewport: Any = None) -> None:
        path = get_prim_path(camera)
        prim = app().stage.GetPrimAtPath(path)
        if not prim or not prim.IsA(UsdGeom.Camera):
            raise ValueError(f"{path} is not a valid USD Camera prim")
        viewport, product = cls._source(render_product_or_viewport, "set the camera")
        if viewport:
            viewport.set_active_camera(path)
            return
        if not _placed(product, camera=path):
            with edited(product.GetPrim()):
                product.GetCameraRel().SetTargets([path])

    @classmethod
    def get_resolution(cls, render_product_or_viewport: Any = None) -> tuple[int, int]:
        viewport, product = cls._source(render_product_or_viewport, "get resolution")
        width, height = viewport.resolution if viewport else product.GetResolutionAttr().Get()
        return int(width), int(height)

    @classmethod
    def set_resolution(cls, resolution: Any, *, render_product_or_viewport: Any = None) -> None:
        size = tuple(int(one) for one in array(resolution))
        viewport, product = cls._source(render_product_or_viewport, "set resolution")
        if viewport:
            viewport.set_texture_resolution(size)
            return
        if not _placed(product, size=size):
            with edited(product.GetPrim()):
                product.GetResolutionAttr().Set(Gf.Vec2i(*size))

    @classmethod
    def _source(cls, source: Any, what: str) -> tuple[Any, Any]:
        """The viewport or the render product. Raises ValueError for neither."""
        viewport = cls.get_viewport_api(source)
        product = None if viewport else cls.get_render_product(source)
        if viewport is None and product is None:
            raise ValueError(f"Unable to {what}: unknown viewport or render product {source}")
        return viewport, product

    @classmethod
    def create_viewport_window(
        cls, *, camera: Any = PERSPECTIVE, title: Any = None, resolution: Any = (1280, 720)
    ) -> Any:
        return opened(title, get_prim_path(camera), resolution)

    @classmethod
    def get_viewport_windows(cls, *, include: Any = None, exclude: Any = None) -> list[Any]:
        """Those whose whole title matches an expression, sorted by title if expressions are given."""
        fitting = [
            one for one in viewports() if _fits(one.title, include, True) and not _fits(one.title, exclude, False)
        ]
        return fitting if include is None else sorted(fitting, key=lambda one: one.title)

    @classmethod
    def destroy_viewport_windows(cls, *, include: Any = None, exclude: Any = None) -> list[str]:
        gone = [one for one in viewports() if one in cls.get_viewport_windows(include=include, exclude=exclude)]
        for one in gone:
            one.destroy()
        return [one.title for one in gone]

    @classmethod
    def wait_for_viewport(
        cls, *, viewport: Any = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        if max_frames < 1:
            return False, 0
        kit().update()
        return True, 1

    @classmethod
    async def wait_for_viewport_async(
        cls, *, viewport: Any = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        if max_frames < 1:
            return False, 0
        await kit().next_update()
        return True, 1


def _placed(product: Any, camera: str | None = None, size: Any = None) -> bool:
    """Whether a prim's render product is one of the App, which now renders that camera at that size."""
    from sensors.products import place_product

    held = app().rendering.products.get(str(product.GetPath()))
    if held is None:
        return False
    wanted = camera or held.camera_path, size or held.resolution
    if wanted != (held.camera_path, held.resolution):
        place_product(app().world, held.path, *wanted)
    return True


def _fits(title: str, expressions: Any, otherwise: bool) -> bool:
    return otherwise if expressions is None else any(re.fullmatch(one, title) for one in expressions)


def _aimed(way: np.ndarray) -> np.ndarray:
    """w, x, y, z of a camera that looks along `way` with its own up as near to +Z as can be; along X for no way."""
    yaw, across = math.atan2(way[1], way[0]), math.hypot(way[0], way[1])
    pitch = math.atan2(way[2], across)
    forward = np.array([math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)])
    right = np.array([math.sin(yaw), -math.cos(yaw), 0.0])
    return quaternion(np.stack([right, np.cross(right, forward), -forward], axis=1))
