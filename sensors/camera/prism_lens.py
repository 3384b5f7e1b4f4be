"""A fisheye whose elements are tilted and not round: odd radial polynomial, tangential terms, thin prism."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass

from .lens import NEWTON_STEPS, TOLERANCE, FisheyeLens, Floats


@dataclass(frozen=True)
class PrismFisheyeLens(FisheyeLens):
    """A fisheye with p: p0, p1 (tangential) and s: s0 to s3 (thin prism) on top of its radial image (x, y).

    x' = x + p0 (r2 + 2 x2) + 2 p1 x y + s0 r2 + s1 r4 and y' = y + p1 (r2 + 2 y2) + 2 p0 x y + s2 r2 + s3 r4, with r2
    = x2 + y2: the model "Fisheye624" of Project Aria (projectaria_tools, camera intrinsic models).
    """

    p: tuple[float, ...] = (0.0,) * 2
    s: tuple[float, ...] = (0.0,) * 4

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """As the base."""
        return self._shift(*super().distort(directions))

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """As the base: Newton's method on both coordinates, then on the angle."""
        target_x, target_y = np.array(x, np.float64), np.array(y, np.float64)
        x, y = target_x.copy(), target_y.copy()
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                off_x, off_y = self._off(x, y, target_x, target_y)
                if not np.nanmax(np.abs([off_x, off_y]), initial=0.0) > TOLERANCE:
                    break
                a, b, c, d = self._jacobian(x, y)
                determinant = a * d - b * c
                x = x - (d * off_x - b * off_y) / determinant
                y = y - (a * off_y - c * off_x) / determinant
            off_x, off_y = self._off(x, y, target_x, target_y)
            good = (np.abs(off_x) < 1e-9) & (np.abs(off_y) < 1e-9)
        return super().straighten(np.where(good, x, np.nan), np.where(good, y, np.nan))

    def _off(self, x: Floats, y: Floats, target_x: Floats, target_y: Floats) -> tuple[Floats, Floats]:
        found_x, found_y = self._shift(x, y)
        return found_x - target_x, found_y - target_y

    def _shift(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        p0, p1, s0, s1, s2, s3 = *self.p, *self.s
        r2 = x * x + y * y
        return (
            x + p0 * (r2 + 2 * x * x) + 2 * p1 * x * y + r2 * (s0 + s1 * r2),
            y + p1 * (r2 + 2 * y * y) + 2 * p0 * x * y + r2 * (s2 + s3 * r2),
        )

    def _jacobian(self, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """dx'/dx, dx'/dy, dy'/dx, dy'/dy."""
        p0, p1, s0, s1, s2, s3 = *self.p, *self.s
        r2 = x * x + y * y
        across, down = 2 * (s0 + 2 * s1 * r2), 2 * (s2 + 2 * s3 * r2)
        return (
            1 + 6 * p0 * x + 2 * p1 * y + across * x,
            2 * p0 * y + 2 * p1 * x + across * y,
            2 * p1 * x + 2 * p0 * y + down * x,
            1 + 6 * p1 * y + 2 * p0 * x + down * y,
        )
