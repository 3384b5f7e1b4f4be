"""Lenses given by look-up tables (`OmniLensDistortionLutAPI`): two images of floats in OpenEXR files.

rayEnterDirectionTexture holds the direction of each place of the image in red, green, blue: unit, in the axes of a USD
camera (x right, y up, looking along -z); (0, 0, 1) where the lens has no ray. rayExitPositionTexture holds, at the
octahedral projection of a direction whose middle is -z, where in the image it goes, both from 0 to 1 (NVIDIA, "How to
generate textures for OmniLensDistortionLutAPI", developer forum, 2025). First rows are on top; texels are about the
middles of equal parts of the image.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass, field

from .image_files import ImageFiles
from .lens import Floats, Lens
from .names import LENS
from .tables import between, read_directions, read_table

ENTER, EXIT = f"{LENS}lut:rayEnterDirectionTexture", f"{LENS}lut:rayExitPositionTexture"


@dataclass(frozen=True)
class LutLens(Lens):
    """directions: (h, w, 3), optical axes, 0 without a ray; places: (h, w, 2), 0 to 1, of directions, or None.

    key: of the tables' content, by which lenses are compared. fx, fy, cx, cy: those of the pinhole that is alike in the
    middle of the image. Without `places` nothing is projected.
    """

    key: str = ""
    directions: Floats = field(compare=False, default_factory=lambda: np.zeros((1, 1, 3)))
    places: Floats | None = field(compare=False, default=None)

    def unproject(self, pixels: Floats) -> Floats:
        """As of every lens; between texels by their distance."""
        u, v = pixels
        found = between(self.directions, u / self.width, v / self.height)
        length = np.sqrt((found**2).sum(axis=0))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(length > 0.5, found / length, 0.0)  # dark beside texels without a ray

    def project(self, directions: Floats) -> Floats:
        """As of every lens."""
        x, y, z = directions[0], -directions[1], directions[2]
        if self.places is None:
            return np.full((2, len(x)), np.nan)
        with np.errstate(invalid="ignore", divide="ignore"):
            x, y, z = np.stack([x, y, z]) / (np.abs(x) + np.abs(y) + np.abs(z))
        behind = z < 0
        folded = (1 - np.abs(y)) * np.where(x < 0, -1.0, 1.0), (1 - np.abs(x)) * np.where(y < 0, -1.0, 1.0)
        x, y = np.where(behind, folded[0], x), np.where(behind, folded[1], y)
        u, v = between(self.places, (x + 1) / 2, (y + 1) / 2)
        inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        return np.where(inside, np.stack([u * self.width, v * self.height]), np.nan)


def check_tables(prim: Any, size: tuple[int, int] | None) -> None:
    """Raises UserError for a prim that names no table of directions, or a centre of its own; size: if it is known."""
    where = f"{prim.GetPath()}.{ENTER}"
    if not prim.HasAttribute(ENTER):
        raise UserError(f"{where} is missing; apply OmniLensDistortionLutAPI and name the table")
    if not str(getattr(_value(prim, ENTER), "path", "")):
        raise UserError(f"{where} names no file; give it the OpenEXR file of directions")
    nominal = [
        _number(prim, f"nominal{side}", default)
        for side, default in zip(("Width", "Height"), size or (np.nan, np.nan), strict=True)
    ]
    centre = _value(prim, f"{LENS}lut:opticalCenter")
    if centre is not None and not np.isnan(nominal).any() and not np.allclose(centre, np.array(nominal) / 2, atol=1e-3):
        raise UserError(f"{prim.GetPath()}.{LENS}lut:opticalCenter: tables hold the centre; give half the nominal size")


def read_lut_lens(prim: Any, size: tuple[int, int], files: ImageFiles) -> LutLens:
    """The lens of a prim with look-up tables, for an image of `size`, as `check_tables` lets it pass.

    Raises UserError for tables that are missing, are not allowed or hold no directions, and without OpenEXR.
    """
    directions, data = read_directions(prim, ENTER, files)
    places = None
    if str(getattr(_value(prim, EXIT), "path", "")):
        exits, more = read_table(prim, EXIT, files)
        places, data = exits[..., :2].astype(np.float64), data + more
    width, height = size
    lens = LutLens(width, height, 1.0, 1.0, width / 2, height / 2, data, directions, places)
    beside = np.array([[-1.0, 1, 0, 0], [0, 0, -1.0, 1]]) + np.array([[width / 2], [height / 2]])
    x, y, z = lens.unproject(beside)
    with np.errstate(invalid="ignore", divide="ignore"):
        focal = 2 / ((x / z)[1] - (x / z)[0]), 2 / ((y / z)[3] - (y / z)[2])
    if not (np.isfinite(focal).all() and min(focal) > 0):
        raise UserError(f"{prim.GetPath()}.{ENTER} has no direction ahead in the middle of the image; correct it")
    fx, fy = map(float, focal)
    return LutLens(width, height, fx, fy, width / 2, height / 2, data, directions, places)


def _number(prim: Any, name: str, default: float) -> float:
    value = _value(prim, f"{LENS}lut:{name}")
    return float(default if value is None else value)


def _value(prim: Any, name: str) -> Any:
    return prim.GetAttribute(name).Get() if prim.HasAttribute(name) else None
