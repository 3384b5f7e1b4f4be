"""`isaacsim.core.utils.extensions`: the calls of `app_utils`, by their former parameters."""

from __future__ import annotations

from . import app_utils

__all__ = [
    "disable_extension",
    "enable_extension",
    "get_extension_id",
    "get_extension_path",
    "get_extension_path_from_name",
]


def enable_extension(extension_name: str) -> bool:
    return app_utils.enable_extension(extension_name)


def disable_extension(extension_name: str) -> bool:
    return app_utils.enable_extension(extension_name, enabled=False)


def get_extension_id(extension_name: str) -> str | None:
    return app_utils.get_extension_id(extension_name)


def get_extension_path(ext_id: str) -> str:
    return app_utils.get_extension_path(ext_id)


def get_extension_path_from_name(extension_name: str) -> str:
    return app_utils.get_extension_path_from_name(extension_name)
