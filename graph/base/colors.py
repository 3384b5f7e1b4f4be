"""Colors by name."""

from __future__ import annotations

from typing import Any


def color(name: Any) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 of a name or a code of Matplotlib: "C2", "0.5", "#abc". Raises ValueError."""
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(name)
    return red, green, blue
