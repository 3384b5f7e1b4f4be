"""CameraView: the lenses of Camera prims, by the names of Isaac Sim's Camera class."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.suggesting import Suggesting
from sensors.errors import SensorValueError

from .names import PRIM_TYPE

if TYPE_CHECKING:
    from pxr import Usd

SCALE = 10.0
"""Focal lengths and apertures are handed in and out in stage units; the attributes are in tenths of them."""

SIDES = {"horizontal": "verticalAperture", "vertical": "horizontalAperture"}
"""Mode of `CameraView.enforce_square_pixels` -> the side of the film that it changes."""

Numbers = float | Sequence[float] | Sequence[Sequence[float]] | np.ndarray | None
Words = str | Sequence[str]
Column = np.ndarray


class CameraView(Suggesting):
    """The lenses of n Camera prims; arrays have the shape (n, 1), float32.

    Focal lengths, apertures and their offsets are ten times as large on the prims as they are given here. Setters take
    a value for all prims or one for each, and raise AssertionError where all values are None, SensorValueError for
    values that do not fit. Raises AssertionError for a prim that is not a Camera.
    """

    def __init__(self, prims: Usd.Prim | Iterable[Usd.Prim]) -> None:
        self.prims: list[Usd.Prim] = list(prims) if isinstance(prims, Iterable) else [prims]
        for prim in self.prims:
            assert prim.GetTypeName() == PRIM_TYPE, f"{prim.GetPath()} is not a {PRIM_TYPE}"

    def __len__(self) -> int:
        return len(self.prims)

    @property
    def paths(self) -> list[str]:
        """Of the prims."""
        return [str(prim.GetPath()) for prim in self.prims]

    def set_focal_lengths(self, focal_lengths: Numbers) -> None:
        """Sets the focal lengths [stage units]."""
        self._set({"focalLength": focal_lengths}, SCALE)

    def get_focal_lengths(self) -> Column:
        """The focal lengths [stage units]."""
        return self._get("focalLength", SCALE)

    def set_apertures(self, horizontal_apertures: Numbers = None, vertical_apertures: Numbers = None) -> None:
        """Sets width and height of the films [stage units]."""
        self._set({"horizontalAperture": horizontal_apertures, "verticalAperture": vertical_apertures}, SCALE)

    def get_apertures(self) -> tuple[Column, Column]:
        """Width and height of the films [stage units]."""
        return self._get("horizontalAperture", SCALE), self._get("verticalAperture", SCALE)

    def set_aperture_offsets(self, horizontal_offsets: Numbers = None, vertical_offsets: Numbers = None) -> None:
        """Sets how far the films lie to the right and up [stage units]."""
        self._set({"horizontalApertureOffset": horizontal_offsets, "verticalApertureOffset": vertical_offsets}, SCALE)

    def get_aperture_offsets(self) -> tuple[Column, Column]:
        """How far the films lie to the right and up [stage units]."""
        return self._get("horizontalApertureOffset", SCALE), self._get("verticalApertureOffset", SCALE)

    def set_focus_distances(self, focus_distances: Numbers) -> None:
        """Sets the distances that are sharp [stage units]; images here are sharp everywhere."""
        self._set({"focusDistance": focus_distances})

    def get_focus_distances(self) -> Column:
        """The distances that are sharp [stage units]."""
        return self._get("focusDistance")

    def set_fstops(self, fstops: Numbers) -> None:
        """Sets the f-stops; images here are sharp everywhere."""
        self._set({"fStop": fstops})

    def get_fstops(self) -> Column:
        """The f-stops."""
        return self._get("fStop")

    def set_clipping_ranges(self, near_distances: Numbers = None, far_distances: Numbers = None) -> None:
        """Sets the nearest and the farthest distance that is shown [stage units]; None leaves one as it is."""
        from graph.sim.usd import Gf

        assert near_distances is not None or far_distances is not None, "give a near or a far distance"
        nearest, farthest = self.get_clipping_ranges()
        nearest = nearest if near_distances is None else self._column(near_distances)
        farthest = farthest if far_distances is None else self._column(far_distances)
        for prim, near, far in zip(self.prims, nearest, farthest, strict=True):
            prim.GetAttribute("clippingRange").Set(Gf.Vec2f(float(near[0]), float(far[0])))

    def get_clipping_ranges(self) -> tuple[Column, Column]:
        """The nearest and the farthest distance that is shown [stage units]."""
        both = np.array([prim.GetAttribute("clippingRange").Get() for prim in self.prims], np.float32).reshape(-1, 2)
        return both[:, :1], both[:, 1:]

    def set_shutter_times(self, open_times: Numbers = None, close_times: Numbers = None) -> None:
        """Sets when shutters open and close [time codes after the frame]; images here are of one instant."""
        self._set({"shutter:open": open_times, "shutter:close": close_times})

    def get_shutter_times(self) -> tuple[Column, Column]:
        """When shutters open and close [time codes after the frame]."""
        return self._get("shutter:open"), self._get("shutter:close")

    def set_projections(self, projections: Words) -> None:
        """Sets how each projects: perspective or orthographic."""
        self._choose("projection", projections)

    def get_projections(self) -> list[str]:
        """How each projects: perspective or orthographic."""
        return [str(prim.GetAttribute("projection").Get()) for prim in self.prims]

    def set_stereo_roles(self, roles: Words) -> None:
        """Sets what each is in a stereo pair: mono, left or right; it has no effect on images."""
        self._choose("stereoRole", roles)

    def get_stereo_roles(self) -> list[str]:
        """What each is in a stereo pair: mono, left or right."""
        return [str(prim.GetAttribute("stereoRole").Get()) for prim in self.prims]

    def enforce_square_pixels(self, resolutions: Any, modes: Words = "horizontal") -> None:
        """Makes pixels square for images of (height, width), one size for all or one for each.

        modes: "horizontal" keeps the widths of the films, "vertical" their heights. Raises SensorValueError for others.
        """
        sizes = np.broadcast_to(np.asarray(resolutions, np.float64), (len(self), 2))
        across, down = self.get_apertures()
        for row, (mode, (height, width)) in enumerate(zip(self._each(modes, SIDES, "mode"), sizes, strict=True)):
            horizontal, vertical = float(across[row, 0]), float(down[row, 0])
            wanted, present = horizontal * height / width, vertical
            if mode == "vertical":
                wanted, present = vertical * width / height, horizontal
            if abs(wanted - present) > 1e-5 * wanted:
                self.prims[row].GetAttribute(SIDES[mode]).Set(float(wanted) * SCALE)

    def _set(self, values: Mapping[str, Numbers], scale: float = 1.0) -> None:
        assert any(value is not None for value in values.values()), f"give {' or '.join(values)}"
        columns = {name: self._column(value) * scale for name, value in values.items() if value is not None}
        for name, column in columns.items():
            for prim, value in zip(self.prims, column[:, 0].tolist(), strict=True):
                prim.GetAttribute(name).Set(value)

    def _get(self, name: str, scale: float = 1.0) -> Column:
        return np.array([[prim.GetAttribute(name).Get() / scale] for prim in self.prims], np.float32).reshape(-1, 1)

    def _column(self, values: Numbers) -> np.ndarray:
        """(n, 1) float64 of one value, or of n."""
        try:
            found = np.asarray(values, np.float64).reshape(-1, 1)
        except (TypeError, ValueError):
            found = np.empty((0, 1))
        if len(found) not in (1, len(self)) or not np.isfinite(found).all():
            count = "one finite number" + (f", or {len(self)} of them" if len(self) > 1 else "")
            raise SensorValueError(f"{values!r} is not {count}")
        return np.broadcast_to(found, (len(self), 1))

    def _choose(self, name: str, values: Words) -> None:
        assert values is not None, f"give {name}"
        allowed = self.prims[0].GetAttribute(name).GetMetadata("allowedTokens") if self.prims else ()
        for prim, value in zip(self.prims, self._each(values, allowed, name), strict=True):
            prim.GetAttribute(name).Set(value)

    def _each(self, values: Words, allowed: Iterable[str], what: str) -> list[str]:
        """A word for each prim."""
        found, known = [values] if isinstance(values, str) else list(values), [str(each) for each in allowed]
        for value in found:
            if value not in known:
                raise SensorValueError(f"{what} {value!r} is not one of {', '.join(known)}")
        if len(found) not in (1, len(self)):
            raise SensorValueError(f"{values!r} is not one {what}, or {len(self)} of them")
        return found * len(self) if len(found) == 1 else found
