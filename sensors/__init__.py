"""Sensors: ideal measurements of the world, their schedules, buffers and configurations.

Names are loaded at their first use, so importing this package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from graph.base.forwarding import forward as _forward

from .moved import MOVED as _MOVED

if TYPE_CHECKING:
    from .annotators.specs import register_annotator_spec, unregister_annotator_spec
    from .annotators.types import AnnotatorType
    from .authoring import exclude
    from .callbacks import on_frame
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
    from .replicator import create_render_product, get_annotator
    from .runtime import Measurement, SensorRuntime
    from .sensor_types import SensorType, register_sensor_type, unregister_sensor_type
    from .surfaces.ids import parse_object_ids, parse_stable_id_map_data
    from .wrappers import Corrupted, Delayed
    from .writers import register_writer_spec, unregister_writer_spec

    SUPPORTED_LIDAR_CONFIGS: dict[str, list[Any]]

_HOME = {
    "AnnotatorType": ".annotators.types",
    "AuxType": ".gmo",
    "Channel": ".channels",
    "CoordsType": ".gmo",
    "Corrupted": ".wrappers",
    "Delayed": ".wrappers",
    "ElementFlags": ".gmo",
    "FrameOfReference": ".gmo",
    "GenericModelOutput": ".gmo",
    "Lidar": ".lidar.authoring",
    "LidarAuxHas": ".gmo",
    "LidarConfig": ".lidar.config",
    "LidarSensor": ".lidar.sensor",
    "Measurement": ".runtime",
    "Modality": ".gmo",
    "MotionCompensationState": ".gmo",
    "OutputType": ".gmo",
    "SUPPORTED_LIDAR_CONFIGS": ".configs",
    "SensorRuntime": ".runtime",
    "SensorType": ".sensor_types",
    "create_render_product": ".replicator",
    "exclude": ".authoring",
    "getMagicNumberGMO": ".gmo",
    "get_annotator": ".replicator",
    "on_frame": ".callbacks",
    "parse_generic_model_output_data": ".gmo",
    "parse_object_ids": ".surfaces.ids",
    "parse_stable_id_map_data": ".surfaces.ids",
    "register_annotator_spec": ".annotators.specs",
    "register_sensor_type": ".sensor_types",
    "register_writer_spec": ".writers",
    "render_product": ".products",
    "unregister_annotator_spec": ".annotators.specs",
    "unregister_sensor_type": ".sensor_types",
    "unregister_writer_spec": ".writers",
}

_NOT_BUILT = {
    **dict.fromkeys(("Radar", "RadarSensor", "RadarConfig"), "radars"),
    **dict.fromkeys(("Acoustic", "AcousticSensor", "Ultrasonic", "UltrasonicSensor"), "acoustic sensors"),
    **dict.fromkeys(("Camera", "CameraSensor", "RtxCamera", "RtxCameraSensor", "CameraView"), "cameras"),
}
"""Names of what is still to come."""

__all__ = [
    "SUPPORTED_LIDAR_CONFIGS",
    "AnnotatorType",
    "AuxType",
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
    "SensorRuntime",
    "SensorType",
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
]

_forward(_MOVED)


def __getattr__(name: str) -> Any:
    if name in ("replicator", "writers"):
        return import_module(f".{name}", __name__)
    if name in _NOT_BUILT:
        raise ImportError(
            f"sensors.{name}: {_NOT_BUILT[name]} are not built yet; use Lidar and LidarSensor, or register a sensor "
            "type of your own (register_sensor_type)",
            name=name,
        )
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
