"""What each of many worlds begins with: how the world of one seed differs from that of another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.sim.geometry.surfaces import Mesh, Plane, Solid

SAME_M = 1e-9
"""Places of one surface in two worlds that differ by less, relative to their size, are the same."""

UNDRAWN = "worlds share geometry, materials and sensors; poses, masses, friction, joints and drives may differ"


@dataclass(frozen=True)
class Mount:
    """Where a lidar is, (4, 4) to its carrier or the world [m], and all that worlds share of it."""

    carrier: str | None
    pose: np.ndarray
    shared: tuple[Any, ...]


@dataclass
class Start:
    """A world that begins to play: its surfaces, lidars and physics (an engine, or None)."""

    surfaces: Sequence[Mesh | Plane]
    optics: Any
    lidars: Mapping[str, Mount]
    physics: Any
    rates: tuple[Any, ...]
    held: Mapping[int, np.ndarray] = field(default_factory=dict)
    """Poses (4, 4) [m] of surfaces on bodies that the physics does not move, by number: they stand."""


@dataclass
class Difference:
    """Where another world begins otherwise: poses (4, 4) [m] by number of standing surfaces, relative to the first
    world's, and of surfaces on bodies that are held; poses of lidars; and what the physics has otherwise
    (`physics_start.difference`).
    """

    surfaces: dict[int, np.ndarray] = field(default_factory=dict)
    lidars: dict[str, np.ndarray] = field(default_factory=dict)
    physics: dict[str, np.ndarray] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.surfaces or self.lidars or self.physics)


def start_of(app: Any, sensors: Sequence[Any]) -> Start:
    """How the world of an App begins; sensors: the runtimes of its lidars."""
    from sensors.raycast.shared import cast_world, surface_optics

    surfaces, simulated = cast_world(app.world).surfaces, () if app.physics is None else app.physics.body_paths
    mounts = {}
    for sensor in sensors:
        body, pose = app.fabric.body_of(sensor.path), sensor.pose()
        if body not in simulated:
            body = None
        if body is not None:
            pose = np.linalg.inv(np.asarray(app.fabric.rigid_matrices((body,), app.fabric.capture()))[0]) @ pose
        shared = sensor.config, sensor.turns.pattern(0), sensor.rate, tuple(sensor.exclude)
        mounts[sensor.path] = Mount(body, pose, shared)
    still = [n for n, one in enumerate(surfaces) if one.body is not None and one.body not in simulated]
    bodies = tuple(str(surfaces[n].body) for n in still)
    held = dict(zip(still, np.asarray(app.fabric.rigid_matrices(bodies, app.fabric.capture())), strict=True))
    rates = app.simulation.steps_per_second, app.loop_rate
    return Start(surfaces, surface_optics(cast_world(app.world)), mounts, app.physics, rates, held)


def difference(first: Start, other: Start) -> Difference:
    """How another world differs from the first. Raises UserError where worlds cannot differ."""
    if first.rates != other.rates:
        raise UserError("worlds share their clocks")
    found = Difference()
    one, two = first.surfaces, other.surfaces
    if [(s.path, s.body, type(s)) for s in one] != [(s.path, s.body, type(s)) for s in two]:
        raise UserError(f"it changes which shapes there are; {UNDRAWN}")
    for number, (old, new) in enumerate(zip(one, two, strict=True)):
        moved = _moved(old, new)
        if moved is None or (old.body is not None and not np.array_equal(moved, np.eye(4))):
            raise UserError(f"it changes the shape of {old.path}; {UNDRAWN}")
        if number in first.held and not np.array_equal(first.held[number], other.held[number]):
            found.surfaces[number] = other.held[number]
        elif not np.array_equal(moved, np.eye(4)):
            found.surfaces[number] = moved
    if not same(first.optics, other.optics):
        raise UserError(f"it changes the material of surfaces; {UNDRAWN}")
    for path, mount in first.lidars.items():
        there = other.lidars.get(path)
        if there is None or there.carrier != mount.carrier or not same(there.shared, mount.shared):
            raise UserError(f"it changes the lidar {path}; {UNDRAWN}")
        if not np.array_equal(there.pose, mount.pose):
            found.lidars[path] = there.pose
    if first.physics is not None or other.physics is not None:
        if first.physics is None or other.physics is None:
            raise UserError(f"it changes whether anything moves; {UNDRAWN}")
        from . import physics_start

        found.physics = physics_start.difference(first.physics, other.physics)
    return found


def same(one: Any, two: Any) -> bool:
    """Whether plain data, dataclasses and arrays are equal."""
    if type(one) is not type(two):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, two)
    if isinstance(one, tuple | list):
        return len(one) == len(two) and all(map(same, one, two))
    if is_dataclass(one):
        return all(same(getattr(one, each.name), getattr(two, each.name)) for each in fields(one))
    return bool(one == two)


def _moved(old: Mesh | Plane, new: Mesh | Plane) -> np.ndarray | None:
    """The rigid transform (4, 4) that takes a surface to its place in another world, or None."""
    if isinstance(old, Plane):
        assert isinstance(new, Plane)
        return _between(old, new)
    if isinstance(old, Solid):
        assert isinstance(new, Solid)
        here, there = old.form, new.form
        if (here.kind, here.low, here.high) != (there.kind, there.low, there.high):
            return None
        return _rigid(here.frame, there.frame)
    assert isinstance(new, Mesh)
    if not np.array_equal(old.triangles, new.triangles) or old.vertices.shape != new.vertices.shape:
        return None
    if np.array_equal(old.vertices, new.vertices):
        return np.eye(4)
    if old.frame is None or new.frame is None:
        return None
    moved = _rigid(old.frame, new.frame)
    if moved is None:
        return None
    there = old.vertices @ moved[:3, :3].T + moved[:3, 3]
    return moved if np.abs(there - new.vertices).max() <= SAME_M * max(1.0, np.abs(there).max()) else None


def _rigid(old: np.ndarray, new: np.ndarray) -> np.ndarray | None:
    """The transform from one frame to the other, if it is rigid."""
    if np.array_equal(old, new):
        return np.eye(4)
    moved: np.ndarray = new @ np.linalg.inv(old)
    turn = moved[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > SAME_M or np.linalg.det(turn) < 0:
        return None
    return moved


def _between(old: Plane, new: Plane) -> np.ndarray:
    """A rigid transform that takes one plane to another: the shortest turn between their normals."""
    moved = np.eye(4)
    if np.array_equal(old.origin, new.origin) and np.array_equal(old.normal, new.normal):
        return moved
    a, b = np.asarray(old.normal), np.asarray(new.normal)
    axis, along = np.cross(a, b), float(a @ b)
    if along > -1 and np.linalg.norm(axis) > 0:
        cross = np.cross(np.eye(3), axis)
        moved[:3, :3] = np.eye(3) + cross + cross @ cross / (1 + along)
    elif along < 0:  # half a turn about any axis in the plane
        side = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        side /= np.linalg.norm(side)
        moved[:3, :3] = 2 * np.outer(side, side) - np.eye(3)
    moved[:3, 3] = np.asarray(new.origin) - moved[:3, :3] @ np.asarray(old.origin)
    return moved
