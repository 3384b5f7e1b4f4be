"""Sensors: ideal measurements of the world, their schedules, buffers and configurations.

Names are loaded at their first use, so importing this package costs nothing.
"""

from __future__ import annotations

from sys import modules as _modules
from typing import TYPE_CHECKING, Any

try:
    from graph.base.lazy_names import lazy_names as _lazy_names
except ModuleNotFoundError as _error:
    _file = _modules["graph"].__file__
    raise ImportError(f'{_file} hides the package "graph" of TickGraph; rename it') from _error


if TYPE_CHECKING:
    from .annotators.specs import register_annotator_spec, unregister_annotator_spec
    from .annotators.types import AnnotatorType
    from .authoring import bind_material, exclude
    from .callbacks import on_frame
    from .camera.authoring import RtxCamera
    from .camera.camera_view import CameraView
    from .camera.depth_camera import SingleViewDepthCameraSensor
    from .camera.sensor import CameraSensor
    from .camera.structured_light import StructuredLightCamera, write_directions
    from .camera.tiled_sensor import TiledCameraSensor
    from .channels import Channel
    from .gmo import (
        AuxType,
        CoordsType,
        ElementFlags,
        FrameOfReference,
        GenericModelOutput,
        LidarAuxHas,
        Modality,
        MotionCompensationState,
        OutputType,
        getMagicNumberGMO,
        parse_generic_model_output_data,
    )
    from .lidar.authoring import Lidar
    from .lidar.config import LidarConfig
    from .lidar.sensor import LidarSensor
    from .products import render_product
    from .radar.authoring import Radar
    from .radar.config import RadarConfig
    from .radar.configs import SUPPORTED_RADAR_CONFIGS
    from .radar.sensor import RadarSensor
    from .replicator import create_render_product, get_annotator
    from .runtime import Measurement, SensorRuntime
    from .sensor_types import SensorType, register_sensor_type, unregister_sensor_type
    from .surfaces.ids import parse_object_ids, parse_stable_id_map_data
    from .wrappers import Corrupted, Delayed
    from .writers import register_writer_spec, unregister_writer_spec

    SUPPORTED_CAMERA_CONFIGS: dict[str, dict[str, Any]]
    SUPPORTED_LIDAR_CONFIGS: dict[str, list[Any]]

_HOMES = {
    "AnnotatorType": "annotators.types",
    "AuxType": "gmo",
    "CameraSensor": "camera.sensor",
    "CameraView": "camera.camera_view",
    "Channel": "channels",
    "CoordsType": "gmo",
    "Corrupted": "wrappers",
    "Delayed": "wrappers",
    "ElementFlags": "gmo",
    "FrameOfReference": "gmo",
    "GenericModelOutput": "gmo",
    "Lidar": "lidar.authoring",
    "LidarAuxHas": "gmo",
    "LidarConfig": "lidar.config",
    "LidarSensor": "lidar.sensor",
    "Measurement": "runtime",
    "Modality": "gmo",
    "MotionCompensationState": "gmo",
    "OutputType": "gmo",
    "Radar": "radar.authoring",
    "RadarConfig": "radar.config",
    "RadarSensor": "radar.sensor",
    "RtxCamera": "camera.authoring",
    "SUPPORTED_CAMERA_CONFIGS": "configs",
    "SUPPORTED_LIDAR_CONFIGS": "configs",
    "SUPPORTED_RADAR_CONFIGS": "radar.configs",
    "SensorRuntime": "runtime",
    "SensorType": "sensor_types",
    "SingleViewDepthCameraSensor": "camera.depth_camera",
    "StructuredLightCamera": "camera.structured_light",
    "TiledCameraSensor": "camera.tiled_sensor",
    "bind_material": "authoring",
    "create_render_product": "replicator",
    "exclude": "authoring",
    "getMagicNumberGMO": "gmo",
    "get_annotator": "replicator",
    "on_frame": "callbacks",
    "parse_generic_model_output_data": "gmo",
    "parse_object_ids": "surfaces.ids",
    "parse_stable_id_map_data": "surfaces.ids",
    "register_annotator_spec": "annotators.specs",
    "register_sensor_type": "sensor_types",
    "register_writer_spec": "writers",
    "render_product": "products",
    "replicator": "replicator",
    "unregister_annotator_spec": "annotators.specs",
    "unregister_sensor_type": "sensor_types",
    "unregister_writer_spec": "writers",
    "write_directions": "camera.structured_light",
    "writers": "writers",
}

__all__ = [
    "SUPPORTED_CAMERA_CONFIGS",
    "SUPPORTED_LIDAR_CONFIGS",
    "SUPPORTED_RADAR_CONFIGS",
    "AnnotatorType",
    "AuxType",
    "CameraSensor",
    "CameraView",
    "Channel",
    "CoordsType",
    "Corrupted",
    "Delayed",
    "ElementFlags",
    "FrameOfReference",
    "GenericModelOutput",
    "Lidar",
    "LidarAuxHas",
    "LidarConfig",
    "LidarSensor",
    "Measurement",
    "Modality",
    "MotionCompensationState",
    "OutputType",
    "Radar",
    "RadarConfig",
    "RadarSensor",
    "RtxCamera",
    "SensorRuntime",
    "SensorType",
    "SingleViewDepthCameraSensor",
    "StructuredLightCamera",
    "TiledCameraSensor",
    "bind_material",
    "create_render_product",
    "exclude",
    "getMagicNumberGMO",
    "get_annotator",
    "on_frame",
    "parse_generic_model_output_data",
    "parse_object_ids",
    "parse_stable_id_map_data",
    "register_annotator_spec",
    "register_sensor_type",
    "register_writer_spec",
    "render_product",
    "unregister_annotator_spec",
    "unregister_sensor_type",
    "unregister_writer_spec",
    "write_directions",
]


def _of_wing(name: str) -> Any:
    """What the package of a sensor that a wing declares has under a public name. Raises AttributeError."""
    from importlib import import_module

    from graph.base.plugins import SENSORS, of_wings

    plugins = (plugin for plugin in of_wings(SENSORS).values() if not plugin.absence)
    for package in dict.fromkeys(plugin.module.rpartition(".")[0] for plugin in plugins):
        if name in import_module(package).__all__:
            return getattr(import_module(package), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__getattr__, __dir__ = _lazy_names(__name__, _HOMES, _of_wing)
