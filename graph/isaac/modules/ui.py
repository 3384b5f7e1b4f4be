"""`omni.ui`: windows and widgets that nobody sees."""

from __future__ import annotations

from typing import Any

from graph.isaac.names import Row
from graph.isaac.outcomes import outcome

_TEXT = """
Alignment AxisModel Button CheckBox CollapsableFrame ColorWidget ComboBox DockPosition DockPreference
FloatDrag FloatField FloatSlider Fraction Frame Grid HGrid HStack Image ImageWithProvider IntDrag IntField IntSlider
Label Length Line Menu MenuItem Percent Pixel Placer Plot ProgressBar Rectangle ScrollBarPolicy ScrollingFrame Separator
SimpleBoolModel SimpleFloatModel SimpleIntModel SimpleStringModel Spacer StringField Style TreeView Triangle VGrid
VStack Window WindowHandle Workspace ZStack AbstractItem AbstractItemModel AbstractItemDelegate AbstractValueModel
ByteImageProvider WINDOW_FLAGS_NO_SCROLLBAR constant color set_shade
"""
_NAMES = _TEXT.split()
__all__ = list(_NAMES)


def __getattr__(name: str) -> Any:
    if name in _NAMES:
        return outcome(f"omni.ui.{name}", Row("B", "class"))
    raise AttributeError(name)
