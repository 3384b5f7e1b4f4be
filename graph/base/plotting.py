"""What Matplotlib gives: colors by name, empty figures, figures as PNG."""

from __future__ import annotations

import io
from typing import Any

DPI = 110


def color(name: Any) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 of a name or a code of Matplotlib: "C2", "0.5", "#abc". Raises ValueError."""
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(name)
    return red, green, blue


def sheet(width: float, height: float) -> Any:
    """An empty figure [inch], drawn without a screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def png(figure: Any) -> bytes:
    """The figure as a PNG; the same bytes for the same figure."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    return stream.getvalue()
