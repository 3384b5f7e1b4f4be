"""Rolling shutters: the lines of an image are exposed one after the other."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass

from .names import SHUTTER

if TYPE_CHECKING:
    from pxr import Usd

ORDERS = ("topToBottom", "bottomToTop", "leftToRight", "rightToLeft")
FORWARD = ("topToBottom", "leftToRight")


@dataclass(frozen=True)
class RollingShutter:
    """order: one of `ORDERS`. offset: time between the starts of two lines [s]; exposure: of each line [s]."""

    order: str
    offset: Fraction
    exposure: Fraction

    def lines(self, size: tuple[int, int]) -> int:
        """Number of lines that are exposed one after the other, for a size (width, height)."""
        return size[1] if self.order in ORDERS[:2] else size[0]

    def duration(self, size: tuple[int, int]) -> Fraction:
        """Time from the start of the first line to the end of the last [s]."""
        return (self.lines(size) - 1) * self.offset + self.exposure


def read_shutter(prim: Usd.Prim) -> RollingShutter | None:
    """The rolling shutter of a camera; None for one that exposes all at once. Raises UserError for odd numbers."""
    order = prim.GetAttribute(f"{SHUTTER}scanOrder")
    if not order or str(order.Get() or "none") == "none":
        return None
    if str(order.Get()) not in ORDERS:
        raise UserError(f"{prim.GetPath()}.{SHUTTER}scanOrder is {order.Get()}; use none, {', '.join(ORDERS)}")
    return RollingShutter(str(order.Get()), _seconds(prim, "lineOffset"), _seconds(prim, "lineExposure"))


def _seconds(prim: Usd.Prim, name: str) -> Fraction:
    over, under = map(float, prim.GetAttribute(f"{SHUTTER}{name}").Get() or (0.0, 1.0))
    if not (np.isfinite(over) and over >= 0 and np.isfinite(under) and under > 0):
        text = f"({over:g}, {under:g})"
        raise UserError(f"{prim.GetPath()}.{SHUTTER}{name} is {text}; give seconds as a fraction, 0 or more")
    return Fraction(over).limit_denominator(10**9) / Fraction(under).limit_denominator(10**9)
