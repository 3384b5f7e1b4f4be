"""Physics of many worlds on a device, by mujoco-warp: MuJoCo's model of one App, its state once for each world."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from importlib import import_module
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.sim.devices import warp
from graph.sim.physics.mujoco.library import mujoco

from .devices import allocating, refuse_beyond
from .physics_start import STATE

SPARE_CONTACTS, SPARE_ROWS = 4, 4
"""Contacts and constraint rows that a world may have, in those of the first state; see `LEAST`."""

LEAST = 64
"""Least number of contacts, and of constraint rows / 4, for which a world has room."""


class DevicePhysics:
    """The bodies of `worlds` worlds. engine: of one App that plays, whose state all worlds start from.

    contacts, rows: room in a world, None: by the first state. differences: of worlds that begin otherwise, see
    `physics_start.difference`. Steps are MuJoCo's own in float32; restitution, friction at bounces, and divided steps
    of `graph.sim.physics` act on the processor only. On a card, sums are in no fixed order, so the last bits differ
    from run to run. Raises UserError for a model that mujoco-warp does not simulate.
    """

    def __init__(
        self,
        engine: Any,
        worlds: int,
        device: Any,
        contacts: int | None = None,
        rows: int | None = None,
        differences: Mapping[int, Mapping[str, np.ndarray]] | None = None,
    ) -> None:
        wp = warp()
        try:
            self._mjw: Any = import_module("mujoco_warp")
        except ImportError as error:
            raise UserError("worlds need mujoco-warp; run: pip install --no-deps mujoco-warp") from error
        self._device, self.worlds = device, worlds
        model, data = copy(engine.model), copy(engine.data)  # the engine goes on as if it had not been looked at
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # mujoco-warp never resets by itself
        mujoco.mj_forward(model, data)
        self.contacts = contacts or max(LEAST, SPARE_CONTACTS * int(data.ncon))
        self.rows = rows or max(4 * LEAST, SPARE_ROWS * int(data.nefc))
        self.bytes_a_world = 4 * (self.rows * (int(model.nv) + 12) + self.contacts * 60 + 40 * int(model.nv))
        """An estimate from below: the constraint rows, the contacts and the coordinates."""
        refuse_beyond(device, worlds * self.bytes_a_world, f"physics of {worlds:,} worlds")
        with wp.ScopedDevice(device), allocating(device, f"physics of {worlds:,} worlds"):
            try:
                self.model = self._mjw.put_model(model)
            except NotImplementedError as error:
                raise UserError(f"mujoco-warp does not simulate this model: {error}") from error
            self.data = self._mjw.put_data(model, data, nworld=worlds, nconmax=self.contacts, njmax=self.rows)
            self._first = {name: wp.clone(getattr(self.data, name)) for name in STATE if getattr(self.data, name).size}
            self._roots = wp.array(np.asarray(model.body_rootid), dtype=wp.int32, device=device)
        self.paths: tuple[str, ...] = engine.body_paths
        """The bodies, as of the engine."""
        drives = engine.drives
        self._gains = {"stiffness": drives.stiffness, "damping": drives.damping, "gains": drives.controls[1]}
        self._gains = {name: np.asarray(each)[None] for name, each in self._gains.items()}
        self._columns = wp.array(np.asarray(drives.controls[0], np.int32), device=device)
        self._start = np.asarray(drives.targets)[None]
        self._differing(differences or {})
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
        from . import physics_kernels

        wp, device = warp(), self._device
        if not self._targets:
            start = np.broadcast_to(self._start, (self.worlds, *self._start.shape[1:])).astype(np.float32)
            shares = (self._gains[name] / self._gains["gains"] for name in ("stiffness", "damping"))
            self._targets = [wp.array(np.ascontiguousarray(start[..., axis]), device=device) for axis in (0, 1)]
            self._shares = [wp.array(np.asarray(each, np.float32), device=device) for each in shares]
        for axis, values in enumerate((positions, velocities)):
            if values is not None:
                self._targets[axis] = values
        wp.launch(
            physics_kernels.drive,
            dim=(self.worlds, len(self.joints)),
            inputs=[*self._targets, *self._shares, self._columns],
            outputs=[self.data.ctrl],
            device=device,
        )

    def _differing(self, differences: Mapping[int, Mapping[str, np.ndarray]]) -> None:
        """Gives worlds what they have otherwise than the engine; see `physics_start.difference`."""
        wp = warp()
        for name in sorted({name for each in differences.values() for name in each}):
            rows = {world: each[name] for world, each in differences.items() if name in each}
            part, _, key = name.rpartition(".")
            if part == "drives":
                known = self._start if key == "targets" else self._gains[key]
                found = np.repeat(known, self.worlds, axis=0)
                found[list(rows)] = np.stack([*rows.values()])
                if key == "targets":
                    self._start = found
                else:
                    self._gains[key] = found
                continue
            owner = {"": self.model, "opt": self.model.opt, "data": self.data}[part]
            old = getattr(owner, key)
            here = old.numpy()
            found = np.array(np.broadcast_to(here, (self.worlds, *here.shape[1:])))
            for world, value in rows.items():
                found[world] = np.reshape(value, here.shape[1:])
            new = wp.array(found, dtype=old.dtype, shape=(self.worlds, *old.shape[1:]), device=self._device)
            setattr(owner, key, new)
            if part == "data":
                self._first[key] = wp.clone(new)

    def carry(self, anchor: np.ndarray, bodies: Any, linear: Any, angular: Any) -> None:
        """Writes where the bodies are about an anchor (3,) [m], (w, b), and their velocities [m/s, rad/s]."""
        from . import physics_kernels

        self._refresh()
        data = self.data
        warp().launch(
            physics_kernels.carry,
            dim=(self.worlds, len(self.paths)),
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
        from . import physics_kernels

        wp = warp()
        with wp.ScopedDevice(self._device):
            self._mjw.reset_data(self.model, self.data, mask)
            for name, first in self._first.items():
                rows = [_numbers(each, self.worlds) for each in (first, getattr(self.data, name))]
                wp.launch(physics_kernels.restore, dim=rows[0].shape, inputs=[mask, *rows], device=self._device)
        self._refresh()


def _numbers(array: Any, worlds: int) -> Any:
    """The same memory as float32 numbers, (w, n): of vectors too."""
    wp = warp()
    return wp.array(
        ptr=array.ptr, dtype=wp.float32, shape=(worlds, array.capacity // (4 * worlds)), device=array.device
    )
