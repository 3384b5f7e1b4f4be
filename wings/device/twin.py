"""The physics of one world a second time, in float32 on a device as in `Worlds`, beside MuJoCo's own steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.devices import warp
from graph.sim.physics.mujoco.library import mujoco
from graph.sim.transforms import Floats

from .physics import DevicePhysics
from .physics_start import left_out

CONTACTS = 512
"""Room for contacts; constraint rows have four times as many."""

_ONE_COORDINATE = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)


class DeviceTwin:
    """Starts where an engine is, and makes each of its steps on a device with the same controls and forces.

    Call `begin` before and `step` after each step of the engine. Kinematic bodies are put where the engine has them.
    Raises UserError for a model that mujoco-warp does not simulate.
    """

    def __init__(self, engine: Any, device: Any) -> None:
        self._engine = engine
        self._physics = DevicePhysics(engine, 1, device, CONTACTS, 4 * CONTACTS)
        wp, count = warp(), len(engine.body_paths)
        self._poses = wp.zeros((1, count), dtype=wp.mat44d, device=device)
        self._speeds = [wp.zeros((1, count), dtype=wp.vec3d, device=device) for _ in range(2)]
        model = engine.model
        self._joints = model.jnt_qposadr[np.isin(model.jnt_type, _ONE_COORDINATE)]
        self._left: list[Any] | None = None
        self.without = tuple(left_out(engine))
        """What the engine does beside MuJoCo's own steps in this world, and the device does not."""
        self.stopped = ""
        """Why it no longer follows the engine; "": it does."""

    def begin(self) -> None:
        """Notes whether the engine's state or settings were changed since its last step: then the twin stops."""
        if self._left is not None and not self.stopped:
            now = self._state()
            if not all(map(np.array_equal, self._left, now)):
                self.stopped = "the state, masses, gains or time step of its bodies are set while it runs"

    def step(self) -> None:
        """One step, with the controls and forces of the engine's."""
        self._left = [np.copy(each) for each in self._state()]
        if self.stopped:
            return
        engine, here = self._engine.data, self._physics.data
        drives, controls = self._engine.drives, np.copy(engine.ctrl)
        controls[drives.controls[0]] = drives.nominal_controls
        given = {"ctrl": controls, **{name: getattr(engine, name) for name in _GIVEN}}
        for name, values in given.items():
            array = getattr(here, name)
            if array.size:
                array.assign(np.asarray(values, np.float32)[None])
        self._physics.step()
        if full := self._physics.overflow():
            self.stopped = f"mujoco-warp has no room for its {full}"

    def bodies(self) -> Floats:
        """Poses (b, 4, 4) of the bodies in the world [m]."""
        self._physics.carry(np.zeros(3), self._poses, *self._speeds)
        poses: Floats = np.array(self._poses.numpy()[0])  # on the processor that is the memory itself
        return poses

    def joints(self) -> tuple[Floats, Floats]:
        """Positions of the hinges and slides on the device and of the engine, (j,) [rad or m]."""
        there = self._physics.coordinates.numpy()[0].astype(np.float64)
        return there[self._joints], np.array(self._engine.data.qpos[self._joints])

    def _state(self) -> list[Any]:
        engine = self._engine
        model, options, drives = engine.model, engine.model.opt, engine.drives
        return [
            *(engine.data.qpos, engine.data.qvel, options.timestep, options.gravity),
            *(model.body_mass, model.body_inertia),
            *(drives.stiffness, drives.damping),
        ]


_GIVEN = ("qfrc_applied", "xfrc_applied", "mocap_pos", "mocap_quat")
"""What users set in the engine's data, beside controls."""
