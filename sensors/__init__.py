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
    from .annotators.registry import register_annotator_spec as register_annotator_spec
    from .annotators.registry import unregister_annotator_spec as unregister_annotator_spec
    from .annotators.types import AnnotatorType as AnnotatorType
    from .authoring import bind_material as bind_material
    from .authoring import exclude as exclude
    from .callbacks import on_frame as on_frame
    from .camera.authoring import RtxCamera as RtxCamera
    from .camera.camera_view import CameraView as CameraView
    from .camera.depth_camera import SingleViewDepthCameraSensor as SingleViewDepthCameraSensor
    from .camera.sensor import CameraSensor as CameraSensor
    from .camera.structured_light import StructuredLightCamera as StructuredLightCamera
    from .camera.structured_light import write_directions as write_directions
    from .camera.tiled_sensor import TiledCameraSensor as TiledCameraSensor
    from .channels import Channel as Channel
    from .gmo import AuxType as AuxType
    from .gmo import CoordsType as CoordsType
    from .gmo import ElementFlags as ElementFlags
    from .gmo import FrameOfReference as FrameOfReference
    from .gmo import GenericModelOutput as GenericModelOutput
    from .gmo import LidarAuxHas as LidarAuxHas
    from .gmo import Modality as Modality
    from .gmo import MotionCompensationState as MotionCompensationState
    from .gmo import OutputType as OutputType
    from .gmo import getMagicNumberGMO as getMagicNumberGMO
    from .gmo import parse_generic_model_output_data as parse_generic_model_output_data
    from .lidar.authoring import Lidar as Lidar
    from .lidar.authoring import LidarSensor as LidarSensor
    from .lidar.config import LidarConfig as LidarConfig
    from .products import render_product as render_product
    from .radar.authoring import Radar as Radar
    from .radar.authoring import RadarSensor as RadarSensor
    from .radar.config import RadarConfig as RadarConfig
    from .radar.configs import SUPPORTED_RADAR_CONFIGS as SUPPORTED_RADAR_CONFIGS
    from .replicator import create_render_product as create_render_product
    from .replicator import get_annotator as get_annotator
    from .runtime import Measurement as Measurement
    from .runtime import SensorRuntime as SensorRuntime
    from .sensor_types import SensorType as SensorType
    from .sensor_types import register_sensor_type as register_sensor_type
    from .sensor_types import unregister_sensor_type as unregister_sensor_type
    from .surfaces.ids import parse_object_ids as parse_object_ids
    from .surfaces.ids import parse_stable_id_map_data as parse_stable_id_map_data
    from .wrappers import Corrupted as Corrupted
    from .wrappers import Delayed as Delayed
    from .writers import register_writer_spec as register_writer_spec
    from .writers import unregister_writer_spec as unregister_writer_spec

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
    "LidarSensor": "lidar.authoring",
    "Measurement": "runtime",
    "Modality": "gmo",
    "MotionCompensationState": "gmo",
    "OutputType": "gmo",
    "Radar": "radar.authoring",
    "RadarConfig": "radar.config",
    "RadarSensor": "radar.authoring",
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
    "register_annotator_spec": "annotators.registry",
    "register_sensor_type": "sensor_types",
    "register_writer_spec": "writers",
    "render_product": "products",
    "replicator": "replicator",
    "unregister_annotator_spec": "annotators.registry",
    "unregister_sensor_type": "sensor_types",
    "unregister_writer_spec": "writers",
    "write_directions": "camera.structured_light",
    "writers": "writers",
}

__all__ = [name for name in _HOMES if name not in ("replicator", "writers")]  # modules, by their own names


def _of_wing(name: str) -> Any:
    """What the package of a sensor that a wing declares has under a public name. Raises AttributeError."""
    from importlib import import_module

    from graph.base.plugins import SENSORS, shipped

    plugins = (plugin for plugin in shipped(SENSORS).values() if not plugin.absence)
    for package in dict.fromkeys(plugin.module.rpartition(".")[0] for plugin in plugins):
        if name in import_module(package).__all__:
            return getattr(import_module(package), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__getattr__, __dir__ = _lazy_names(__name__, _HOMES, _of_wing)
