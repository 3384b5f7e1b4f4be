"""Lenses: which pixel sees which direction, and the other way round.

Directions are in the optical frame of OpenCV and ROS: x to the right, y down, z forward. Pixel (i, j), column i of row
j, has its centre at (i + 0.5, j + 0.5); u counts columns, v rows, both from the corner at the top left.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass

Floats = NDArray[np.float64]

NEWTON_STEPS = 30
TOLERANCE = 1e-12
FARTHEST = 20.0
"""The largest tangent of an angle to the optical axis up to which a rational lens is looked at."""

STEEPEST = np.pi
"""The largest angle to the optical axis that any lens images [rad]."""


@dataclass(frozen=True)
class Lens:
    """A pinhole without distortion; subclasses distort.

    width, height [px]; fx, fy, cx, cy: focal lengths and the place where the optical axis meets the image [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def project(self, directions: Floats) -> Floats:
        """(2, n) u, v [px] of directions (3, n) of any length; not a number for those that the lens does not image."""
        x, y = self.distort(directions)
        return np.stack([self.fx * x + self.cx, self.fy * y + self.cy])

    def unproject(self, pixels: Floats) -> Floats:
        """(3, n) unit directions of u, v (2, n) [px]; 0, 0, 0 where the lens has no ray."""
        u, v = pixels
        found = self.straighten((u - self.cx) / self.fx, (v - self.cy) / self.fy)
        length = np.sqrt((found**2).sum(axis=0))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(np.isfinite(length) & (length > 0), found / length, 0.0)

    def centres(self) -> Floats:
        """(2, height x width) u, v of all pixels, row by row."""
        u, v = np.arange(self.width) + 0.5, np.arange(self.height) + 0.5
        return np.stack([np.tile(u, self.height), np.repeat(v, self.width)])

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """Where directions (3, n) meet the image plane at distance 1; not a number where they do not."""
        x, y, z = directions
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(z > 0, x / z, np.nan), np.where(z > 0, y / z, np.nan)

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """(3, n) directions of points of the image plane at distance 1; NaN without an image point."""
        return np.stack([x, y, np.ones_like(x)])

    @property
    def is_pinhole(self) -> bool:
        """Whether straight lines stay straight."""
        return type(self) is Lens


@dataclass(frozen=True)
class BrownLens(Lens):
    """OpenCV's pinhole with distortion: rational radial, tangential, thin prism.

    k: k1 to k6; p: p1, p2; s: s1 to s4. x' = x g + 2 p1 x y + p2 (r2 + 2 x2) + s1 r2 + s2 r4, and y' likewise, with
    g = (1 + k1 r2 + k2 r4 + k3 r6) / (1 + k4 r2 + k5 r4 + k6 r6) (OpenCV, "Camera Calibration and 3D Reconstruction").
    """

    k: tuple[float, ...] = (0.0,) * 6
    p: tuple[float, ...] = (0.0,) * 2
    s: tuple[float, ...] = (0.0,) * 4

    @cached_property
    def fold(self) -> float:
        """The tangent of the angle from which on the radial part turns back, so that it has no inverse."""
        r = np.linspace(0.0, FARTHEST, 200_001)
        bent = r * self._radial(r * r)[0]
        back = np.flatnonzero(~(np.diff(bent) > 0))
        return float(r[back[0]]) if len(back) else np.inf

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """As the base; also not a number beyond the fold."""
        x, y = super().distort(directions)
        with np.errstate(invalid="ignore"):
            x = np.where(x * x + y * y <= self.fold**2, x, np.nan)
        return self._bend(x, y)

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """As the base: Newton's method on both coordinates, from the point that the radial part alone gives."""
        target_x, target_y = np.array(x, np.float64), np.array(y, np.float64)
        known = np.linspace(0.0, min(self.fold, FARTHEST), 4097)
        level = np.hypot(target_x, target_y)
        start = np.interp(level, known * self._radial(known * known)[0], known)
        share = np.divide(start, level, out=np.ones_like(level), where=level > 0)
        x, y = target_x * share, target_y * share
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                off_x, off_y = self._bend(x, y)
                off_x, off_y = off_x - target_x, off_y - target_y
                if not np.nanmax(np.abs([off_x, off_y]), initial=0.0) > TOLERANCE:
                    break
                a, b, c, d = self._jacobian(x, y)
                determinant = a * d - b * c
                x = x - (d * off_x - b * off_y) / determinant
                y = y - (a * off_y - c * off_x) / determinant
            off_x, off_y = self._bend(x, y)
            good = (np.abs(off_x - target_x) < 1e-9) & (np.abs(off_y - target_y) < 1e-9)
            good &= x * x + y * y <= self.fold**2
        return np.where(good, np.stack([x, y, np.ones_like(x)]), np.nan)

    def _radial(self, r2: Floats) -> tuple[Floats, Floats]:
        """g, and its derivative by r2."""
        k1, k2, k3, k4, k5, k6 = self.k
        above = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6))
        slope_above = k1 + r2 * (2 * k2 + 3 * r2 * k3)
        slope_below = k4 + r2 * (2 * k5 + 3 * r2 * k6)
        with np.errstate(divide="ignore", invalid="ignore"):
            return above / below, (slope_above * below - above * slope_below) / below**2

    def _bend(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        p1, p2, s1, s2, s3, s4 = *self.p, *self.s
        r2 = x * x + y * y
        g, _ = self._radial(r2)
        return (
            x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * (s1 + s2 * r2),
            y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * (s3 + s4 * r2),
        )

    def _jacobian(self, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """dx'/dx, dx'/dy, dy'/dx, dy'/dy."""
        p1, p2, s1, s2, s3, s4 = *self.p, *self.s
        r2 = x * x + y * y
        g, slope = self._radial(r2)
        prism_x, prism_y = 2 * (s1 + 2 * s2 * r2), 2 * (s3 + 2 * s4 * r2)
        cross = 2 * x * y * slope
        return (
            g + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x + prism_x * x,
            cross + 2 * p1 * x + 2 * p2 * y + prism_x * y,
            cross + 2 * p1 * x + 2 * p2 * y + prism_y * x,
            g + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x + prism_y * y,
        )


@dataclass(frozen=True)
class FisheyeLens(Lens):
    """A lens whose image radius is an odd polynomial of the angle to the axis: r(a) = c0 a + c1 a^3 + c2 a^5 + ...

    OpenCV's fisheye has c0 = 1 and c1 to c4 = k1 to k4. most: the largest angle that is imaged [rad].
    """

    coefficients: tuple[float, ...] = (1.0,)
    most: float = STEEPEST

    def radius(self, angle: Floats) -> Floats:
        """The distance from the axis in the image plane at distance 1."""
        squared, total = angle * angle, np.zeros_like(angle)
        for coefficient in reversed(self.coefficients):
            total = total * squared + coefficient
        return total * angle

    @cached_property
    def fold(self) -> float:
        """The largest angle [rad] that the lens images: where the radius ceases to grow, or `most`."""
        angle = np.linspace(0.0, min(self.most, STEEPEST), 100_001)
        back = np.flatnonzero(~(np.diff(self.radius(angle)) > 0))
        return float(angle[back[0]] if len(back) else angle[-1])

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """As the base; angles beyond 90 deg are imaged too, up to the fold."""
        x, y, z = directions
        level = np.hypot(x, y)
        angle = np.arctan2(level, z)
        with np.errstate(invalid="ignore", divide="ignore"):
            scale = np.where(level > 0, self.radius(angle) / level, 0.0)
        scale = np.where(angle <= self.fold, scale, np.nan)
        return x * scale, y * scale

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """As the base: Newton's method on the angle."""
        level = np.hypot(x, y)
        angle = self.angle(level)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(level > 0, np.sin(angle) / level, 0.0)
        return np.stack([x * share, y * share, np.cos(angle)])

    def angle(self, radius: Floats) -> Floats:
        """The angle to the axis [rad] of image radii; not a number beyond the fold."""
        slopes = [(2 * power + 1) * one for power, one in enumerate(self.coefficients)]
        known = np.linspace(0.0, self.fold, 1025)
        angle = np.interp(radius, self.radius(known), known)  # so that Newton begins below the fold, where it is flat
        for _ in range(NEWTON_STEPS):
            off = self.radius(angle) - radius
            squared, slope = angle * angle, np.zeros_like(angle)
            for one in reversed(slopes):
                slope = slope * squared + one
            with np.errstate(invalid="ignore", divide="ignore"):
                step = np.where(slope > 0, off / slope, 0.0)
            angle = np.clip(angle - step, 0.0, self.fold)
            if not np.abs(step).max(initial=0.0) > TOLERANCE:
                break
        return np.where(np.abs(self.radius(angle) - radius) <= 1e-9 * np.maximum(radius, 1.0), angle, np.nan)


@dataclass(frozen=True)
class FthetaLens(Lens):
    """The f-theta polynomial of Omniverse: the angle to the axis [rad] is k0 + k1 r + k2 r^2 + ... of the radius r.

    r in pixels of the nominal image: fx and fy are the pixels here for one of these. most: the largest angle that is
    imaged [rad].
    (The sources do not agree which way round the polynomial goes; only this one makes sense of its default k1.)
    """

    coefficients: tuple[float, ...] = (0.0, 0.00245)
    most: float = np.deg2rad(100.0)

    def angle(self, radius: Floats) -> Floats:
        """The angle to the axis [rad] of radii [nominal px]."""
        total = np.zeros_like(radius)
        for coefficient in reversed(self.coefficients):
            total = total * radius + coefficient
        return total

    @cached_property
    def fold(self) -> tuple[float, float]:
        """Radius [nominal px] and angle [rad] up to which the angle grows, and not beyond `most`."""
        radius = np.linspace(0.0, 4.0 * np.hypot(self.width / self.fx, self.height / self.fy), 200_001)
        angle = self.angle(radius)
        end = np.flatnonzero(~(np.diff(angle) > 0) | (angle[1:] > self.most))
        last = end[0] if len(end) else len(radius) - 1
        return float(radius[last]), float(angle[last])

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """As the base."""
        x, y, z = directions
        level = np.hypot(x, y)
        radius = self._radius(np.arctan2(level, z))
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(level > 0, radius / level, 0.0)
        return x * share, y * share

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """As the base."""
        radius = np.hypot(x, y)
        angle = np.where(radius <= self.fold[0], self.angle(radius), np.nan)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(radius > 0, np.sin(angle) / radius, 0.0)
        return np.stack([x * share, y * share, np.cos(angle)])

    def _radius(self, angle: Floats) -> Floats:
        """The radius [nominal px] of angles: Newton's method; not a number beyond the fold."""
        slopes = tuple(power * one for power, one in enumerate(self.coefficients))[1:]
        most, last = self.fold
        radius = angle / (last / most) if last > 0 else np.zeros_like(angle)
        for _ in range(NEWTON_STEPS):
            slope = np.zeros_like(radius)
            for one in reversed(slopes):
                slope = slope * radius + one
            with np.errstate(invalid="ignore", divide="ignore"):
                step = np.where(slope > 0, (self.angle(radius) - angle) / slope, 0.0)
            radius = np.clip(radius - step, 0.0, most)
            if not np.abs(step).max(initial=0.0) > TOLERANCE * most:
                break
        return np.where(np.abs(self.angle(radius) - angle) < 1e-9, radius, np.nan)


@dataclass(frozen=True)
class ParallelLens(Lens):
    """An orthographic camera: every ray goes straight ahead, from its own place. fx, fy: pixels in a metre."""

    def distort(self, directions: Floats) -> tuple[Floats, Floats]:
        """Of places (3, n) [m] in the optical frame: the image does not depend on their depth."""
        return directions[0], directions[1]

    def straighten(self, x: Floats, y: Floats) -> Floats:
        """Straight ahead."""
        return np.stack([np.zeros_like(x), np.zeros_like(y), np.ones_like(x)])

    def origins(self, shift: tuple[float, float] = (0.0, 0.0)) -> Floats:
        """(3, height x width) [m], where the ray of each pixel starts, `shift` [px] from its middle, optical frame."""
        u, v = self.centres() + np.array(shift)[:, None]
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.zeros_like(u)])


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
