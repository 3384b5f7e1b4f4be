"""What a Camera prim describes: its lens for an image of a size, and what it shows of depth."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.limits import check
from graph.base.records import dataclass

from .image_files import ImageFiles
from .lens import Lens, ParallelLens
from .lens_models import distorting_lens
from .noise import ImageNoise, read_noise
from .shutter import RollingShutter, read_shutter

if TYPE_CHECKING:
    from pxr import Usd

TIME, F_STOP = 0.02, 5.0
"""Exposure time [s] and stop of a camera that authors none: those that RTX works with, not those of the schema."""

NO_ATTRIBUTES = ImageNoise()

PIXEL_ASPECT = "mjc:pixelAspect"
"""Attribute of a camera of an MJCF model: its horizontal focal length over its vertical one, both in pixels."""
TENTH = 0.1
"""Focal length and apertures are in tenths of a stage unit."""


@dataclass(frozen=True)
class CameraConfig:
    """A camera at one image size.

    lens: at that size. near, far: distances from the image plane [m] that it shows. The other numbers are those of the
    prim, in its units: focal length, apertures (width, height) and their offsets in tenths of a stage unit,
    focus_distance in stage units. film: width and height that the image shows, in the same unit (see `film_of`).
    exposure: what linear light is multiplied with. shutter: None exposes all at once. noise: what `camera.noise` makes
    of colours.
    """

    lens: Lens
    near: float
    far: float
    focal_length: float
    apertures: tuple[float, float]
    film: tuple[float, float]
    offsets: tuple[float, float]
    focus_distance: float
    f_stop: float
    clipping: tuple[float, float]
    exposure: float = 1.0
    shutter: RollingShutter | None = None
    noise: ImageNoise = NO_ATTRIBUTES

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image [px]."""
        return self.lens.width, self.lens.height


def legacy_lens(prim: Usd.Prim) -> list[str]:
    """The attributes of a prim that described its lens up to Isaac Sim 4, where they say anything but a pinhole."""
    return [
        name
        for name in ("cameraProjectionType", "physicalDistortionModel")
        if str(prim.GetAttribute(name).Get() or "pinhole") != "pinhole"
    ]


def read_config(
    prim: Usd.Prim,
    size: tuple[int, int],
    meters_per_unit: float,
    folders: Iterable[Path] | None = None,
    *,
    tables: bool = True,
) -> CameraConfig:
    """The camera that a prim describes, for images of width x height.

    Pixels are square, so that the aperture's height follows from its width and the image; a lens schema of OpenCV has
    focal lengths of its own. folders: from which its files may be read; None: from any. Without `tables` those of its
    lens are named and not read, and the lens is a pinhole. Raises UserError, naming prim and attribute, for what no
    camera has.
    """
    try:
        return _read(prim, size, meters_per_unit, ImageFiles(folders) if tables else None)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(
            f"{prim.GetPath()}: an attribute has a value that its schema does not allow ({error})"
        ) from error


def film_of(prim: Usd.Prim, size: tuple[int, int]) -> tuple[float, float]:
    """Width and height of the film in an image of that size, in tenths of a stage unit.

    The height follows from the width, so that pixels are square. A camera of an MJCF model keeps its height, because
    its angle of view is the vertical one; its width follows from the model's ratio of focal lengths in pixels.
    """
    wide, tall = (float(prim.GetAttribute(f"{side}Aperture").Get() or 0.0) for side in ("horizontal", "vertical"))
    width, height = size
    ratio = prim.GetAttribute(PIXEL_ASPECT).Get() if prim.HasAttribute(PIXEL_ASPECT) else None
    return (wide, wide * height / width) if ratio is None else (tall * width / (height * ratio), tall)


