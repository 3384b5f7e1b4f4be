"""RtxCamera: one Camera prim with the schema of sensors, created or wrapped; CameraView: its lens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from sensors.errors import SensorValueError
from sensors.prim import AUX_CHANNELS, has_sensor_api
from sensors.sensor_prim import SensorPrim, resolve

from .names import PRIM_TYPE

if TYPE_CHECKING:
    from pxr import Usd

SENSOR_API = "OmniSensorAPI"
SCALE = 10.0
"""Focal lengths and apertures are handed in and out in stage units; the attributes are in tenths of them."""

Numbers = float | Sequence[float] | np.ndarray | None


class RtxCamera(SensorPrim):
    """Wraps the Camera prim at a path, or creates a missing one with OmniSensorAPI and tick rate 0 (every update).

    path: a prim path, or a regular expression that matches one prim. tick_rate [Hz] writes omni:sensor:tickRate; None
    leaves it as the prim has it. schemas: API schemas to apply, such as OmniLensDistortionOpenCvPinholeAPI. attributes:
    name to value; they replace the arguments; an attribute that the prim does not have is skipped with a warning.
    positions (world) or translations (local), orientations w, x, y, z, scales: shape (n,) or (1, n), stage units. app:
    None is the App entered last. Raises SensorValueError (a UserError and a ValueError), also for a prim without
    OmniSensorAPI.
    """

    prim_type = PRIM_TYPE
    schema = SENSOR_API
    aux_levels = ("NONE",)
    word = "camera"

    def __init__(self, path: str, **options: Any) -> None:
        if "aux_output_level" in options:
            raise SensorValueError(f"{path}: a camera has no aux_output_level; leave it out")
        super().__init__(path, **options)
        self.prim.RemoveProperty(AUX_CHANNELS)

    @classmethod
    def write_config(cls, stage: Usd.Stage, path: str, config: str, variant: str | Mapping[str, str] | None) -> None:
        """Authors a shipped camera (SUPPORTED_CAMERA_CONFIGS) on the prim at a path; variant: the name of an imager."""
        from sensors.configs.cameras import author_camera

        path, existed = resolve(stage, path, cls.word)
        prim = stage.GetPrimAtPath(path) if existed else cls.define(stage, path)
        if prim.GetTypeName() != PRIM_TYPE:
            raise SensorValueError(f"{path} is a {prim.GetTypeName() or 'typeless prim'}, not a {PRIM_TYPE}")
        try:
            author_camera(prim, config, variant)
        except UserError as error:
            raise SensorValueError(error.problems) from error

    @property
    def camera(self) -> CameraView:
        """The lens of the prim."""
        return CameraView(self.prim)

    def _check_wrapped(self) -> None:
        super()._check_wrapped()
        if not has_sensor_api(self.prim):
            raise SensorValueError(f"{self.path} has no {SENSOR_API}; apply it, or give a path without a prim")


class CameraView:
    """The lens of one Camera prim, by the names of Isaac Sim's Camera class; arrays have one row.

    Focal lengths, apertures and their offsets are ten times as large on the prim as they are given here. Setters raise
    AssertionError where all values are None.
    """

    def __init__(self, prim: Usd.Prim) -> None:
        assert prim.GetTypeName() == PRIM_TYPE, f"{prim.GetPath()} is not a {PRIM_TYPE}"
        self._prim = prim

    @property
    def paths(self) -> list[str]:
        """The one path, as a list."""
        return [str(self._prim.GetPath())]

    def set_focal_lengths(self, focal_lengths: Numbers) -> None:
        """Sets the focal length [stage units]."""
        self._set({"focalLength": focal_lengths}, SCALE)

    def get_focal_lengths(self) -> np.ndarray:
        """(1, 1) float32 [stage units]."""
        return self._get("focalLength", SCALE)

    def set_apertures(self, horizontal_apertures: Numbers = None, vertical_apertures: Numbers = None) -> None:
        """Sets width and height of the film [stage units]."""
        self._set({"horizontalAperture": horizontal_apertures, "verticalAperture": vertical_apertures}, SCALE)

    def get_apertures(self) -> tuple[np.ndarray, np.ndarray]:
        """Width and height of the film, (1, 1) float32 each [stage units]."""
        return self._get("horizontalAperture", SCALE), self._get("verticalAperture", SCALE)

    def set_aperture_offsets(self, horizontal_offsets: Numbers = None, vertical_offsets: Numbers = None) -> None:
        """Sets how far the film lies to the right and up [stage units]."""
        self._set({"horizontalApertureOffset": horizontal_offsets, "verticalApertureOffset": vertical_offsets}, SCALE)

    def get_aperture_offsets(self) -> tuple[np.ndarray, np.ndarray]:
        """How far the film lies to the right and up, (1, 1) float32 each [stage units]."""
        return self._get("horizontalApertureOffset", SCALE), self._get("verticalApertureOffset", SCALE)

    def set_focus_distances(self, focus_distances: Numbers) -> None:
        """Sets the distance that is sharp [stage units]; images here are sharp everywhere."""
        self._set({"focusDistance": focus_distances})

    def get_focus_distances(self) -> np.ndarray:
        """(1, 1) float32 [stage units]."""
        return self._get("focusDistance")

    def set_fstops(self, fstops: Numbers) -> None:
        """Sets the f-stop; images here are sharp everywhere."""
        self._set({"fStop": fstops})

    def get_fstops(self) -> np.ndarray:
        """(1, 1) float32."""
        return self._get("fStop")

    def set_clipping_ranges(self, near_distances: Numbers = None, far_distances: Numbers = None) -> None:
        """Sets the nearest and the farthest distance that is shown [stage units]; None leaves one as it is."""
        from graph.sim.usd import Gf

        assert near_distances is not None or far_distances is not None, "give a near or a far distance"
        near, far = self._prim.GetAttribute("clippingRange").Get()
        near = near if near_distances is None else _one(near_distances)
        far = far if far_distances is None else _one(far_distances)
        self._prim.GetAttribute("clippingRange").Set(Gf.Vec2f(near, far))

    def get_clipping_ranges(self) -> tuple[np.ndarray, np.ndarray]:
        """The nearest and the farthest distance, (1, 1) float32 each [stage units]."""
        near, far = self._prim.GetAttribute("clippingRange").Get()
        return np.array([[near]], np.float32), np.array([[far]], np.float32)

    def enforce_square_pixels(self, resolutions: tuple[int, int], modes: str = "horizontal") -> None:
        """Makes pixels square for images of (height, width): "horizontal" keeps the width of the film.

        Raises SensorValueError for another mode than horizontal and vertical.
        """
        height, width = resolutions
        across, down = (float(each[0, 0]) for each in self.get_apertures())
        if modes == "horizontal":
            wanted, present = across * height / width, down
        elif modes == "vertical":
            wanted, present = down * width / height, across
        else:
            raise SensorValueError(f'mode {modes!r} is not "horizontal" or "vertical"')
        if abs(wanted - present) > 1e-5 * wanted:
            self.set_apertures(**{("vertical" if modes == "horizontal" else "horizontal") + "_apertures": wanted})

    def _set(self, values: dict[str, Numbers], scale: float = 1.0) -> None:
        assert any(value is not None for value in values.values()), f"give {' or '.join(values)}"
        for name, value in values.items():
            if value is not None:
                self._prim.GetAttribute(name).Set(_one(value) * scale)

    def _get(self, name: str, scale: float = 1.0) -> np.ndarray:
        return np.array([[self._prim.GetAttribute(name).Get() / scale]], np.float32)


def _one(value: Numbers) -> float:
    found = np.asarray(value, np.float64).reshape(-1)
    if found.shape != (1,) or not np.isfinite(found[0]):
        raise SensorValueError(f"{value!r} is not one finite number")
    return float(found[0])
