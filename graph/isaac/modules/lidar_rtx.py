"""`isaacsim.sensors.rtx`: LidarRtx and the helpers of the former sensor module."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.parameters import renamed
from graph.isaac.session import app
from sensors import (
    SUPPORTED_LIDAR_CONFIGS,
    Lidar,
    parse_generic_model_output_data,
    parse_object_ids,
    parse_stable_id_map_data,
)
from sensors.handles import resolve
from sensors.products import product_name, render_product
from sensors.replicator import get_annotator, get_writer

from .old_prims import SingleXFormPrim

__all__ = [
    "SUPPORTED_LIDAR_CONFIGS",
    "SUPPORTED_LIDAR_VARIANT_SET_NAME",
    "LidarRtx",
    "get_gmo_data",
]
SUPPORTED_LIDAR_VARIANT_SET_NAME = "sensor"
FLAT_SCAN = "IsaacComputeRTXLidarFlatScan"
OF_SCAN = {
    "linear_depth_data": "linearDepthData",
    "intensities_data": "intensitiesData",
    "azimuth_range": "azimuthRange",
    "horizontal_resolution": "horizontalResolution",
}
"""Entries of the frame while the flat scan's annotator is attached, and their names in its data."""


def get_gmo_data(dataPtr: Any) -> Any:
    data = resolve(dataPtr) if isinstance(dataPtr, int) else np.asarray(dataPtr)
    return parse_generic_model_output_data(data)


class LidarRtx(SingleXFormPrim):
    def __init__(
        self,
        prim_path: str,
        name: str = "lidar_rtx",
        position: Any = None,
        translation: Any = None,
        orientation: Any = None,
        config_file_name: str | None = None,
        **kwargs: Any,
    ) -> None:
        if app().stage.GetPrimAtPath(prim_path):
            made = Lidar(prim_path)
        elif config_file_name is not None:
            made = Lidar.create(prim_path, config=config_file_name)
        else:
            attributes = {key: value for key, value in kwargs.items() if key.startswith("omni:")}
            made = Lidar(prim_path, attributes=attributes)
        super().__init__(made.path, name, position, translation, orientation)
        self._product = render_product(app(), made.path, (128, 128), product_name(made.path, (128, 128)))
        self._annotators: dict[str, Any] = {}
        self._writers: dict[str, Any] = {}
        self._paused = False
        self._frame: dict[str, Any] = {"rendering_time": 0.0, "rendering_frame": 0}
        self._lidar = made

    def initialize(self, physics_sim_view: Any = None) -> None:
        return None

    def get_render_product_path(self) -> str:
        return self._product.path

    def attach_annotator(self, annotator_name: str, **kwargs: Any) -> None:
        if annotator_name in self._annotators:
            return
        made = get_annotator(annotator_name).initialize(**kwargs)
        self._annotators[annotator_name] = made.attach([self._product.path])

    def detach_annotator(self, annotator_name: str) -> None:
        found = self._annotators.pop(annotator_name, None)
        if found is not None:
            found.detach()

    def detach_all_annotators(self) -> None:
        for name in list(self._annotators):
            self.detach_annotator(name)

    def get_annotators(self) -> dict[str, Any]:
        return self._annotators

    def attach_writer(self, writer_name: str, **kwargs: Any) -> None:
        if writer_name not in self._writers:
            self._writers[writer_name] = get_writer(writer_name).initialize(**kwargs).attach([self._product.path])

    def detach_writer(self, writer_name: str) -> None:
        found = self._writers.pop(writer_name, None)
        if found is not None:
            found.detach()

    def detach_all_writers(self) -> None:
        for name in list(self._writers):
            self.detach_writer(name)

    def get_writers(self) -> dict[str, Any]:
        return self._writers

    def get_current_frame(self) -> dict[str, Any]:
        if not self._paused:
            now = app().external_time
            self._frame["rendering_time"] = float(now)
            self._frame["rendering_frame"] = now.numerator, now.denominator
            for name, one in self._annotators.items():
                self._frame[name] = one.get_data()
            for name, key in OF_SCAN.items() if FLAT_SCAN in self._annotators else ():
                self._frame[name] = self._frame[FLAT_SCAN][key]
        return self._frame

    def _of_scan(self, key: str) -> Any:
        """A value of the flat scan; None unless its annotator is attached."""
        return self._annotators[FLAT_SCAN].get_data()[key] if FLAT_SCAN in self._annotators else None

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False

    def is_paused(self) -> bool:
        return self._paused or app().timeline.is_paused()

    def enable_visualization(self) -> None:
        self.attach_writer("RtxLidarDebugDrawPointCloud")

    def disable_visualization(self) -> None:
        self.detach_writer("RtxLidarDebugDrawPointCloud")

    def get_rotation_frequency(self) -> float | None:
        return float(self._lidar.config.scan_rate_base_hz) if FLAT_SCAN in self._annotators else None

    def get_depth_range(self) -> tuple[float, float] | None:
        config = self._lidar.config
        return (float(config.near_range_m), float(config.far_range_m)) if FLAT_SCAN in self._annotators else None

    @staticmethod
    def get_object_ids(obj_ids: Any) -> list[int]:
        return parse_object_ids(np.asarray(obj_ids))

    @staticmethod
    def decode_stable_id_mapping(stable_id_mapping_raw: Any) -> dict[int, str]:
        return parse_stable_id_map_data(np.frombuffer(bytes(stable_id_mapping_raw), np.uint8))

    @staticmethod
    def make_add_remove_deprecated_attr(deprecated_attr: str) -> list[Any]:
        """The calls `add_..._to_frame` and `remove_..._to_frame` of a former part of the frame."""
        cloud = "point_cloud" in deprecated_attr
        chosen = "IsaacExtractRTXSensorPointCloudNoAccumulator" if cloud else FLAT_SCAN

        def add(self: LidarRtx) -> None:
            self.attach_annotator(chosen)

        def remove(self: LidarRtx) -> None:
            self.detach_annotator(chosen)

        calls = [(add, f"add_{deprecated_attr}_to_frame"), (remove, f"remove_{deprecated_attr}_to_frame")]
        return [renamed(call, name) for call, name in calls]

    def get_num_rows(self) -> int | None:
        return self._of_scan("numRows")  # type: ignore[no-any-return]

    def get_num_cols(self) -> int | None:
        return self._of_scan("numCols")  # type: ignore[no-any-return]

    def get_horizontal_resolution(self) -> float | None:
        return self._of_scan("horizontalResolution")  # type: ignore[no-any-return]

    def get_horizontal_fov(self) -> float | None:
        return self._of_scan("horizontalFov")  # type: ignore[no-any-return]

    def get_azimuth_range(self) -> tuple[float, float] | None:
        return self._of_scan("azimuthRange")  # type: ignore[no-any-return]


_PARTS = ("point_cloud_data", "linear_depth_data", "intensities_data", "range_data", "azimuth_data", "elevation_data")
for _part in (*_PARTS, "azimuth_range", "horizontal_resolution"):
    for _call in LidarRtx.make_add_remove_deprecated_attr(_part):
        setattr(LidarRtx, _call.__name__, _call)
