"""A keyboard without a window: tests and scripts press its keys, nodes read them."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean

_LETTERS = tuple("ABCDEFGHIJKLMNOPQRSTUVWXYZ")
_NAMED = (
    *("Apostrophe", "Backslash", "Backspace", "CapsLock", "Comma", "Del", "Down", "End", "Enter", "Equal", "Escape"),
    *(f"F{number}" for number in (1, 10, 11, 12, 2, 3, 4, 5, 6, 7, 8, 9)),
    *("GraveAccent", "Home", "Insert"),
    *(f"Key{number}" for number in range(10)),
    *("Left", "LeftAlt", "LeftBracket", "LeftControl", "LeftShift", "LeftSuper", "Menu", "Minus", "NumLock"),
    *(f"Numpad{number}" for number in range(10)),
    *("NumpadAdd", "NumpadDel", "NumpadDivide", "NumpadEnter", "NumpadEqual", "NumpadMultiply", "NumpadSubtract"),
    *("PageDown", "PageUp", "Pause", "Period", "PrintScreen"),
    *("Right", "RightAlt", "RightBracket", "RightControl", "RightShift", "RightSuper"),
    *("ScrollLock", "Semicolon", "Slash", "Space", "Tab", "Up"),
)
KEYS = (*_LETTERS, *_NAMED)
"""Names of all keys, as OmniGraph writes them."""

Listener = Callable[[str, bool], None]
"""Takes a key's name and whether it went down."""


class Keyboard:
    """The state of a keyboard. `press` and `release` take effect at once; listeners are called at every change."""

    def __init__(self) -> None:
        self.pressed: set[str] = set()
        self._listeners: list[Listener] = []

    def press(self, key: str) -> None:
        """Presses a key. Raises UserError for an unknown name."""
        self._check(key)
        if key not in self.pressed:
            self.pressed.add(key)
            self._tell(key, True)

    def release(self, key: str) -> None:
        """Releases a key. Raises UserError for an unknown name."""
        self._check(key)
        if key in self.pressed:
            self.pressed.discard(key)
            self._tell(key, False)

    def is_down(self, *keys: str) -> bool:
        """Whether one of these keys is down."""
        return not self.pressed.isdisjoint(keys)

    @property
    def shift(self) -> bool:
        """Whether a shift key is down."""
        return self.is_down("LeftShift", "RightShift")

    @property
    def alt(self) -> bool:
        """Whether an alt key is down."""
        return self.is_down("LeftAlt", "RightAlt")

    @property
    def control(self) -> bool:
        """Whether a control key is down."""
        return self.is_down("LeftControl", "RightControl")

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Calls `listener(key, down)` at every change; returns a function that ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener) if listener in self._listeners else None

    def _tell(self, key: str, down: bool) -> None:
        for listener in tuple(self._listeners):
            listener(key, down)

    @staticmethod
    def _check(key: str) -> None:
        if key not in KEYS:
            raise UserError(f'there is no key "{key}"{did_you_mean(key, KEYS)}')


_keyboards: weakref.WeakKeyDictionary[Any, Keyboard] = weakref.WeakKeyDictionary()


def keyboard_of(app: Any) -> Keyboard:
    """The App's keyboard."""
    return _keyboards.setdefault(app, Keyboard())
