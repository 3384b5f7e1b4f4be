"""Lenses given by look-up tables (`OmniLensDistortionLutAPI`): two images of floats in OpenEXR files.

rayEnterDirectionTexture holds the direction of each place of the image in red, green, blue: unit, in the axes of a USD
camera (x right, y up, looking along -z); (0, 0, 1) where the lens has no ray. rayExitPositionTexture holds, at the
octahedral projection of a direction whose middle is -z, where in the image it goes, both from 0 to 1 (NVIDIA, "How to
generate textures for OmniLensDistortionLutAPI", developer forum, 2025). First rows are on top; texels are about the
middles of equal parts of the image.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.limits import check

from .image_files import ImageFiles, ImageProblem
from .lens import Floats, Lens
from .names import LENS

ENTER, EXIT = f"{LENS}lut:rayEnterDirectionTexture", f"{LENS}lut:rayExitPositionTexture"
BACKWARD = np.array([0.0, 0.0, 1.0])
"""Marks a texel without a ray."""


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
        found = _between(self.directions, u / self.width, v / self.height)
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
        u, v = _between(self.places, (x + 1) / 2, (y + 1) / 2)
        inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        return np.where(inside, np.stack([u * self.width, v * self.height]), np.nan)


def read_lut_lens(prim: Any, size: tuple[int, int], files: ImageFiles) -> LutLens:
    """The lens of a prim with look-up tables, for an image of `size`.

    Raises UserError for tables that are missing, are not allowed or hold no directions, and without OpenEXR.
    """
    nominal = [
        _number(prim, f"nominal{side}", default) for side, default in zip(("Width", "Height"), size, strict=True)
    ]
    centre = _value(prim, f"{LENS}lut:opticalCenter") or [each / 2 for each in nominal]
    if not np.allclose(centre, np.array(nominal) / 2, atol=1e-3):
        raise UserError(f"{prim.GetPath()}.{LENS}lut:opticalCenter: tables hold the centre; give half the nominal size")
    enter, data = _table(prim, ENTER, files)
    if enter.shape[2] < 3:
        raise UserError(f"{prim.GetPath()}.{ENTER} has {enter.shape[2]} channels; a table of directions has three")
    directions = enter[..., :3].astype(np.float64) * (1.0, -1.0, -1.0)
    none = ~np.isfinite(directions).all(axis=2) | (np.abs(enter[..., :3] - BACKWARD) < 1e-6).all(axis=2)
    directions[none] = 0
    places = None
    if str(getattr(_value(prim, EXIT), "path", "")):
        exits, more = _table(prim, EXIT, files)
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


def _between(table: Floats, across: Floats, down: Floats) -> Floats:
    """(c, n) of a table (h, w, c) between the four texels about places from 0 to 1; its edge beyond."""
    height, width, _ = table.shape
    found = np.zeros((table.shape[2], len(across)))
    with np.errstate(invalid="ignore"):
        x, y = np.nan_to_num(across * width - 0.5), np.nan_to_num(down * height - 0.5)
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    for row, tall in ((top, 1 - (y - top)), (top + 1, y - top)):
        for column, wide in ((left, 1 - (x - left)), (left + 1, x - left)):
            texel = table[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
            found += texel.T * (tall * wide)
    return found


def _number(prim: Any, name: str, default: float) -> float:
    value = _value(prim, f"{LENS}lut:{name}")
    return float(default if value is None else value)


def _value(prim: Any, name: str) -> Any:
    return prim.GetAttribute(name).Get() if prim.HasAttribute(name) else None


def _table(prim: Any, name: str, files: ImageFiles) -> tuple[Floats, str]:
    """The image that an attribute names, (h, w, c) float, and a key of its content."""
    where = f"{prim.GetPath()}.{name}"
    if not prim.HasAttribute(name):
        raise UserError(f"{where} is missing; apply OmniLensDistortionLutAPI and name the table")
    try:
        file = files.allowed(prim.GetAttribute(name))
    except ImageProblem as problem:
        raise UserError(f"{where}: {problem}") from None
    try:
        import OpenEXR
    except ImportError:
        raise UserError(f"{where} is an OpenEXR file. Run: pip install 'tickgraph[exr]'") from None
    return _read(OpenEXR, file, where)


def _read(library: Any, file: Path, where: str) -> tuple[Floats, str]:
    try:
        with library.File(str(file), header_only=True) as image:
            low, high = image.header()["dataWindow"]
        width, height = (int(side) + 1 for side in np.subtract(high, low))
        check("camera.texels", width * height, f"{where}: {width:,} x {height:,} pixels")
        with library.File(str(file), separate_channels=True) as image:
            planes = {name: channel.pixels for name, channel in image.channels().items()}
    except UserError:
        raise
    except Exception as error:  # the library raises several kinds for damaged files
        raise UserError(f"{where}: {file.name} cannot be read ({' '.join(str(error).split())})") from None
    found = [planes[name] for name in "RGB" if name in planes]
    if not found:
        raise UserError(f"{where}: {file.name} has no channels R, G, B; it has {', '.join(planes)}")
    return np.stack(found, axis=2), hashlib.blake2b(file.read_bytes(), digest_size=16).hexdigest()
