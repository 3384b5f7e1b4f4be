"""`isaacsim.sensors.camera`: the Camera class."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.usd import UsdGeom
from sensors.products import product_name, render_product
from sensors.replicator import get_annotator

from .old_prims import SingleXFormPrim
from .transforms import quat_to_rot_matrix, rot_matrix_to_quat

__all__ = ["Camera"]
WORLD = np.array([(0.0, -1, 0), (0, 0, 1), (-1, 0, 0)])
"""Columns: the axes of the world convention (X ahead, Y left, Z up) along the stage's (-Z ahead, X right, Y up)."""
ROS = np.diag([1.0, -1.0, -1.0])
"""The axes of an optical frame of ROS (Z ahead, Y down) along the stage's."""


class Camera(SingleXFormPrim):
    def __init__(
        self,
        prim_path: str,
        name: str = "camera",
        frequency: int | None = None,
        dt: float | None = None,
        resolution: Any = None,
        position: Any = None,
        orientation: Any = None,
        translation: Any = None,
        render_product_path: str | None = None,
        **_: Any,
    ) -> None:
        stage = app().stage
        if not stage.GetPrimAtPath(prim_path):
            camera = UsdGeom.Camera.Define(stage, prim_path)
            camera.CreateClippingRangeAttr().Set((0.05, 1000000.0))
        super().__init__(prim_path, name)
        self._resolution = _size(resolution or (128, 128))
        self._frequency = frequency or (round(1 / dt) if dt else None)
        if position is not None or orientation is not None:
            self.set_world_pose(position, orientation)
        elif translation is not None:
            self.set_local_pose(translation=translation)
        self._render_product_path: str | None = render_product_path
        self._annotators: dict[str, Any] = {}
        self._frame: dict[str, Any] = {}
        self._paused = False

    def initialize(self, physics_sim_view: Any = None, attach_rgb_annotator: bool = True) -> None:
        self._made()
        if attach_rgb_annotator:
            self.attach_annotator("rgb")

    def _made(self) -> str:
        if self._render_product_path is None:
            path, size = self.prim_path, self._resolution
            self._render_product_path = render_product(app(), path, size, product_name(path, size, "camera")).path
        return self._render_product_path

    def get_render_product_path(self) -> str:
        return self._made()

    def attach_annotator(self, annotator_name: str, **kwargs: Any) -> None:
        if annotator_name not in self._annotators:
            made = get_annotator(annotator_name).initialize(**kwargs)
            self._annotators[annotator_name] = made.attach([self._made()])

    def detach_annotator(self, annotator_name: str) -> None:
        found = self._annotators.pop(annotator_name, None)
        if found is not None:
            found.detach()

    def _data(self, annotator: str) -> Any:
        self.attach_annotator(annotator)
        found = self._annotators[annotator].get_data()
        return found["data"] if isinstance(found, dict) and "data" in found else found

    def get_rgba(self, device: Any = None) -> Any:
        return self._data("rgb")

    def get_rgb(self, device: Any = None) -> Any:
        found = self._data("rgb")
        return None if found is None or not len(found) else found[..., :3]

    def get_depth(self, device: Any = None) -> Any:
        return self._data("distance_to_image_plane")

    def get_pointcloud(self, *_: Any, **__: Any) -> Any:
        return self._data("pointcloud")

    def get_current_frame(self, clone: bool = False) -> dict[str, Any]:
        if not self._paused:
            self._frame = {
                "rendering_time": float(app().external_time),
                "rendering_frame": app().update_index,
                **{("rgba" if name == "rgb" else name): self._data(name) for name in self._annotators},
            }
        return dict(self._frame) if clone else self._frame

    def __getattr__(self, name: str) -> Any:
        """`add_distance_to_camera_to_frame`, `remove_...`."""
        if (name.startswith(("add_", "remove_")) and "_to_frame" in name) or name.endswith("_from_frame"):
            short = name.partition("_")[2].removesuffix("_to_frame").removesuffix("_from_frame")
            words = {"motion_vectors": "motion_vectors", "instance_segmentation": "instance_segmentation_fast"}
            call = self.attach_annotator if name.startswith("add_") else self.detach_annotator
            return lambda init_params=None, **__: call(words.get(short, short), **(init_params or {}))
        raise AttributeError(f"Camera has no {name}")

    # -- the prim ------------------------------------------------------------------------------------------------------

    def get_world_pose(self, camera_axes: str = "world") -> tuple[np.ndarray, np.ndarray]:
        position, orientation = super().get_world_pose()
        return position, rot_matrix_to_quat(quat_to_rot_matrix(orientation) @ _axes(camera_axes))

    def set_world_pose(self, position: Any = None, orientation: Any = None, camera_axes: str = "world") -> None:
        super().set_world_pose(position, _turned(orientation, camera_axes))

    def get_local_pose(self, camera_axes: str = "world") -> tuple[np.ndarray, np.ndarray]:
        translation, orientation = super().get_local_pose()
        return translation, rot_matrix_to_quat(quat_to_rot_matrix(orientation) @ _axes(camera_axes))

    def set_local_pose(self, translation: Any = None, orientation: Any = None, camera_axes: str = "world") -> None:
        super().set_local_pose(translation, _turned(orientation, camera_axes))

    @property
    def _camera(self) -> Any:
        return UsdGeom.Camera(self.prim)

    def get_focal_length(self) -> float:
        return float(self._camera.GetFocalLengthAttr().Get()) / 10

    def set_focal_length(self, value: float) -> None:
        self._camera.CreateFocalLengthAttr().Set(float(value) * 10)

    def get_horizontal_aperture(self) -> float:
        return float(self._camera.GetHorizontalApertureAttr().Get()) / 10

    def set_horizontal_aperture(self, value: float, maintain_square_pixels: bool = True) -> None:
        self._camera.CreateHorizontalApertureAttr().Set(float(value) * 10)
        if maintain_square_pixels:
            width, height = self._resolution
            self._camera.CreateVerticalApertureAttr().Set(float(value) * 10 * height / width)

    def get_vertical_aperture(self) -> float:
        width, height = self._resolution
        return self.get_horizontal_aperture() * height / width

    def set_vertical_aperture(self, value: float, maintain_square_pixels: bool = True) -> None:
        self._camera.CreateVerticalApertureAttr().Set(float(value) * 10)

    def get_focus_distance(self) -> float:
        return float(self._camera.GetFocusDistanceAttr().Get())

    def set_focus_distance(self, value: float) -> None:
        self._camera.CreateFocusDistanceAttr().Set(float(value))

    def get_lens_aperture(self) -> float:
        return float(self._camera.GetFStopAttr().Get())

    def set_lens_aperture(self, value: float) -> None:
        self._camera.CreateFStopAttr().Set(float(value))

    def get_clipping_range(self) -> tuple[float, float]:
        near, far = self._camera.GetClippingRangeAttr().Get()
        return float(near), float(far)

    def set_clipping_range(self, near_distance: float | None = None, far_distance: float | None = None) -> None:
        near, far = self.get_clipping_range()
        self._camera.CreateClippingRangeAttr().Set((near_distance or near, far_distance or far))

    def get_horizontal_fov(self) -> float:
        return float(2 * np.arctan(self.get_horizontal_aperture() / (2 * self.get_focal_length())))

    def get_vertical_fov(self) -> float:
        width, height = self._resolution
        return self.get_horizontal_fov() * height / float(width)

    def get_intrinsics_matrix(self) -> np.ndarray:
        width, height = self._resolution
        pixels = width * self.get_focal_length() / self.get_horizontal_aperture()
        return np.array([[pixels, 0, width / 2], [0, pixels, height / 2], [0, 0, 1]])

    def get_resolution(self) -> tuple[int, int]:
        return self._resolution

    def set_resolution(self, value: Any, *_: Any, **__: Any) -> None:
        self._resolution = _size(value)
        self._render_product_path = None

    def get_aspect_ratio(self) -> float:
        width, height = self._resolution
        return width / height

    def get_frequency(self) -> float:
        return float(self._frequency or 1 / app().rendering.get_dt())

    def set_frequency(self, value: int) -> None:
        self._frequency = value

    def get_dt(self) -> float:
        return 1 / self.get_frequency()

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False

    def is_paused(self) -> bool:
        return self._paused


def _size(resolution: Any) -> tuple[int, int]:
    width, height = resolution
    return int(width), int(height)


def _axes(name: str) -> np.ndarray:
    if name not in ("world", "ros", "usd"):
        raise Exception(f"camera axes passed {name} is not supported, accepted values are (world, ros, usd)")
    return {"world": WORLD, "ros": ROS, "usd": np.eye(3)}[name]


def _turned(orientation: Any, camera_axes: str) -> Any:
    if orientation is None:
        return None
    return rot_matrix_to_quat(quat_to_rot_matrix(orientation) @ _axes(camera_axes).T)
