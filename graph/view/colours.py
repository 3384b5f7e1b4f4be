"""Numbers as colours in pictures: the palette Turbo (A. Mikhailov, 2019), as plotly ships it."""

from __future__ import annotations

import base64
from functools import cache
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

NOTHING = (24, 26, 32)
"""Colour of a cell without a value."""


@cache
def palette() -> NDArray[np.uint8]:
    """(256, 3) colours; the first is that of cells without a value."""
    from plotly.colors import get_colorscale, sample_colorscale

    colours = sample_colorscale(get_colorscale("Turbo"), np.linspace(0, 1, 255).tolist(), colortype="tuple")
    found: NDArray[np.uint8] = np.round(np.array([[n / 255 for n in NOTHING], *colours]) * 255).astype(np.uint8)
    return found


def indices(values: NDArray[Any], low: float, high: float) -> NDArray[np.uint8]:
    """Palette numbers of values: 1 at `low` and below, 255 at `high` and above, 0 where a value is not finite."""
    share = (np.asarray(values, np.float64) - low) / ((high - low) or 1.0)
    known = np.isfinite(share)
    found = np.where(known, 1 + np.round(np.clip(np.where(known, share, 0), 0, 1) * 254), 0)
    return found.astype(np.uint8)


def picture(numbers: NDArray[np.uint8]) -> Any:
    """The image of an array (height, width) of palette numbers."""
    from PIL import Image

    image = Image.fromarray(numbers, "P")
    image.putpalette(palette().reshape(-1).tobytes())
    return image


def source(image: Any, form: str) -> str:
    """An image as the address that a page shows: PNG or JPEG as base64."""
    stream = BytesIO()
    image.save(stream, form, **({"quality": 82} if form == "JPEG" else {"optimize": True}))
    return f"data:image/{form.lower()};base64,{base64.b64encode(stream.getvalue()).decode()}"
