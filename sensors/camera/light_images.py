"""The images of lights: skies of domes, textures of rectangles, slides of projectors.

A projector is a RectLight with `isProjector`. Its pattern (`inputs:texture:file`) is thrown in the directions of a
table (`projector:directionTexture:file`), one for each place of the pattern, from the middle of the rectangle: sharp at
every distance. Seen from where a place of the pattern goes, the rectangle is as bright as that place is: radiance
L = intensity x pattern, the light of a lens in front of a slide. Elsewhere it is dark.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.sim.transforms import apply

from .image_files import ImageFiles, ImageProblem
from .lens import Floats
from .names import text_of
from .sky import SkyImage, sky_image
from .tables import read_directions
from .textures import Texture, linear_table

if TYPE_CHECKING:
    from pxr import Usd


PATTERN, DIRECTIONS = "inputs:texture:file", "projector:directionTexture:file"
STEPS = 20
CLOSE = 1e-6
"""A place is found when it moves by less [texels]."""

SURE = 1e-2
"""A place that still moves by more in the end has no direction [texels]."""


@dataclass(frozen=True, eq=False)
class Slide:
    """pattern: the image on the slide. tangents: (2, h, w) float64, x / z and y / z of the directions of the table's
    texels, optical axes, not a number for texels without a direction. h and w are 2 or more.
    """

    pattern: Texture
    tangents: Floats

    def thrown(self, ways: np.ndarray) -> np.ndarray:
        """(3, k) float32, red, green, blue that go along ways (3, k) of any length, in the axes of the light."""
        right, up, back = ways.astype(np.float64)
        found = np.zeros((3, len(right)), np.float32)
        ahead = np.flatnonzero(back < 0)
        across, down = self.places(right[ahead] / -back[ahead], up[ahead] / back[ahead])
        inside = (across >= 0) & (across <= 1) & (down >= 0) & (down <= 1)
        st = np.stack([across[inside], 1 - down[inside]]).astype(np.float32)
        found[:, ahead[inside]] = np.maximum(self.pattern.at(st, range(3)).T, np.float32(0))
        return found

    def places(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Where in the pattern, from 0 to 1 across and down, the directions of tangents (k,) come from.

        Newton's method between four texels, from the affine map that fits the table best; not a number, or beyond 0 to
        1, for directions in which nothing goes.
        """
        _, height, width = self.tangents.shape
        column, row = apply(self._affine, np.stack([x, y, np.ones_like(x)]), axis=0)
        step = np.full(len(x), np.inf)
        with np.errstate(all="ignore"):
            for _ in range(STEPS):
                (u, v), along, below = self._cell(column, row)
                u, v = u - x, v - y
                determinant = along[0] * below[1] - along[1] * below[0]
                right, low = (u * below[1] - v * below[0]) / determinant, (v * along[0] - u * along[1]) / determinant
                column, row = column - right, row - low
                step = np.abs(right) + np.abs(low)
                if not np.nanmax(step, initial=0.0) > CLOSE:
                    break
            sure = step < SURE
        return np.where(sure, (column + 0.5) / width, np.nan), np.where(sure, (row + 0.5) / height, np.nan)

    def _cell(self, column: Floats, row: Floats) -> tuple[Floats, Floats, Floats]:
        """The tangents (2, k) at places [texels], and how they grow by a texel to the right and down."""
        _, height, width = self.tangents.shape
        left = np.clip(np.nan_to_num(column), 0, width - 2).astype(np.int64)
        top = np.clip(np.nan_to_num(row), 0, height - 2).astype(np.int64)
        across, down = column - left, row - top
        first, right = self.tangents[:, top, left], self.tangents[:, top, left + 1]
        low, corner = self.tangents[:, top + 1, left], self.tangents[:, top + 1, left + 1]
        twist = corner - right - low + first
        along, below = right - first + down * twist, low - first + across * twist
        return first + across * (right - first) + down * below, along, below

    @cached_property
    def _affine(self) -> Floats:
        """(2, 3), from tangents to texels: least squares over a part of the table."""
        _, height, width = self.tangents.shape
        rows, columns = (np.unique(np.linspace(0, size - 1, 64).astype(np.int64)) for size in (height, width))
        x, y = (self.tangents[axis][np.ix_(rows, columns)].ravel() for axis in (0, 1))
        down, across = (each.ravel().astype(np.float64) for each in np.meshgrid(rows, columns, indexing="ij"))
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            return np.full((2, 3), np.nan)
        given = np.stack([x, y, np.ones_like(x)])[:, known]
        return np.asarray(np.linalg.lstsq(given.T, np.stack([across, down])[:, known].T, rcond=None)[0].T)


