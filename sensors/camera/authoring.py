"""RtxCamera: one Camera prim with the schema of sensors, created or wrapped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from sensors.errors import SensorValueError
from sensors.prim import AUX_CHANNELS, has_sensor_api
from sensors.sensor_prim import SensorPrim, resolve

from .camera_view import CameraView
from .names import AUX_LEVELS, PRIM_TYPE

if TYPE_CHECKING:
    from pxr import Usd

SENSOR_API = "OmniSensorAPI"


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
    aux_levels = AUX_LEVELS
    word = "camera"

    def __init__(self, path: str | Sequence[str], **options: Any) -> None:
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
