"""Physics of many worlds on a device, by mujoco-warp: MuJoCo's model of one App, its state once for each world."""

from __future__ import annotations

from copy import copy
from importlib import import_module
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.sim.devices import refuse_beyond, warp

from .library import mujoco

SPARE_CONTACTS, SPARE_ROWS = 4, 4
"""Contacts and constraint rows that a world may have, in those of the first state; see `LEAST`."""

LEAST = 64
"""Least number of contacts, and of constraint rows / 4, for which a world has room."""


class DevicePhysics:
    """The bodies of `worlds` worlds. engine: of one App that plays, whose state all worlds start from.

    contacts, rows: room in a world, None: by the first state. Steps are MuJoCo's own in float32; restitution, friction
    at bounces, and divided steps of `graph.sim.physics` act on the processor only. On a card, sums are in no fixed
    order, so the last bits differ from run to run. Raises UserError for a model that mujoco-warp does not simulate.
    """

    def __init__(
        self,
        engine: Any,
        worlds: int,
        device: Any,
        contacts: int | None = None,
        rows: int | None = None,
    ) -> None:
        wp = warp()
        try:
            self._mjw: Any = import_module("mujoco_warp")
        except ImportError as error:
            raise UserError("worlds need mujoco-warp; run: pip install --no-deps mujoco-warp") from error
        self._device, self.worlds = device, worlds
        model, data = copy(engine.model), engine.data
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # mujoco-warp never resets by itself
        mujoco.mj_forward(model, data)
        self.contacts = contacts or max(LEAST, SPARE_CONTACTS * int(data.ncon))
        self.rows = rows or max(4 * LEAST, SPARE_ROWS * int(data.nefc))
        self.bytes_a_world = 4 * (self.rows * (int(model.nv) + 12) + self.contacts * 60 + 40 * int(model.nv))
        """An estimate from below: the constraint rows, the contacts and the coordinates."""
        refuse_beyond(device, worlds * self.bytes_a_world, f"physics of {worlds:,} worlds")
        with wp.ScopedDevice(device):
            try:
                self.model = self._mjw.put_model(model)
            except NotImplementedError as error:
                raise UserError(f"mujoco-warp does not simulate this model: {error}") from error
            self.data = self._mjw.put_data(model, data, nworld=worlds, nconmax=self.contacts, njmax=self.rows)
            self._qpos, self._qvel = wp.clone(self.data.qpos), wp.clone(self.data.qvel)
            self._ctrl = wp.clone(self.data.ctrl)
            self._roots = wp.array(np.asarray(model.body_rootid), dtype=wp.int32, device=device)
        self.paths: tuple[str, ...] = engine.body_paths
        """The bodies, as of the engine."""
        self._drives = engine.drives
        self.joints: tuple[str, ...] = tuple(joint.path for joint in engine.drives.joints)
        """The joints with drives."""
        self._targets: list[Any] = []
        self._graph: Any = None
        self._steps = 0

    def step(self) -> None:
        """One step of all worlds; on a card the launches are recorded at the second step and then replayed."""
        wp = warp()
        with wp.ScopedDevice(self._device):
            if self._graph is not None:
                wp.capture_launch(self._graph)
            elif self._device.is_cuda and self._steps:
                with wp.ScopedCapture(device=self._device) as capture:
                    self._mjw.step(self.model, self.data)
                self._graph = capture.graph
                wp.capture_launch(self._graph)
            else:
                self._mjw.step(self.model, self.data)
        self._steps += 1

    @property
    def coordinates(self) -> Any:
        """Generalised coordinates, (w, nq) float32 on the device."""
        return self.data.qpos

    @property
    def speeds(self) -> Any:
        """Generalised velocities, (w, nv) float32 on the device."""
        return self.data.qvel

    def drive(self, positions: Any, velocities: Any) -> None:
        """Targets of the driven joints, (w, j) float32 on the device [rad or m, per s]; None keeps those of before."""
        from . import device_kernels

        wp, device = warp(), self._device
        if not self._targets:
            drives = self._drives
            start = np.tile(np.asarray(drives.targets, np.float32), (self.worlds, 1, 1))
            columns, gains = drives.controls
            shares = drives.stiffness / gains, drives.damping / gains
            self._targets = [wp.array(np.ascontiguousarray(start[..., axis]), device=device) for axis in (0, 1)]
            self._shares = [wp.array(np.asarray(each, np.float32), device=device) for each in shares]
            self._columns = wp.array(np.asarray(columns, np.int32), device=device)
        for axis, values in enumerate((positions, velocities)):
            if values is not None:
                self._targets[axis] = values
        wp.launch(
            device_kernels.drive,
            dim=(self.worlds, len(self.joints)),
            inputs=[*self._targets, *self._shares, self._columns],
            outputs=[self.data.ctrl],
            device=device,
        )

    def carry(self, anchor: np.ndarray, bodies: Any, linear: Any, angular: Any) -> None:
        """Writes where the bodies are about an anchor (3,) [m], (w, b), and their velocities [m/s, rad/s]."""
        from . import device_kernels

        self._refresh()
        data = self.data
        warp().launch(
            device_kernels.carry,
            dim=bodies.shape,
            inputs=[data.xpos, data.xquat, data.cvel, data.subtree_com, self._roots, warp().vec3d(*anchor)],
            outputs=[bodies, linear, angular],
            device=self._device,
        )

    def _refresh(self) -> None:
        """Brings poses and velocities of bodies to the present state: a step leaves those that it began with."""
        with warp().ScopedDevice(self._device):
            self._mjw.kinematics(self.model, self.data)
            self._mjw.com_pos(self.model, self.data)
            self._mjw.com_vel(self.model, self.data)

    def overflow(self) -> str:
        """What there was no room for in the last step; "" if all had room. Waits for the device."""
        found = []
        if int(self.data.nacon.numpy()[0]) > self.worlds * self.contacts:
            found.append(f"contacts ({self.contacts} a world)")
        if int(self.data.nefc.numpy().max()) > self.rows:
            found.append(f"constraint rows ({self.rows} a world)")
        return " and ".join(found)

    def reset(self, mask: Any) -> None:
        """Puts worlds back to their first state; mask: (w,) bool on the device."""
        from . import device_kernels

        wp = warp()
        with wp.ScopedDevice(self._device):
            self._mjw.reset_data(self.model, self.data, mask)
            for now, first in (
                (self.data.qpos, self._qpos),
                (self.data.qvel, self._qvel),
                (self.data.ctrl, self._ctrl),
            ):
                wp.launch(device_kernels.restore, dim=now.shape, inputs=[mask, first, now], device=self._device)
        self._refresh()
