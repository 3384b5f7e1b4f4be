"""One cast world for each world: all its sensors share the scenes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.devices import HOST, plugin_of
from graph.sim.geometry.surfaces import Following
from graph.sim.settings import ID_MAP_EXTENSION, RAY_THREADS
from sensors.surfaces.ids import has_prim, pack_stable_id_map, stable_id, stable_id_map
from sensors.surfaces.material_codes import PREFIX, PREFIX_SETTING, material_of
from sensors.surfaces.optics import Optics, optics_of
from sensors.surfaces.semantics import Labels, numbered, surface_label

from .world import CastWorld, bodies_of, once_a_world, soft_prim

if TYPE_CHECKING:
    from graph.sim.geometry.surfaces import Mesh
    from graph.sim.renderer.view import WorldView


def cast_world(scene: WorldView) -> CastWorld:
    """The cast world of a scene's geometry; a new one after the geometry was collected again (at play).

    Its surfaces are sorted by path, so the order of prims in a file changes no byte of a cloud.
    """
    known: CastWorld | None = scene.derived.get("cast world")
    if known is None:
        known = scene.derived["cast world"] = _cast_world(scene)
    return known


def _cast_world(scene: WorldView) -> CastWorld:
    surfaces = sorted(scene.geometry(), key=lambda surface: surface.path)
    bodies = bodies_of(surfaces)
    fabric, physics, settings = scene.fabric, scene.physics, scene.settings
    soft = frozenset(physics.deformable_paths if physics is not None else ())
    latest: tuple[Any, np.ndarray] | None = None

    def poses(snapshot: Any) -> np.ndarray:
        nonlocal latest
        state = snapshot or fabric.capture()
        if latest is None or latest[0] is not state:  # many sensors look at one state
            latest = state, np.asarray(fabric.rigid_matrices(bodies, state))
        return latest[1]

    followers: dict[str, Following] = {}

    def points(mesh: Mesh, snapshot: Any) -> np.ndarray:
        prim = soft_prim(mesh, soft) or mesh.source
        now = (snapshot or fabric.capture()).points(prim)
        return mesh.vertices if now is None else follower(mesh, prim).vertices(now)

    def velocities(mesh: Mesh, snapshot: Any) -> np.ndarray:
        prim = soft_prim(mesh, soft) or mesh.source
        now = (snapshot or fabric.capture()).point_velocities(prim)
        return np.zeros_like(mesh.vertices) if now is None else follower(mesh, prim).velocities(now)

    def follower(mesh: Mesh, prim: str) -> Following:
        if mesh.path not in followers:
            assert physics is not None
            followers[mesh.path] = Following(mesh.vertices, physics.deformable_start(prim))
        return followers[mesh.path]

    def threads() -> int:
        return int(settings.get(RAY_THREADS))

    device = scene.fidelity.device
    made: Callable[..., CastWorld] = CastWorld if device == HOST else partial(plugin_of(device).DeviceWorld.on, device)
    world = made(surfaces, poses, threads, soft, points, velocities)
    world.scene = scene
    return world


@once_a_world
def surface_materials(world: CastWorld) -> np.ndarray:
    """The encoded non-visual material of every surface, (n,) uint32."""
    prefix = str(world.scene.settings.get(PREFIX_SETTING) or PREFIX)
    numbers = [material_of(world.scene.stage, surface.material, prefix) for surface in world.surfaces]
    return np.array(numbers, np.uint32)


@once_a_world
def surface_optics(world: CastWorld) -> Optics:
    """The optical properties of every surface."""
    return optics_of(surface_materials(world))


@once_a_world
def surface_ids(world: CastWorld) -> np.ndarray:
    """The 128-bit id of every surface, (n, 16) uint8, little-endian."""
    data = b"".join(stable_id(surface.path) for surface in world.surfaces)
    return np.frombuffer(data, np.uint8).reshape(-1, 16)


@once_a_world
def surface_id_map(world: CastWorld) -> dict[int, str]:
    """128-bit id -> path of every surface; prims come first (`sensors.surfaces.ids`)."""
    return stable_id_map(surface.path for surface in world.surfaces)


@once_a_world
def packed_id_map(world: CastWorld) -> np.ndarray:
    """The same as a StableIdMap buffer, (size,) uint8, read-only, shared by all frames."""
    extended = world.scene.settings.get(ID_MAP_EXTENSION)  # an entry of graph.sim.parity
    entries = {number: path for number, path in surface_id_map(world).items() if extended or has_prim(path)}
    found = pack_stable_id_map(entries)
    found.setflags(write=False)
    return found


def surface_classes(world: CastWorld) -> np.ndarray:
    """The number of the semantic class of every surface, (n,) uint32; see `surface_labels`."""
    return _classes(world)[0]


def surface_labels(world: CastWorld) -> dict[int, Labels]:
    """The labels of the semantic class numbers: 0 no hit, 1 no label, then the existing labels."""
    return dict(_classes(world)[1])


@once_a_world
def _classes(world: CastWorld) -> tuple[np.ndarray, dict[int, Labels]]:
    return numbered([surface_label(world.scene.stage, surface) for surface in world.surfaces])
