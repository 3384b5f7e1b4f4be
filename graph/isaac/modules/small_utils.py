"""Small modules of `isaacsim.core.utils`, each an object of this module, and `omni.log`."""

from __future__ import annotations

from random import uniform
from types import SimpleNamespace
from typing import Any

import numpy as np

from graph.sim.usd import UsdGeom, UsdPhysics

from . import carb
from .scene_queries import get_physx_scene_query_interface
from .transforms import quats_to_rot_matrices
from .xforms import get_relative_transform

_NOTHING_HIT = 10000.0


def radians_to_degrees(rad_angles: Any) -> Any:
    return np.asarray(rad_angles) * (180.0 / np.pi)


def cross(a: Any, b: Any) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalized(v: Any) -> Any:
    """The vector with length 1; without a length, itself."""
    length = np.linalg.norm(v)
    return v if length == 0 else np.asarray(v) / length


def normalize(v: Any) -> Any:
    """The same, written into the array itself."""
    length = np.linalg.norm(v)
    if length:
        v /= length
    return v


def get_random_values_in_range(min_range: Any, max_range: Any) -> np.ndarray:
    return np.array([uniform(low, high) for low, high in zip(min_range, max_range, strict=True)])


def get_mesh_vertices_relative_to(mesh_prim: Any, coord_prim: Any) -> np.ndarray:
    points = np.asarray(UsdGeom.Mesh(mesh_prim).GetPointsAttr().Get(), float)
    matrix = get_relative_transform(mesh_prim, coord_prim)
    out: np.ndarray = points @ matrix[:3, :3].T + matrix[:3, 3]
    return out


def ray_cast(position: Any, orientation: Any, offset: Any, max_dist: float = 100.0) -> tuple[str | None, float]:
    """The body that a ray along the pose's X axis meets, and how far it is from the shifted start."""
    turn = quats_to_rot_matrices(np.asarray(orientation, float))
    start = np.asarray(position, float) + turn @ np.asarray(offset, float)
    hit = get_physx_scene_query_interface().raycast_closest(start, turn[:, 0], max_dist)
    return (hit["rigidBody"], hit["distance"]) if hit["hit"] else (None, _NOTHING_HIT)


def add_articulation_root(prim: Any) -> None:
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    prim.AddAppliedSchema("PhysxArticulationAPI")


def remove_articulation_root(prim: Any) -> None:
    prim.RemoveAPI(UsdPhysics.ArticulationRootAPI)
    prim.RemoveAppliedSchema("PhysxArticulationAPI")


def move_articulation_root(src_prim: Any, dst_prim: Any) -> None:
    """Moves the articulation root from one prim to another, if the first one has it."""
    if src_prim.HasAPI(UsdPhysics.ArticulationRootAPI):
        remove_articulation_root(src_prim)
        add_articulation_root(dst_prim)


math = SimpleNamespace(cross=cross, normalize=normalize, normalized=normalized, radians_to_degrees=radians_to_degrees)
_AXES = ("X", "Y", "Z")
constants = SimpleNamespace(
    AXES_INDICES={name: number for number, axis in enumerate(_AXES) for name in (axis, axis.lower())},
    AXES_TOKEN={name: axis for axis in _AXES for name in (axis, axis.lower())},
)
random = SimpleNamespace(get_random_values_in_range=get_random_values_in_range)
mesh = SimpleNamespace(get_mesh_vertices_relative_to=get_mesh_vertices_relative_to)
collisions = SimpleNamespace(ray_cast=ray_cast)
articulations = SimpleNamespace(
    add_articulation_root=add_articulation_root,
    move_articulation_root=move_articulation_root,
    remove_articulation_root=remove_articulation_root,
)
log = SimpleNamespace(
    error=carb.log_error,
    fatal=carb.log_error,
    info=carb.log_info,
    verbose=carb.log_verbose,
    warn=carb.log_warn,
)
