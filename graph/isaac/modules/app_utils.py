"""`isaacsim.core.experimental.utils.app` and the older ways to enable extensions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from graph.isaac.managers.app_utils import is_paused, is_playing, is_stopped, pause, play, stop
from graph.isaac.session import kit

if TYPE_CHECKING:
    from .kit_app import ExtensionManager

__all__ = [
    "disable_extension",
    "enable_extension",
    "get_extension_dict",
    "get_extension_id",
    "get_extension_path",
    "get_extension_path_from_name",
    "is_extension_enabled",
    "is_paused",
    "is_playing",
    "is_stopped",
    "pause",
    "play",
    "stop",
    "update_app",
    "update_app_async",
]


def update_app(*, steps: int = 1, callback: Callable[[int, int], Any] | None = None) -> None:
    for done in range(1, steps + 1):
        kit().update()
        if callback is not None and callback(done, steps) is False:
            return


async def update_app_async(*, steps: int = 1, callback: Callable[[int, int], Any] | None = None) -> None:
    for done in range(1, steps + 1):
        await kit().next_update()
        if callback is not None and callback(done, steps) is False:
            return


def enable_extension(name: str, *, enabled: bool = True) -> bool:
    return _manager().set_extension_enabled_immediate(name, enabled)


def disable_extension(name: str) -> bool:
    return enable_extension(name, enabled=False)


def is_extension_enabled(name: str) -> bool:
    return _manager().is_extension_enabled(name)


def _manager() -> ExtensionManager:
    from .kit_app import get_app

    return get_app().get_extension_manager()


def get_extension_id(name: str) -> str | None:
    return _manager().get_enabled_extension_id(name)


def get_extension_dict(name: str) -> dict[str, Any] | None:
    found = get_extension_id(name)
    return None if found is None else _manager().get_extension_dict(found)


def get_extension_path(name: str) -> str:
    found = get_extension_id(name)
    return "" if found is None else _manager().get_extension_path(found)


def get_extension_path_from_name(name: str) -> str:
    return _manager().get_extension_path(name)
