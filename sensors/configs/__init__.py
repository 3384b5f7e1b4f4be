"""Sensor configurations: the shipped ones by name, vendor profiles by path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pxr import Usd

    from .catalog import Variant


def author_config(
    prim: Usd.Prim,
    config: str,
    variant: Variant = None,
    *,
    roots: Sequence[Path] = (),
    base: Path | None = None,
) -> None:
    """Writes every attribute of a named configuration, or of a vendor profile's file, on a sensor prim.

    tickRate is set to the scan rate. Raises UserError for a configuration that cannot be found or read, and for prims
    of a type without configurations.
    """
    from graph.base.errors import UserError
    from sensors.sensor_types import sensor_types

    authors = {name: kind.author for name, kind in sensor_types().items() if kind.author is not None}
    author = authors.get(str(prim.GetTypeName()))
    if author is None:
        raise UserError(
            f"{prim.GetPath()}: a {prim.GetTypeName() or 'typeless prim'} takes no config; only {' or '.join(authors)} "
            "does"
        )
    author(prim, config, variant, roots=roots, base=base)


def __getattr__(name: str) -> Any:
    if name == "SUPPORTED_LIDAR_CONFIGS":
        from .catalog import supported

        return supported()
    if name == "SUPPORTED_CAMERA_CONFIGS":
        from .cameras import supported_cameras

        return supported_cameras()
    raise AttributeError(f"module {__name__} has no attribute {name}")