def _read(prim: Usd.Prim, size: tuple[int, int], meters_per_unit: float, files: ImageFiles | None) -> CameraConfig:
    attributes = _Attributes(prim)
    focal, apertures = attributes.positive("focalLength"), _pair(attributes, "Aperture", positive=True)
    film, offsets = film_of(prim, size), _pair(attributes, "ApertureOffset")
    near, far = attributes.pair("clippingRange")
    if not 0 <= near < far:
        raise attributes.wrong("clippingRange", (near, far), "give the nearest and the farthest distance, 0 or more")
    return CameraConfig(
        _lens(attributes, size, (focal, film, offsets), meters_per_unit, files),
        near * meters_per_unit,
        far * meters_per_unit,
        focal,
        apertures,
        film,
        offsets,
        attributes.number("focusDistance"),
        attributes.number("fStop"),
        (near, far),
        _exposure(attributes),
        read_shutter(prim),
        read_noise(prim),
    )


def _lens(
    attributes: _Attributes,
    size: tuple[int, int],
    film: tuple[float, tuple[float, float], tuple[float, float]],
    unit: float,
    files: ImageFiles | None,
) -> Lens:
    width, height = size
    focal, (wide, tall), (right, up) = film
    across, down = width / wide, height / tall  # pixels in a tenth of a unit
    centre = width / 2 - right * across, height / 2 + up * down
    if attributes.text("projection") == "orthographic":
        metre = TENTH * unit
        return ParallelLens(width, height, across / metre, down / metre, *centre)
    found = distorting_lens(attributes.prim, size, files)
    if found is not None:
        return found
    return Lens(width, height, focal * across, focal * down, *centre)


def _pair(attributes: _Attributes, name: str, *, positive: bool = False) -> tuple[float, float]:
    read = attributes.positive if positive else attributes.number
    return read(f"horizontal{name}"), read(f"vertical{name}")


def _exposure(attributes: _Attributes) -> float:
    """2^exposure responsivity time (iso / 100) / fStop^2 of the exposure attributes; see `sensors/README.md`."""
    least, authored = attributes.not_negative, attributes.authored
    scale = least("exposure:responsivity", 1.0) * authored("exposure:time", TIME) * least("exposure:iso", 100.0) / 100
    with np.errstate(over="ignore"):
        found = np.exp2(attributes.number("exposure")) * scale / (authored("exposure:fStop", F_STOP) or 1.0) ** 2
    return float(np.clip(np.nan_to_num(found), 0.0, 1e20))


class _Attributes:
    """The attributes of a Camera, told as one line where they cannot be."""

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = prim

    def wrong(self, name: str, value: Any, advice: str) -> UserError:
        return UserError(f"{self.prim.GetPath()}.{name} is {value}; {advice}")

    def text(self, name: str) -> str:
        attribute = self.prim.GetAttribute(name)
        return str(attribute.Get() or "") if attribute else ""

    def number(self, name: str, default: float = 0.0) -> float:
        attribute = self.prim.GetAttribute(name)
        value = attribute.Get() if attribute else None
        found = default if value is None else float(value)
        if not math.isfinite(found):
            raise self.wrong(name, found, "give a finite number")
        return found

    def not_negative(self, name: str, default: float) -> float:
        found = self.number(name, default)
        if found < 0:
            raise self.wrong(name, found, "give 0 or more")
        return found

    def authored(self, name: str, default: float) -> float:
        """Of what is authored, else the default: 0 or more."""
        attribute = self.prim.GetAttribute(name)
        return self.not_negative(name, default) if attribute and attribute.HasAuthoredValue() else default

    def positive(self, name: str) -> float:
        found = self.number(name)
        if found <= 0:
            raise self.wrong(name, found, "give a number above 0")
        return found

    def pair(self, name: str) -> tuple[float, float]:
        value = self.prim.GetAttribute(name).Get()
        first, second = map(float, value) if value is not None else (0.0, 0.0)
        return first, second


def checked_size(path: str, size: tuple[int, int]) -> tuple[int, int]:
    """Width and height of an image. Raises UserError without pixels, OverLimit for too many."""
    width, height = size
    if min(size) < 1:
        raise UserError(f"{path}: an image of {width} x {height} has no pixels; give the render product a size")
    check("camera.rays", width * height, f"{path}: an image of {width:,} x {height:,} has {width * height:,} pixels")
    return size
