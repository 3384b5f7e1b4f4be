"""`isaacsim.sensors.camera`: the Camera class."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from graph.base import exact
from graph.isaac.session import app
from graph.sim.usd import UsdGeom
from sensors.products import product_name, render_product
from sensors.replicator import get_annotator

from .camera_lens import CameraLens
from .render_products import set_camera_prim_path, set_resolution
from .transforms import quat_to_rot_matrix, rot_matrix_to_quat

__all__ = ["R_U_TRANSFORM", "Camera"]
WORLD = np.array([(0.0, -1, 0), (0, 0, 1), (-1, 0, 0)])
"""Columns: the axes of the world convention (X ahead, Y left, Z up) along the stage's (-Z ahead, X right, Y up)."""
ROS = np.diag([1.0, -1.0, -1.0])
"""The axes of an optical frame of ROS (Z ahead, Y down) along the stage's."""
R_U_TRANSFORM = np.diag([1.0, -1.0, -1.0, 1.0])
"""Between the optical frame and the stage's axes of a camera, (4, 4)."""


class Camera(CameraLens):
    supported_annotators = (
        "normals",
        "motion_vectors",
        "occlusion",
        "distance_to_image_plane",
        "distance_to_camera",
        "bounding_box_2d_tight",
        "bounding_box_2d_loose",
        "bounding_box_3d",
        "semantic_segmentation",
        "instance_id_segmentation",
        "instance_segmentation",
        "pointcloud",
    )

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
        self.set_horizontal_aperture(self.get_horizontal_aperture())
        self._frequency: Fraction | None = None
        if frequency is not None and dt is not None:
            raise Exception("Camera takes a frequency or a dt, not both; leave one of them out")
        if frequency is not None:
            self.set_frequency(frequency)
        elif dt is not None:
            self.set_dt(dt)
        if position is not None or orientation is not None:
            self.set_world_pose(position, orientation)
        elif translation is not None:
            self.set_local_pose(translation=translation)
        self._render_product_path: str | None = render_product_path
        self._product: Any = None
        self._annotators: dict[str, tuple[Any, dict[str, Any]]] = {}
        self._frame: dict[str, Any] = {"rendering_time": 0.0, "rendering_frame": 0}
        self._seen: Fraction | None = None  # when the last frame was rendered
        self._elapsed = Fraction(0)  # since the last frame that it took
        self._paused = False

    def initialize(self, physics_sim_view: Any = None, attach_rgb_annotator: bool = True) -> None:
        self._made()
        if attach_rgb_annotator:
            self.attach_annotator("rgb")

    def _made(self) -> str:
        """The path of its render product, which is made again if a stop or another size has ended it."""
        products = app().rendering.products
        if self._product is None or products.get(self._product.path) is not self._product:
            path, size = self.prim_path, self._resolution
            found = products.get(self._render_product_path or "")
            if found is None:
                found = render_product(app(), path, size, product_name(path, size, "camera"))
            else:
                set_resolution(found.path, size)
                set_camera_prim_path(found.path, path)
                found = products[found.path]
            self._product, self._render_product_path = found, found.path
            found.writers.append(self._acquire)
            for name, (_, options) in list(self._annotators.items()):
                self._annotators[name] = self._attached(name, options), options
        return str(self._render_product_path)

    def _attached(self, name: str, options: dict[str, Any]) -> Any:
        return get_annotator(name).initialize(**options).attach([self._product.path])

    def _acquire(self, frame: Any) -> None:
        """Takes a rendered frame if one over the frequency has passed since the last that it took."""
        before, self._seen = self._seen, frame.reference
        if before is None or before > frame.reference:
            self._elapsed = Fraction(0)
        else:
            self._elapsed += frame.reference - before
        if not self._paused and (self._frequency is None or self._elapsed * self._frequency >= 1):
            self._elapsed = Fraction(0)
            self._frame = {"rendering_time": float(frame.reference), "rendering_frame": app().update_index + 1}
            if self._frequency is not None:  # else they are read when they are wanted
                self._frame |= self._read()

    def _read(self) -> dict[str, Any]:
        return {key: attached.get_data() for name, (attached, _) in self._annotators.items() for key in _keys(name)}

    def get_render_product_path(self) -> str:
        return self._made()

    def attach_annotator(self, annotator_name: str, **kwargs: Any) -> None:
        if self._product is None:
            raise RuntimeError("Camera.initialize() must be called before attach_annotator()")
        self._made()
        if annotator_name not in self._annotators:
            self._annotators[annotator_name] = self._attached(annotator_name, kwargs), kwargs

    def detach_annotator(self, annotator_name: str) -> None:
        found = self._annotators.pop(annotator_name, None)
        if found is not None:
            found[0].detach()
            for key in _keys(annotator_name):
                self._frame.pop(key, None)

    def _data(self, annotator: str) -> Any:
        found = None
        if self._product is not None:
            self.attach_annotator(annotator)
            found = self._annotators[annotator][0].get_data()
        found = found["data"] if isinstance(found, dict) and "data" in found else found
        if found is not None and len(found):
            return found
        app().warn("camera-no-data", self.prim_path, f"{annotator} has no data yet; initialize() and render first")
        return None

    def get_rgba(self, device: Any = None) -> Any:
        return self._data("rgb")

    def get_rgb(self, device: Any = None) -> Any:
        found = self._data("rgb")
        return None if found is None else found[..., :3]

    def get_depth(self, device: Any = None) -> Any:
        return self._data("distance_to_image_plane")

    def get_pointcloud(self, device: Any = None, world_frame: bool = True) -> Any:
        """Points (n, 3): those of the annotator, if it is attached, else one for each pixel that sees something."""
        if "pointcloud" in self._annotators:
            found = self._data("pointcloud")
            found = np.zeros((0, 3), np.float32) if found is None else found
            return found if world_frame else self._in_camera(found)[:, :3]
        depth = self.get_depth()
        if depth is None:
            return np.zeros((0, 3), np.float32)
        rows, columns = np.nonzero(np.isfinite(depth))
        pixels = np.stack([columns, rows], axis=1) + 0.5
        points = self.get_world_points_from_image_coords if world_frame else self.get_camera_points_from_image_coords
        return points(pixels, depth[rows, columns])

    def get_current_frame(self, clone: bool = False) -> dict[str, Any]:
        if self._frequency is None and not self._paused:
            self._frame |= self._read()
        for key in (key for name in self._annotators for key in _keys(name)):
            self._frame.setdefault(key, None)
        return dict(self._frame) if clone else self._frame

    def __getattr__(self, name: str) -> Any:
        """`add_distance_to_camera_to_frame`, `remove_...`."""
        if (name.startswith(("add_", "remove_")) and "_to_frame" in name) or name.endswith("_from_frame"):
            short = name.partition("_")[2].removesuffix("_to_frame").removesuffix("_from_frame")
            words = {"motion_vectors": "motion_vectors", "instance_segmentation": "instance_segmentation_fast"}
            call = self.attach_annotator if name.startswith("add_") else self.detach_annotator
            known = {"include_unlabelled": "includeUnlabelled"}

            def change(init_params: Any = None, **options: Any) -> None:
                given = {known[name]: value for name, value in options.items() if name in known}
                call(words.get(short, short), **{**given, **(init_params or {})})

            return change
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
        self._set_apertures(value, value / self.get_aspect_ratio() if maintain_square_pixels else None)

    def get_vertical_aperture(self) -> float:
        return float(self._camera.GetVerticalApertureAttr().Get()) / 10

    def set_vertical_aperture(self, value: float, maintain_square_pixels: bool = True) -> None:
        self._set_apertures(value * self.get_aspect_ratio() if maintain_square_pixels else None, value)

    def _set_apertures(self, across: float | None, down: float | None) -> None:
        if across is not None:
            self._camera.CreateHorizontalApertureAttr().Set(float(across) * 10)
        if down is not None:
            self._camera.CreateVerticalApertureAttr().Set(float(down) * 10)

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
        before = self.get_clipping_range()
        given = (old if new is None else new for old, new in zip(before, (near_distance, far_distance), strict=True))
        self._camera.CreateClippingRangeAttr().Set(tuple(given))

    def get_horizontal_fov(self) -> float:
        return float(2 * np.arctan(self.get_horizontal_aperture() / (2 * self.get_focal_length())))

    def get_vertical_fov(self) -> float:
        width, height = self._resolution
        return self.get_horizontal_fov() * height / float(width)

    def get_intrinsics_matrix(self, device: Any = None, backend_utils_cls: Any = None) -> np.ndarray:
        width, height = self._resolution
        pixels = width * self.get_focal_length() / self.get_horizontal_aperture()
        return np.array([[pixels, 0, width / 2], [0, pixels, height / 2], [0, 0, 1]])

    # -- the pinhole model -----------------------------------------------------------------------------------------

    def get_view_matrix_ros(self, device: Any = None, backend_utils_cls: Any = None) -> np.ndarray:
        """World to the camera's optical frame (Z ahead, Y down), (4, 4)."""
        position, orientation = self.get_world_pose("ros")
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = quat_to_rot_matrix(orientation), position
        return np.linalg.inv(pose)

    def get_image_coords_from_world_points(self, points_3d: Any) -> np.ndarray:
        """Pixels (n, 2), right and down from the top left corner, of points (n, 3) of the world."""
        found = self._in_camera(points_3d)[:, :3] @ self._pinhole().T
        return np.asarray(found[:, :2] / found[:, 2:])

    def get_camera_points_from_image_coords(
        self, points_2d: Any, depth: Any, device: Any = None, backend_utils_cls: Any = None
    ) -> np.ndarray:
        """Points (n, 3) in the optical frame at pixels (n, 2) and depths (n,) along the optical axis."""
        pixels, depths = np.asarray(points_2d, float).reshape(-1, 2), np.asarray(depth, float).reshape(-1, 1)
        rays = np.hstack([pixels, np.ones((len(pixels), 1))]) @ np.linalg.inv(self._pinhole()).T
        return np.asarray(rays * depths)

    def get_world_points_from_image_coords(
        self, points_2d: Any, depth: Any, device: Any = None, backend_utils_cls: Any = None
    ) -> np.ndarray:
        """Points (n, 3) of the world at pixels (n, 2) and depths (n,) along the optical axis."""
        points = self.get_camera_points_from_image_coords(points_2d, depth)
        return np.asarray(_with_ones(points) @ np.linalg.inv(self.get_view_matrix_ros()).T)[:, :3]

    def _in_camera(self, points: Any) -> np.ndarray:
        return np.asarray(_with_ones(np.asarray(points, float).reshape(-1, 3)) @ self.get_view_matrix_ros().T)

    def _pinhole(self) -> np.ndarray:
        if self.get_lens_distortion_model() != "pinhole":
            raise Exception(f"{self.prim_path} has the lens {self.get_lens_distortion_model()}, not a pinhole")
        return self.get_intrinsics_matrix()

    def get_resolution(self) -> tuple[int, int]:
        return self._resolution

    def set_resolution(self, value: Any, maintain_square_pixels: bool = True) -> None:
        self._resolution, self._render_product_path = _size(value), None
        if maintain_square_pixels:
            self.set_horizontal_aperture(self.get_horizontal_aperture())
        if self._product is not None:
            for attached in self._annotators.values():
                attached[0].detach()
            if self._acquire in self._product.writers:
                self._product.writers.remove(self._acquire)
            self._product = None
            self._made()

    def get_aspect_ratio(self) -> float:
        width, height = self._resolution
        return width / height

    def get_frequency(self) -> float:
        return float(self._frequency or _rendering_rate())

    def set_frequency(self, value: float) -> None:
        self._take_rate(exact.rate(value), f"frequency {value:g} Hz")

    def set_dt(self, value: float) -> None:
        self._take_rate(1 / exact.duration(value), f"dt {value:g} s")

    def _take_rate(self, rate: Fraction, given: str) -> None:
        rendered = _rendering_rate()
        if rate <= 0 or (rendered / rate).denominator != 1:
            raise Exception(f"{given}: the rendering rate, {float(rendered):g} Hz, is not a whole multiple of it")
        self._frequency = rate

    def get_dt(self) -> float:
        return 1 / self.get_frequency()

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False

    def is_paused(self) -> bool:
        return self._paused


def _rendering_rate() -> Fraction:
    return 1 / exact.duration(app().rendering.get_dt())


def _keys(annotator: str) -> tuple[str, ...]:
    """The keys of an annotator's data in a frame; that of colours has its former name, too."""
    return ("rgb", "rgba") if annotator == "rgb" else (annotator.replace("_fast", ""),)


def _with_ones(points: np.ndarray) -> np.ndarray:
    return np.hstack([points, np.ones((len(points), 1))])


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
