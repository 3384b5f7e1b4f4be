"""Small worlds of the cases: an App that plays inline prims, and what its sensors see."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from graph.cli.extreme_cases import Prims, playing, refusal


def ahead(place: Any, distance: float) -> Any:
    """(3,) so far along x from a place."""
    return np.asarray(place, float) + np.array([distance, 0.0, 0.0])


def mesh(points: Any, faces: Any, **keys: Any) -> dict[str, Any]:
    """A mesh of these faces."""
    return {"type": "Mesh", "points": np.asarray(points, float).tolist(), "faces": [*map(list, faces)], **keys}


def directions(azimuth: Any, elevation: Any = 0.0) -> Any:
    """(n, 3) unit vectors of angles [deg]."""
    a, e = np.radians(np.broadcast_arrays(np.asarray(azimuth, float), np.asarray(elevation, float)))
    return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)


def told(warnings: Iterable[Any], code: str) -> str:
    """The first warning with this code, with its place; empty without one."""
    return next((f"{one.code}: {one.where}: {one.message}" for one in warnings if one.code == code), "")


def unplayable(prims: Prims, updates: int = 0, **options: Any) -> str:
    """The line with which these prims are refused, at play or within some updates; empty if they are not."""

    def play() -> None:
        with playing(prims, **options) as app:
            app.update(updates)

    return refusal(play)
