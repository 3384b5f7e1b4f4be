"""A perspective drawing of points."""

from __future__ import annotations

import numpy as np
from drawing import PANEL
from matplotlib.colors import to_rgb


class Lens:
    """A pinhole at `eye` that looks at `target`, world [m]; size: pixels; wide: degrees across."""

    def __init__(self, eye: tuple[float, ...], target: tuple[float, ...], size: tuple[int, int], wide: float) -> None:
        forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
        right = np.cross(forward, (0, 0, 1))
        right /= np.linalg.norm(right)
        self.turn = np.stack([right, np.cross(right, forward), forward])
        self.eye, self.size, self.scale = np.array(eye), size, size[0] / 2 / np.tan(np.radians(wide) / 2)

    def project(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (n, 2) from the upper left corner, and depths (n,) [m]."""
        local = (np.asarray(places, np.float64) - self.eye) @ self.turn.T
        depth = local[:, 2]
        near = np.where(depth > 0.1, depth, np.nan)
        return np.stack(
            [self.size[0] / 2 + self.scale * local[:, 0] / near, self.size[1] / 2 - self.scale * local[:, 1] / near], 1
        ), depth

    def draw(self, picture: np.ndarray, places: np.ndarray, colours: np.ndarray, dot: float, far: float) -> None:
        """Paints points (n, 3) with colours (n, 3) from far to near; dot: their side [m]; they fade out until `far`."""
        at, depth = self.project(places)
        ahead = np.isfinite(at).all(axis=1) & (depth < far)
        order = np.argsort(-depth[ahead])
        at, depth, colours = at[ahead][order], depth[ahead][order], colours[ahead][order]
        fade = np.clip(1.15 - depth / far, 0.12, 1)[:, None]
        back = np.array(to_rgb(PANEL))
        shown = colours * fade + back * (1 - fade)
        side = np.clip(np.round(dot * self.scale / depth), 1, 9).astype(int)
        height, width = picture.shape[:2]
        for down in range(9):
            for across in range(9):
                used = side > max(down, across)
                column = np.floor(at[used, 0]).astype(int) + across
                row = np.floor(at[used, 1]).astype(int) + down
                inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
                picture[row[inside], column[inside]] = shown[used][inside]


def blank(size: tuple[int, int]) -> np.ndarray:
    """An empty picture (height, width, 3)."""
    return np.ones((size[1], size[0], 3)) * to_rgb(PANEL)


def halved(picture: np.ndarray) -> np.ndarray:
    """A picture of half the size, each pixel the mean of four."""
    height, width = picture.shape[0] // 2, picture.shape[1] // 2
    return picture.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
