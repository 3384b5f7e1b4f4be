"""The actuators of a model: the meaning of joint commands for them, and their controls by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    from graph.sim.physics.world_model import Joint

    from .engine import MujocoEngine

_ON_JOINTS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
_FIXED = int(mujoco.mjtGain.mjGAIN_FIXED)
_PLAIN_BIASES = int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE)
_INTEGRATOR = int(mujoco.mjtDyn.mjDYN_INTEGRATOR)
_SIMPLE = (
    int(mujoco.mjtDyn.mjDYN_NONE),
    _INTEGRATOR,
    int(mujoco.mjtDyn.mjDYN_FILTER),
    int(mujoco.mjtDyn.mjDYN_FILTEREXACT),
)


class Motors:
    """A model's actuators on joints with one degree of freedom, which follow joint commands.

    An actuator of fixed gain g and affine bias (b0, b1, b2) gives the force g ctrl + b0 + b1 gear q + b2 gear dq. With
    a b1 or b2 it is a servo: its control becomes -(b0 + gear (b1 q* + b2 dq*)) / g, which gives zero force at the
    target (`position`, `velocity` and similar; if it integrates its control, only velocities are used). Otherwise it is
    a motor: an effort F becomes the control F / (g gear). Other actuators (muscles, adhesion, those of tendons and
    sites) ignore joint commands and have only their control.
    """

    def __init__(self, physics: MujocoEngine) -> None:
        model = self._model = physics.model
        own = {joint.path for joint in physics.drives.joints}
        self._dofs = {
            int(model.jnt_dofadr[model.joint(joint.model_name).id]): joint.path
            for joint in physics.joints
            if joint.kind in ("revolute", "prismatic")
        }
        self.servos: dict[str, list[int]] = {}
        self.motors: dict[str, int] = {}
        for number in range(model.nactuator):
            if model.actuator(number).name in own:
                continue
            path = self._joint(number)
            if path is None:
                continue
            if model.actuator_biasprm[number, 1:3].any() and model.actuator_biastype[number]:
                self.servos.setdefault(path, []).append(number)
            elif not model.actuator_biastype[number] and model.actuator_dyntype[number] != _INTEGRATOR:
                self.motors.setdefault(path, number)
        self._speeds: dict[int, float] = {}

    def _joint(self, number: int) -> str | None:
        """The path of the joint that an actuator moves."""
        model = self._model
        if (
            model.actuator_trntype[number] not in _ON_JOINTS
            or model.actuator_gaintype[number] != _FIXED
            or model.actuator_biastype[number] not in _PLAIN_BIASES
            or model.actuator_dyntype[number] not in _SIMPLE
            or not model.actuator_gainprm[number, 0]
            or not model.actuator_gear[number, 0]
        ):
            return None
        return self._dofs.get(int(model.jnt_dofadr[model.actuator_trnid[number, 0]]))

    def driven(self, joints: Sequence[Joint]) -> NDArray[np.bool_]:
        """(J,) which joints accept positions or velocities."""
        return np.array([joint.path in self.servos for joint in joints], dtype=np.bool_)

    def command(self, data: Any, path: str, position: float, velocity: float) -> None:
        """Sets the targets of the servos of a joint [rad or m, per s]; NaN keeps the present one."""
        model = self._model
        for number in self.servos.get(path, ()):
            gain, (b0, b1, b2) = model.actuator_gainprm[number, 0], model.actuator_biasprm[number, :3]
            gear, place = model.actuator_gear[number, 0], model.actuator_ctrladr[number]
            if model.actuator_dyntype[number] == _INTEGRATOR:
                if not np.isnan(velocity):
                    data.ctrl[place] = -gear * b1 * velocity / gain
                continue
            before = self._speeds.get(number, 0.0)
            speed = before if np.isnan(velocity) else velocity
            self._speeds[number] = speed
            if np.isnan(position):  # only the velocity term changes
                data.ctrl[place] -= gear * b2 * (speed - before) / gain
            else:
                data.ctrl[place] = -(b0 + gear * (b1 * position + b2 * speed)) / gain

    def push(self, data: Any, path: str, effort: float) -> bool:
        """Applies an effort [N m or N] with the motor of a joint, within its limits; False if the joint has no
        motor.
        """
        number = self.motors.get(path)
        if number is None:
            return False
        model = self._model
        data.ctrl[model.actuator_ctrladr[number]] = effort / (
            model.actuator_gainprm[number, 0] * model.actuator_gear[number, 0]
        )
        return True

    def take_over(self, old: Motors, number_there: int, number: int) -> None:
        """Takes over the velocity target of another model's servo."""
        if number_there in old._speeds:
            self._speeds[number] = old._speeds[number_there]

    def read(self, data: Any, name: str, what: str) -> Any:
        """An actuator's `ctrl`, `force`, `length` or `velocity`: a number, or several for an actuator with several."""
        number = self._model.actuator(name).id
        if what == "ctrl":
            first, count = int(self._model.actuator_ctrladr[number]), int(self._model.actuator_ctrlnum[number])
        else:
            first, count = int(self._model.actuator_outadr[number]), int(self._model.actuator_outnum[number])
        values: Floats = getattr(data, what if what == "ctrl" else f"actuator_{what}")[first : first + count]
        return float(values[0]) if count == 1 else values.copy()

    def write(self, data: Any, name: str, control: Any) -> None:
        """Sets an actuator's control. Raises ValueError unless the number of values fits and all are finite."""
        number = self._model.actuator(name).id
        first, count = int(self._model.actuator_ctrladr[number]), int(self._model.actuator_ctrlnum[number])
        values = np.atleast_1d(np.asarray(control, dtype=np.float64))
        if values.shape != (count,) or not np.isfinite(values).all():
            raise ValueError(f"actuator {name} takes {count} finite control{'s' if count > 1 else ''}, not {control!r}")
        data.ctrl[first : first + count] = values
        self._speeds.pop(number, None)
