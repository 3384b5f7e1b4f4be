"""Numbers as colours in the pictures of the page."""

from __future__ import annotations

import base64
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.writers.palette import palette


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
