"""`carb.settings` and `carb.tokens`: the App's settings."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from itertools import count
from typing import Any

from graph.base.errors import UserError
from graph.isaac.assets import ROOT_SETTING, root
from graph.isaac.session import app

__all__ = [
    "ChangeEventType",
    "ISettings",
    "ITokens",
    "acquire_settings_interface",
    "get_settings",
    "get_tokens_interface",
]
_STRANGERS = {"/renderer/multiGpu/currentGpuCount": 0, "/app/window/hideUi": True}
"""Settings that scripts read as a number, and that the App does not have."""


class ChangeEventType(IntEnum):
    CREATED = 0
    CHANGED = 1
    DESTROYED = 2


class ISettings:
    def __init__(self) -> None:
        self._subscriptions: dict[int, Callable[[], None]] = {}
        self._serial = count(1)

    def get(self, path: str) -> Any:
        return app().settings.get(path, root() if path == ROOT_SETTING else _STRANGERS.get(path))

    def set(self, path: str, value: Any) -> None:
        try:
            app().settings.set(path, value)
        except UserError as error:  # Kit takes any value
            app().warn("setting-refused", path, str(error))

    def get_as_bool(self, path: str) -> bool:
        return bool(self.get(path))

    def get_as_int(self, path: str) -> int:
        return int(self._number(path))

    def get_as_float(self, path: str) -> float:
        return float(self._number(path))

    get_as_int64, get_as_float64 = get_as_int, get_as_float

    def get_as_string(self, path: str) -> str:
        value = self.get(path)
        return "" if value is None else str(value)

    set_bool = set_int = set_float = set_string = set
    set_bool_array = set_int_array = set_float_array = set_string_array = set

    def set_default(self, path: str, value: Any) -> None:
        app().settings.set_default(path, value)

    set_default_bool = set_default_int = set_default_float = set_default_string = set_default

    def get_settings_dictionary(self, path: str = "") -> Any:
        return app().settings.get(path or "/")

    def destroy_item(self, path: str) -> None:
        self.set(path, None)

    def subscribe_to_node_change_events(self, path: str, fn: Any) -> int:
        number = next(self._serial)
        end = app().settings.subscribe(path, lambda value: fn(value, ChangeEventType.CHANGED))
        self._subscriptions[number] = end
        return number

    def subscribe_to_tree_change_events(self, path: str, fn: Any) -> int:
        return self.subscribe_to_node_change_events(path, lambda value, kind: fn(value, value, kind))

    def unsubscribe_to_change_events(self, id: int) -> None:
        self._subscriptions.pop(id, lambda: None)()

    def _number(self, path: str) -> float:
        try:
            return float(self.get(path) or 0)
        except (TypeError, ValueError):
            return 0.0


_SETTINGS = ISettings()


def get_settings() -> ISettings:
    return _SETTINGS


def acquire_settings_interface() -> ISettings:
    return _SETTINGS


class ITokens:
    def __init__(self) -> None:
        self._values: dict[str, str] = {}

    def resolve(self, text: str) -> str:
        for name, value in self._values.items():
            text = text.replace(f"${{{name}}}", value)
        return text

    def set_value(self, name: str, value: str) -> None:
        self._values[name] = value


_TOKENS = ITokens()


def get_tokens_interface() -> ITokens:
    return _TOKENS
