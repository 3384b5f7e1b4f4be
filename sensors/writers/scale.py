"""What makes a picture readable: rings of equal range with labels, the sensor's mark, and a bar of colours."""

from __future__ import annotations

from typing import Any

import numpy as np

from .palette import palette

RING, TEXT, MARK = (74, 82, 96), (214, 220, 230), (255, 96, 64)
APART = 90
"""Pixels between rings at least."""
BAR_HEIGHT = 26
TEXT_HEIGHT = 13
STEPS = (1.0, 2.0, 5.0)


def ring_step(pixels: float) -> float:
    """The distance between rings [m]: 1, 2 or 5 times a power of ten, at least `APART` pixels; pixels: of a metre."""
    power = 10.0 ** np.floor(np.log10(APART / pixels))
    return float(next(step for step in (*(one * power for one in STEPS), 10 * power) if step * pixels >= APART - 1e-9))


def draw_rings(image: Any, middle: tuple[float, float], pixels: float) -> None:
    """Rings about a place (column, row) in an RGB image, with their ranges upwards and downwards."""
    from PIL import ImageDraw

    pen, step = ImageDraw.Draw(image), ring_step(pixels)
    corners = [np.hypot(x - middle[0], y - middle[1]) for x in (0, image.width) for y in (0, image.height)]
    for number in range(1, int(max(corners) / pixels / step) + 1):
        radius = number * step * pixels
        pen.ellipse([middle[0] - radius, middle[1] - radius, middle[0] + radius, middle[1] + radius], outline=RING)


def draw_labels(image: Any, middle: tuple[float, float], pixels: float) -> None:
    """The ranges of the rings, above the sensor, or beside or below it where that is outside of the image."""
    from PIL import ImageDraw

    pen, step, font = ImageDraw.Draw(image), ring_step(pixels), _font()
    inside = {(0, -1): middle[1], (1, 0): image.width - middle[0], (0, 1): image.height - middle[1], (-1, 0): middle[0]}
    way = (0, -1) if inside[0, -1] >= 2 * step * pixels else max(inside, key=lambda one: inside[one])
    for number in range(1, int(inside[way] / pixels / step) + 1):
        away = number * step * pixels
        text = f"{number * step:g} m"
        least = pen.textlength(text, font=font) / 2 + 3, TEXT_HEIGHT / 2 + 3  # the whole text is inside of the image
        most = image.width - least[0], image.height - least[1]
        place = tuple(max(least[axis], min(middle[axis] + way[axis] * away, most[axis])) for axis in (0, 1))
        pen.text(place, text, fill=TEXT, font=font, anchor="mm", stroke_width=2, stroke_fill=(8, 8, 12))


def draw_mark(image: Any, middle: tuple[float, float], heading: tuple[float, float]) -> None:
    """The sensor: a triangle at its place whose point is ahead; heading: columns and rows to the right and down."""
    from PIL import ImageDraw

    length = float(np.hypot(*heading))
    ahead = np.array(heading) / length if length > 1e-9 else np.array((0.0, -1.0))
    left = np.array((ahead[1], -ahead[0]))
    corners = [ahead * 11, left * 7 - ahead * 7, -left * 7 - ahead * 7]
    ImageDraw.Draw(image).polygon([tuple(np.array(middle) + one) for one in corners], fill=MARK, outline=(8, 8, 12))


def with_bar(image: Any, low: float, high: float, what: str) -> Any:
    """The image above a bar of the palette with its ends; what: its quantity and unit."""
    from PIL import Image, ImageDraw

    made = Image.new("RGB", (image.width, image.height + BAR_HEIGHT), (8, 8, 12))
    made.paste(image, (0, 0))
    pen, font = ImageDraw.Draw(made), _font()
    row = image.height + BAR_HEIGHT // 2
    first, last = f"{what} {low:.3g}", f"{high:.3g}"
    left, right = 12 + pen.textlength(first, font=font), image.width - 12 - pen.textlength(last, font=font)
    pen.text((6, row), first, fill=TEXT, font=font, anchor="lm")
    pen.text((image.width - 6, row), last, fill=TEXT, font=font, anchor="rm")
    wide = int(right - left)
    if wide > 8:
        strip = palette()[1 + np.arange(wide) * 254 // max(1, wide - 1)]
        made.paste(Image.fromarray(np.repeat(strip[None], 10, axis=0)), (int(left), row - 5))
    return made


def _font() -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(TEXT_HEIGHT)
