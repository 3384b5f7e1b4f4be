"""Transfers the state of a world, by path, from one model to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.transforms import Floats

from .deformables import Deformables
from .library import mujoco
from .memory import forward
from .snapshot import body_velocities

if TYPE_CHECKING:
    from .engine import MujocoEngine

_BALL, _FREE = int(mujoco.mjtJoint.mjJNT_BALL), int(mujoco.mjtJoint.mjJNT_FREE)
_WIDTHS = {_FREE: (7, 6), _BALL: (4, 3)}


class Leaving:
    """The state of an engine before it adopts another model."""

    def __init__(self, physics: MujocoEngine) -> None:
        self._model, self._data = physics.model, physics.data
        self._numbers = {path: number for number, path in enumerate(physics.body_paths, start=1)}
        warm = physics.data.qacc_warmstart.copy()
        self._velocities = body_velocities(physics.model, physics.data, len(physics.body_paths))
        self._data.qacc_warmstart[:] = warm
        drives = physics.drives
        self._targets = {joint.path: target.copy() for joint, target in zip(drives.joints, drives.targets, strict=True)}
        self._grippers = {path: (gripper, gripper.weld_data) for path, gripper in physics._grippers.items()}
        self._surfaces, self._motors = physics._surfaces, physics.motors
        self._deformables, self._forces = physics.deformables, physics.forces.own
        self._others = _others(physics)

    def arrive(self, physics: MujocoEngine, kept: frozenset[str]) -> None:
        """Sets the state of everything that still exists; `kept`: bodies with unchanged rest poses."""
        model, data = physics.model, physics.data
        numbers = {0: 0}
        for path, number in physics._index.items():
            if path in self._numbers:
                numbers[self._numbers[path]] = number + 1
                physics.forces.own[number + 1] = self._forces[self._numbers[path]]
                self._body(model, data, self._numbers[path], number + 1, path in kept)
        for name, hidden in _others(physics).items():
            if name in self._others:
                self._body(model, data, self._others[name], hidden, True)
        data.time = self._data.time
        if isinstance(physics.deformables, Deformables) and isinstance(self._deformables, Deformables):
            physics.deformables.take_over(self._deformables, self._data, data)
        self._controls(physics)
        if self._surfaces is not None:
            physics.surfaces.take_over(self._surfaces, numbers)
        for path, (gripper, welds) in self._grippers.items():
            if path in physics._grippers and physics._grippers[path].spec.points == gripper.spec.points:
                physics._grippers[path].take_over(gripper, welds)
        physics.forces.step(data)
        warm = data.qacc_warmstart.copy()
        forward(model, data)
        data.qacc_warmstart[:] = warm

    def _body(self, model: Any, data: Any, old: int, new: int, kept: bool) -> None:
        from_mocap, to_mocap = self._model.body_mocapid[old], model.body_mocapid[new]
        if from_mocap >= 0 and to_mocap >= 0:
            data.mocap_pos[to_mocap] = self._data.mocap_pos[from_mocap]
            data.mocap_quat[to_mocap] = self._data.mocap_quat[from_mocap]
        before, after = _joints(self._model, old), _joints(model, new)
        if [kind for kind, *_ in before] != [kind for kind, *_ in after]:
            if after and after[0][0] == _FREE:
                self._set_free(data, after[0][2], old, new)
            return
        for (kind, q0, v0), (_, q1, v1) in zip(before, after, strict=True):
            positions, speeds = _WIDTHS.get(kind, (1, 1))
            if kind != _BALL or kept:  # a ball's position is measured from its rest pose
                data.qpos[q1 : q1 + positions] = self._data.qpos[q0 : q0 + positions]
            for name in ("qvel", "qacc_warmstart", "qfrc_applied"):
                getattr(data, name)[v1 : v1 + speeds] = getattr(self._data, name)[v0 : v0 + speeds]

    def _set_free(self, data: Any, address: int, old: int, new: int) -> None:
        """A body that a joint held continues with its velocity."""
        motion: Floats = self._velocities[old - 1]
        turn = np.asarray(self._data.xmat[old]).reshape(3, 3)
        data.qvel[address : address + 3] = motion[:3]
        data.qvel[address + 3 : address + 6] = turn.T @ motion[3:]

    def _controls(self, physics: MujocoEngine) -> None:
        """Drives by their joints; actuators and ties with other names by their names."""
        model, data, drives = physics.model, physics.data, physics.drives
        own = {joint.path for joint in drives.joints}
        for number, joint in enumerate(drives.joints):
            if joint.path in self._targets:
                drives.targets[number] = self._targets[joint.path]
        drives.apply(data)
        there = {self._model.actuator(number).name: number for number in range(self._model.nactuator)}
        for number in range(model.nactuator):
            name = model.actuator(number).name
            if name and name not in own and name in there:
                self._range(data, "ctrl", "actuator_ctrl", model, there[name], number)
                self._range(data, "act", "actuator_act", model, there[name], number)
                if physics.motors is not None and self._motors is not None:
                    physics.motors.take_over(self._motors, there[name], number)
        ties = {self._model.equality(number).name: number for number in range(self._model.neq)}
        for number in range(model.neq):
            name = model.equality(number).name
            if name and name in ties and not name.endswith("#grip"):
                data.eq_active[number] = self._data.eq_active[ties[name]]

    def _range(self, data: Any, name: str, prefix: str, model: Any, old: int, new: int) -> None:
        """The indices of an actuator in one of the engine's arrays."""
        first, count = (int(getattr(self._model, prefix + end)[old]) for end in ("adr", "num"))
        to, room = (int(getattr(model, prefix + end)[new]) for end in ("adr", "num"))
        if count and count == room:
            getattr(data, name)[to : to + count] = getattr(self._data, name)[first : first + count]


def _others(physics: MujocoEngine) -> dict[str, int]:
    """The model's bodies that are not rigid bodies of the scene, such as the vertices of cloth, by their names."""
    model = physics.model
    found = ((model.body(number).name, number) for number in range(1 + len(physics.body_paths), model.nbody))
    return {name: number for name, number in found if name}


def _joints(model: Any, body: int) -> list[tuple[int, int, int]]:
    """(kind, address of its position, of its velocity) of each joint of a body."""
    first = int(model.body_jntadr[body])
    numbers = range(first, first + int(model.body_jntnum[body])) if first >= 0 else ()
    return [(int(model.jnt_type[n]), int(model.jnt_qposadr[n]), int(model.jnt_dofadr[n])) for n in numbers]
