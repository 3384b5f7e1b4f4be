"""The one module that imports USD; importing it also registers our schemas, so that they are known before any stage
opens.

Import it inside functions, or from modules that are themselves imported late: it costs about 0.1 s.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.signals import deferred

if TYPE_CHECKING:
    from pxr import UsdLux, Work

__all__ = [
    "Ar",
    "Gf",
    "Pcp",
    "Plug",
    "Sdf",
    "Tf",
    "Usd",
    "UsdGeom",
    "UsdLux",
    "UsdPhysics",
    "UsdRender",
    "UsdShade",
    "UsdUtils",
    "Vt",
    "Work",
]

with deferred():  # USD's loader imports modules of Python from C++
    for _module in __all__:
        if _module not in ("UsdLux", "Work"):
            import_module(f"pxr.{_module}")

from pxr import Ar, Gf, Pcp, Plug, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdRender, UsdShade, UsdUtils, Vt  # noqa: TID253

SCHEMAS = Path(__file__).parent / "schemas"
"""Folder of `plugInfo.json` and `generatedSchema.usda`: codeless schemas of sensors and graphs."""

Plug.Registry().RegisterPlugins(str(SCHEMAS))

EARLIEST = Usd.TimeCode.EarliestTime()
"""The time at which scenes are read: authored defaults, or the first sample of values that are only animated."""


def __getattr__(name: str) -> Any:
    """`UsdLux`, which only pictures need, and `Work`, at their first use."""
    if name not in ("UsdLux", "Work"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with deferred():
        return import_module(f"pxr.{name}")
