"""`isaacsim.robot.surface_gripper`: suction grippers by the paths of their prims."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

from graph.base.errors import RunError
from graph.isaac.results import numbers
from graph.isaac.session import app, kit, warn
from graph.sim.scene.scan import ATTACHMENTS, GRIPPER

from .prim_base import attribute
from .stage import generate_next_free_path
from .xform_prim import XformPrim

__all__ = ["GripperView", "create_surface_gripper"]
ACTION = 0.3
"""The least value of an action that closes a gripper; its negative opens one."""
PROPERTIES = {
    "max_grip_distance": "isaac:maxGripDistance",
    "coaxial_force_limit": "isaac:coaxialForceLimit",
    "shear_force_limit": "isaac:shearForceLimit",
    "retry_interval": "isaac:retryInterval",
}


class GripperStatus(IntEnum):
    Open = 0
    Closed = 1
    Closing = 2


def create_surface_gripper(stage: Any, prim_path: str) -> Any:
    path = generate_next_free_path(f"{prim_path.rstrip('/')}/SurfaceGripper", prepend_default_prim=False)
    prim = stage.DefinePrim(path, GRIPPER)
    prim.CreateRelationship(ATTACHMENTS)
    return prim


class SurfaceGripperInterface:
    def _gripper(self, path: str) -> Any:
        """The gripper; None while stopped and, with a warning, for a path without a gripper."""
        if app().timeline.is_stopped():
            return None
        try:
            physics = app().physics
            if physics is None:
                raise RunError("nothing on the stage can move")
            return physics.gripper(path)
        except RunError as error:
            warn("no-surface-gripper", path, f"{str(error).removeprefix(f'{path}: ')}; it stays open")
            return None

    def get_gripper_status(self, prim_path: str) -> GripperStatus:
        found = self._gripper(prim_path)
        return GripperStatus.Open if found is None else GripperStatus[found.status]

    def open_gripper(self, prim_path: str) -> bool:
        return self._act(prim_path, lambda gripper: gripper.open())

    def close_gripper(self, prim_path: str) -> bool:
        return self._act(prim_path, lambda gripper: gripper.close())

    def _act(self, path: str, act: Callable[[Any], None]) -> bool:
        found = self._gripper(path)
        if found is not None:
            act(found)
        return found is not None

    def set_gripper_action(self, prim_path: str, action: float) -> bool:
        if abs(action) < ACTION:
            return True
        return self.close_gripper(prim_path) if action > 0 else self.open_gripper(prim_path)

    def get_gripped_objects(self, prim_path: str) -> list[str]:
        found = self._gripper(prim_path)
        return [] if found is None else list(found.held)

    def get_gripper_status_batch(self, prim_paths: list[str]) -> list[GripperStatus]:
        return [self.get_gripper_status(path) for path in prim_paths]

    def get_gripped_objects_batch(self, prim_paths: list[str]) -> list[list[str]]:
        return [self.get_gripped_objects(path) for path in prim_paths]

    def set_gripper_action_batch(self, prim_paths: list[str], actions: list[float]) -> list[bool]:
        return [self.set_gripper_action(path, value) for path, value in zip(prim_paths, actions, strict=True)]


def acquire_surface_gripper_interface() -> SurfaceGripperInterface:
    return kit().singleton(SurfaceGripperInterface, SurfaceGripperInterface)


def release_surface_gripper_interface(interface: SurfaceGripperInterface) -> None: ...


bindings = SimpleNamespace(
    GripperStatus=GripperStatus,
    SurfaceGripperInterface=SurfaceGripperInterface,
    acquire_surface_gripper_interface=acquire_surface_gripper_interface,
    release_surface_gripper_interface=release_surface_gripper_interface,
)


class GripperView(XformPrim):
    def __init__(
        self,
        paths: Any = None,
        max_grip_distance: Any = None,
        coaxial_force_limit: Any = None,
        shear_force_limit: Any = None,
        retry_interval: Any = None,
        positions: Any = None,
        translations: Any = None,
        orientations: Any = None,
        scales: Any = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        super().__init__(
            paths,
            positions=positions,
            translations=translations,
            orientations=orientations,
            scales=scales,
            reset_xform_op_properties=reset_xform_op_properties,
        )
        self.count = len(self.paths)
        self.surface_gripper_interface = acquire_surface_gripper_interface()
        self.set_surface_gripper_properties(max_grip_distance, coaxial_force_limit, shear_force_limit, retry_interval)

    def _chosen(self, indices: Any) -> list[int]:
        return [int(one) for one in numbers(indices, self.count)]

    def get_surface_gripper_status(self, indices: Any = None) -> list[GripperStatus]:
        return self.surface_gripper_interface.get_gripper_status_batch([self.paths[i] for i in self._chosen(indices)])

    def get_gripped_objects(self, indices: Any = None) -> list[list[str]]:
        return self.surface_gripper_interface.get_gripped_objects_batch([self.paths[i] for i in self._chosen(indices)])

    def apply_gripper_action(self, values: list[float], indices: Any = None) -> None:
        self._one_each("values", values)
        for number in self._chosen(indices):
            self.surface_gripper_interface.set_gripper_action(self.paths[number], float(values[number]))

    def get_surface_gripper_properties(self, indices: Any = None) -> tuple[list[float], ...]:
        prims = [self.prims[i] for i in self._chosen(indices)]
        return tuple([prim.GetAttribute(name).Get() for prim in prims] for name in PROPERTIES.values())

    def set_surface_gripper_properties(
        self,
        max_grip_distance: Any = None,
        coaxial_force_limit: Any = None,
        shear_force_limit: Any = None,
        retry_interval: Any = None,
        indices: Any = None,
    ) -> None:
        given = (max_grip_distance, coaxial_force_limit, shear_force_limit, retry_interval)
        for (name, full), values in zip(PROPERTIES.items(), given, strict=True):
            if values is None:
                continue
            self._one_each(name, values)
            for number in self._chosen(indices):
                attribute(self.prims[number], full, "float", float(values[number]))

    def _one_each(self, name: str, values: Any) -> None:
        if len(values) != self.count:
            raise ValueError(f"{name} has {len(values)} values; give one for each of the {self.count} grippers")
