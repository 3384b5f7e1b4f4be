"""`omni.ui`: windows and widgets that nobody sees; value models, and the widgets that have one, keep their values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from graph.isaac.names import Row
from graph.isaac.outcomes import outcome

_TEXT = """
Alignment AxisModel Button CollapsableFrame ColorWidget ComboBox DockPosition DockPreference
Fraction Frame Grid HGrid HStack Image ImageWithProvider
Label Length Line Menu MenuItem Percent Pixel Placer Plot ProgressBar Rectangle ScrollBarPolicy ScrollingFrame Separator
Spacer Style TreeView Triangle VGrid
VStack Window WindowHandle Workspace ZStack AbstractItem AbstractItemModel AbstractItemDelegate
ByteImageProvider WINDOW_FLAGS_NO_SCROLLBAR constant color set_shade
"""
_WIDGETS = {
    "CheckBox": bool,
    **dict.fromkeys(("FloatDrag", "FloatField", "FloatSlider"), float),
    **dict.fromkeys(("IntDrag", "IntField", "IntSlider"), int),
    "StringField": str,
}
"""Widgets with a value, and its type."""
_MODELS = {"SimpleBoolModel": bool, "SimpleFloatModel": float, "SimpleIntModel": int, "SimpleStringModel": str}


class AbstractValueModel:
    """A value, and who is called after it has changed."""

    kind: ClassVar[Callable[..., Any]] = str

    def __init__(self, value: Any = None, **_: Any) -> None:
        self._value = self.kind() if value is None else self.kind(value)
        self._followers: dict[int, Callable[[Any], Any]] = {}
        self._next = 0

    def get_value_as_bool(self) -> bool:
        return bool(self._value)

    def get_value_as_float(self) -> float:
        return float(self._value or 0)

    def get_value_as_int(self) -> int:
        return int(float(self._value or 0))

    def get_value_as_string(self) -> str:
        return str(self._value)

    as_bool = property(lambda self: self.get_value_as_bool(), lambda self, value: self.set_value(value))
    as_float = property(lambda self: self.get_value_as_float(), lambda self, value: self.set_value(value))
    as_int = property(lambda self: self.get_value_as_int(), lambda self, value: self.set_value(value))
    as_string = property(lambda self: self.get_value_as_string(), lambda self, value: self.set_value(value))

    def set_value(self, value: Any) -> None:
        if (new := self.kind(value)) != self._value:
            self._value = new
            for follower in list(self._followers.values()):
                follower(self)

    def add_value_changed_fn(self, fn: Callable[[Any], Any]) -> int:
        self._next += 1
        self._followers[self._next] = fn
        return self._next

    subscribe_value_changed_fn = add_value_changed_fn

    def remove_value_changed_fn(self, number: int) -> None:
        self._followers.pop(number, None)

    def add_begin_edit_fn(self, fn: Any) -> int:
        """Nobody edits a widget here: it is never called."""
        return 0

    add_end_edit_fn = subscribe_begin_edit_fn = subscribe_end_edit_fn = add_begin_edit_fn


def _widget(name: str, kind: type) -> Any:
    inert = outcome(f"omni.ui.{name}", Row("B", "class"))

    def made(self: Any, model: Any = None, *_: Any, **__: Any) -> None:
        inert.__init__(self)
        self.model = _MODEL_OF[kind]() if model is None else model

    return type(inert)(name, (inert,), {"__init__": made, "_name": f"omni.ui.{name}", "__module__": "omni.ui"})


_MODEL_OF = {kind: type(name, (AbstractValueModel,), {"kind": kind}) for name, kind in _MODELS.items()}
_VALUES = {
    "AbstractValueModel": AbstractValueModel,
    **{one.__name__: one for one in _MODEL_OF.values()},
}
_NAMES = [*_TEXT.split(), *_WIDGETS, *_VALUES]
__all__ = list(_NAMES)


def __getattr__(name: str) -> Any:
    if name in _VALUES:
        return _VALUES[name]
    if name in _WIDGETS:
        return _widget(name, _WIDGETS[name])
    if name in _NAMES:
        return outcome(f"omni.ui.{name}", Row("B", "class"))
    raise AttributeError(name)
