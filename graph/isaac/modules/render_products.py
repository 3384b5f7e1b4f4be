"""`isaacsim.core.utils.render_product`: cameras and sizes of render products."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import inert

from .viewport_manager import ViewportManager

__all__ = ["add_aov", "get_camera_prim_path", "get_resolution", "set_camera_prim_path", "set_resolution"]


def _product(path: str) -> Any:
    """The product's schema. Raises RuntimeError for another path."""
    found = ViewportManager.get_render_product(path)
    if found is None:
        raise RuntimeError(f"{path} is not the path of a render product")
    return found


@inert("isaacsim.core.utils.render_product")
def add_aov(render_product_path: str, aov_name: str) -> None:
    _product(render_product_path)


def get_camera_prim_path(render_product_path: str) -> str:
    return str(next(iter(_product(render_product_path).GetCameraRel().GetTargets()), ""))


def set_camera_prim_path(render_product_path: str, camera_prim_path: str) -> None:
    try:
        ViewportManager.set_camera(camera_prim_path, render_product_or_viewport=_product(render_product_path))
    except ValueError as error:
        raise RuntimeError(str(error)) from None


def get_resolution(render_product_path: str) -> tuple[int, int]:
    return ViewportManager.get_resolution(_product(render_product_path))


def set_resolution(render_product_path: str, resolution: Any) -> None:
    ViewportManager.set_resolution(resolution, render_product_or_viewport=_product(render_product_path))