def read_slide(prim: Any, files: ImageFiles) -> Slide:
    """The slide of a projector. Raises ImageProblem for its pattern, UserError for its directions."""
    image = files.read(prim.GetAttribute(PATTERN))
    ones = np.ones(4, np.float32)
    pattern = Texture(image, linear_table(image, "auto"), ("clamp", "clamp"), ones, 0 * ones)
    directions, _ = read_directions(prim, DIRECTIONS, files)
    if min(directions.shape[:2]) < 2:
        directions = np.repeat(np.repeat(directions, 2, axis=0), 2, axis=1) * np.nan
    x, y, z = np.moveaxis(directions, 2, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return Slide(pattern, np.where(z > 0, np.stack([x, y]) / z, np.nan))


Warn = Callable[[str, str, str], None]


class LightImages:
    """The images of lights by the paths of their prims, each read when its light first shines."""

    def __init__(self, files: ImageFiles) -> None:
        self._files = files
        self._found: dict[str, Any] = {}

    def sky(self, prim: Usd.Prim, warn: Warn) -> SkyImage | None:
        """That of a dome; None for one of one colour. warn: gets `texture-not-read` and `light-not-modelled`."""
        found: SkyImage | None = self._once(prim, self._sky, "the sky has one plain colour", warn)
        return found

    def mean(self, prim: Usd.Prim, warn: Warn) -> np.ndarray | None:
        """(3,) float32, the mean of a texture; None without one."""
        found: np.ndarray | None = self._once(prim, self._mean, "the light has one plain colour", warn)
        return found

    def slide(self, prim: Usd.Prim, warn: Warn) -> Slide | None:
        """What a projector throws; None if that cannot be read."""
        found: Slide | None = self._once(prim, lambda prim, _: read_slide(prim, self._files), "it stays dark", warn)
        return found

    def _once(self, prim: Usd.Prim, read: Callable[[Any, Warn], Any], instead: str, warn: Warn) -> Any:
        path = str(prim.GetPath())
        if path not in self._found:
            try:
                self._found[path] = read(prim, warn)
            except (ImageProblem, UserError) as problem:
                warn("texture-not-read", path, f"{problem}; {instead}")
                self._found[path] = None
        return self._found[path]

    def _sky(self, prim: Usd.Prim, warn: Warn) -> SkyImage | None:
        layout = text_of(prim.GetAttribute("inputs:texture:format"))
        if self._named(prim) and layout not in ("", "automatic", "latlong"):
            said = f"its image is laid out as {layout}, not latlong: the sky has one colour"
            warn("light-not-modelled", str(prim.GetPath()), said)
            return None
        return sky_image(self._texture(prim, "repeat")) if self._named(prim) else None

    def _mean(self, prim: Usd.Prim, warn: Warn) -> np.ndarray | None:
        return np.array(self._texture(prim, "clamp").mean(range(3)), np.float32) if self._named(prim) else None

    def _named(self, prim: Usd.Prim) -> bool:
        return bool(text_of(prim.GetAttribute(PATTERN)))

    def _texture(self, prim: Usd.Prim, across: str) -> Texture:
        image = self._files.read(prim.GetAttribute(PATTERN))
        ones = np.ones(4, np.float32)
        return Texture(image, linear_table(image, "auto"), (across, "clamp"), ones, 0 * ones)
