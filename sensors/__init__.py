"""Sensors: ideal measurements of the world, their schedules, buffers and configurations.

Names are loaded when they are first used, so importing this package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .gmo import GenericModelOutput, getMagicNumberGMO, parse_generic_model_output_data
    from .ids import parse_object_ids, parse_stable_id_map_data
    from .lidar.authoring import Lidar
    from .lidar.config import LidarConfig
    from .lidar.sensor import LidarSensor
    from .products import render_product
    from .replicator import create_render_product, get_annotator
    from .specs import register_annotator_spec, unregister_annotator_spec
    from .writers import register_writer_spec, unregister_writer_spec

    SUPPORTED_LIDAR_CONFIGS: dict[str, list[Any]]

_HOME = {
    "GenericModelOutput": ".gmo",
    "Lidar": ".lidar.authoring",
    "LidarConfig": ".lidar.config",
    "LidarSensor": ".lidar.sensor",
    "SUPPORTED_LIDAR_CONFIGS": ".configs",
    "create_render_product": ".replicator",
    "getMagicNumberGMO": ".gmo",
    "get_annotator": ".replicator",
    "parse_generic_model_output_data": ".gmo",
    "parse_object_ids": ".ids",
    "parse_stable_id_map_data": ".ids",
    "register_annotator_spec": ".specs",
    "register_writer_spec": ".writers",
    "render_product": ".products",
    "unregister_annotator_spec": ".specs",
    "unregister_writer_spec": ".writers",
}

__all__ = [
    "SUPPORTED_LIDAR_CONFIGS",
    "GenericModelOutput",
    "Lidar",
    "LidarConfig",
    "LidarSensor",
    "create_render_product",
    "getMagicNumberGMO",
    "get_annotator",
    "parse_generic_model_output_data",
    "parse_object_ids",
    "parse_stable_id_map_data",
    "register_annotator_spec",
    "register_writer_spec",
    "render_product",
    "unregister_annotator_spec",
    "unregister_writer_spec",
]


def __getattr__(name: str) -> Any:
    if name in ("replicator", "writers"):
        return import_module(f".{name}", __name__)
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name], __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
