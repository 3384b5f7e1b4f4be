"""The lens schemas of Omniverse on Camera prims."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError

from .image_files import ImageFiles
from .lens import BrownLens, FisheyeLens, FthetaLens, Lens, PrismFisheyeLens
from .names import LENS, LENS_MODEL

if TYPE_CHECKING:
    from pxr import Usd

OPENCV: dict[str, Any] = {"imageSize": (2048, 1024), "cx": 1024.0, "cy": 512.0, "fx": 900.0, "fy": 800.0}
BROWN = {**OPENCV, **dict.fromkeys((*(f"k{n}" for n in range(1, 7)), "p1", "p2", *(f"s{n}" for n in range(1, 5))), 0.0)}
FISHEYE = {**OPENCV, "k1": 0.00245, "k2": 0.0, "k3": 0.0, "k4": 0.0}
NOMINAL: dict[str, Any] = {
    "nominalWidth": 1936.0,
    "nominalHeight": 1216.0,
    "opticalCenter": (970.9424, 600.3748),
    "maxFov": 200.0,
}
FTHETA = {**NOMINAL, "k0": 0.0, "k1": 0.00245, "k2": 0.0, "k3": 0.0, "k4": 0.0}
KANNALA = {**NOMINAL, "k0": 0.0, "k1": 0.00245, "k2": 0.0, "k3": 0.0}
PRISM = {
    **NOMINAL,
    **dict.fromkeys((f"k{n}" for n in range(6)), 0.0),
    **{"p0": -0.00037, "p1": -0.00074, "s0": -0.00058, "s1": -0.00022, "s2": 0.00019, "s3": -0.0002},
}
MODELS: dict[str, dict[str, Any]] = {
    "opencvPinhole": BROWN,
    "opencvFisheye": FISHEYE,
    "ftheta": FTHETA,
    "kannalaBrandtK3": KANNALA,
    "radTanThinPrism": PRISM,
}
"""Token of omni:lensdistortion:model -> its attributes with their defaults."""


def lens_model(prim: Usd.Prim) -> str:
    """The token of the prim's lens model; "" for a plain pinhole."""
    attribute = prim.GetAttribute(LENS_MODEL)
    return str(attribute.Get() or "") if attribute else ""


def lens_values(prim: Usd.Prim, model: str) -> dict[str, Any]:
    """The attributes of a prim's lens model, with defaults where nothing is authored."""
    found = {}
    for name, default in MODELS[model].items():
        attribute = prim.GetAttribute(f"{LENS}{model}:{name}")
        value = attribute.Get() if attribute else None
        value = default if value is None else value
        found[name] = tuple(map(float, value)) if isinstance(default, tuple) else float(value)
    return found


def distorting_lens(prim: Usd.Prim, size: tuple[int, int], files: ImageFiles | None) -> Lens | None:
    """The lens of a prim's lens schema, scaled to an image of width x height; None for a prim without one.

    files: reads its tables; without it a lens of tables is only checked, and None.

    Raises UserError for models that are not known here, and for numbers that no lens has.
    """
    model = lens_model(prim)
    if model in ("", "pinhole"):
        return None
    if model == "lut":
        from .lut_lens import check_tables, read_lut_lens

        check_tables(prim, None if files is None else size)
        return None if files is None else read_lut_lens(prim, size, files)
    if model not in MODELS:
        raise UserError(f"{prim.GetPath()}.{LENS_MODEL} is {model!r}; there are {', '.join(MODELS)}, lut")
    values = lens_values(prim, model)
    if not all(np.isfinite(part) for value in values.values() for part in np.atleast_1d(value)):
        raise UserError(f"{prim.GetPath()}: an attribute of {LENS}{model} is not finite; give a finite number")
    if model in ("opencvPinhole", "opencvFisheye"):
        return _opencv(prim, model, values, size)
    across, down = size[0] / _size(prim, model, values, "nominalWidth"), _down(prim, model, values, size)
    centre = values["opticalCenter"][0] * across, values["opticalCenter"][1] * down
    most = float(np.deg2rad(values["maxFov"]) / 2)
    if model == "ftheta":
        coefficients = tuple(values[f"k{number}"] for number in range(5))
        return FthetaLens(*size, across, down, *centre, coefficients, most)
    if model == "radTanThinPrism":
        return _prism(prim, model, values, (*size, across, down, *centre), most)
    return FisheyeLens(*size, across, down, *centre, tuple(values[f"k{number}"] for number in range(4)), most)


def _prism(
    prim: Usd.Prim, model: str, values: dict[str, Any], film: tuple[int, int, float, float, float, float], most: float
) -> Lens:
    """A fisheye whose radius [px] is k0 a + k1 a^3 + ... of the angle a, as of kannalaBrandtK3.

    Tangential and prism terms act in units of k0, which is so the focal length: nothing published says their units.
    """
    focal, (width, height, across, down, right, low) = _size(prim, model, values, "k0"), film
    radial = tuple(values[f"k{number}"] / focal for number in range(6))
    p, s = (tuple(values[f"{letter}{n}"] for n in range(count)) for letter, count in (("p", 2), ("s", 4)))
    return PrismFisheyeLens(width, height, across * focal, down * focal, right, low, radial, most, p, s)


def _opencv(prim: Usd.Prim, model: str, values: dict[str, Any], size: tuple[int, int]) -> Lens:
    for name in ("fx", "fy"):
        _size(prim, model, values, name)
    if not min(values["imageSize"]) > 0:
        raise UserError(f"{prim.GetPath()}.{LENS}{model}:imageSize is {values['imageSize']}; give numbers above 0")
    return opencv_lens(model, values, size)


def opencv_lens(model: str, values: Mapping[str, Any], size: tuple[int, int]) -> Lens:
    """A lens of OpenCV's numbers for `imageSize`, scaled to an image of width x height.

    model: "opencvPinhole" or "opencvFisheye"; coefficients that `values` leaves out are 0.
    """
    across, down = size[0] / values["imageSize"][0], size[1] / values["imageSize"][1]
    camera = values["fx"] * across, values["fy"] * down, values["cx"] * across, values["cy"] * down
    if model == "opencvFisheye":
        return FisheyeLens(*size, *camera, (1.0, *(values.get(f"k{n}", 0.0) for n in range(1, 5))))
    k, p, s = (
        tuple(values.get(f"{letter}{n}", 0.0) for n in range(1, count + 1))
        for letter, count in (("k", 6), ("p", 2), ("s", 4))
    )
    return BrownLens(*size, *camera, k, p, s) if any((*k, *p, *s)) else Lens(*size, *camera)


def _down(prim: Usd.Prim, model: str, values: dict[str, Any], size: tuple[int, int]) -> float:
    return size[1] / _size(prim, model, values, "nominalHeight")


def _size(prim: Usd.Prim, model: str, values: dict[str, Any], name: str) -> float:
    found = float(values[name])
    if found <= 0:
        raise UserError(f"{prim.GetPath()}.{LENS}{model}:{name} is {found:g}; give a number above 0")
    return found
