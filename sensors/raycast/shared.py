"""One cast world for each App: all its sensors share the scenes."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.devices import HOST
from graph.sim.geometry.deforming import Following
from graph.sim.settings import ID_MAP_EXTENSION, RAY_THREADS
from sensors.surfaces.ids import has_prim, pack_stable_id_map, stable_id, stable_id_map
from sensors.surfaces.material_codes import PREFIX, PREFIX_SETTING, material_of
from sensors.surfaces.optics import Optics, optics_of
from sensors.surfaces.semantics import Labels, numbered, surface_label

from .world import CastWorld, bodies_of, soft_prim

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.geometry.collect import Mesh

_worlds: weakref.WeakKeyDictionary[App, tuple[Any, CastWorld]] = weakref.WeakKeyDictionary()


def cast_world(app: App) -> CastWorld:
    """The cast world of an App's geometry; a new one after the geometry was collected again (at play).

    Its surfaces are sorted by path, so the order of prims in a file changes no byte of a cloud.
    """
    geometry = app.geometry()
    known = _worlds.get(app)
    soft = frozenset(app.physics.deformable_paths if app.physics is not None else ())
    if known is not None and known[0] is geometry and known[1].soft == soft:
        return known[1]
    surfaces = sorted(geometry, key=lambda surface: surface.path)
    bodies = bodies_of(surfaces)
    weak = weakref.ref(app)  # the world's data must not keep its App alive

    latest: tuple[Any, np.ndarray] | None = None

    def poses(snapshot: Any) -> np.ndarray:
        nonlocal latest
        fabric = present_app(weak).fabric
        state = snapshot or fabric.capture()
        if latest is None or latest[0] is not state:  # many sensors look at one state
            latest = state, np.asarray(fabric.rigid_matrices(bodies, state))
        return latest[1]

    followers: dict[str, Following] = {}

    def points(mesh: Mesh, snapshot: Any) -> np.ndarray:
        app, prim = present_app(weak), soft_prim(mesh, soft) or mesh.source
        now = (snapshot or app.fabric.capture()).points(prim)
        if now is None or app.physics is None:
            return mesh.vertices
        return follower(app, mesh, prim).vertices(now)

    def velocities(mesh: Mesh, snapshot: Any) -> np.ndarray:
        app, prim = present_app(weak), soft_prim(mesh, soft) or mesh.source
        now = (snapshot or app.fabric.capture()).point_velocities(prim)
        if now is None or app.physics is None:
            return np.zeros_like(mesh.vertices)
        return follower(app, mesh, prim).velocities(now)

    def follower(app: App, mesh: Mesh, prim: str) -> Following:
        if mesh.path not in followers:
            assert app.physics is not None
            followers[mesh.path] = Following(mesh.vertices, app.physics.deformable_start(prim))
        return followers[mesh.path]

    def threads() -> int:
        return int(present_app(weak).settings.get(RAY_THREADS))

    world = _world_on(app.fidelity.device)(surfaces, poses, threads, soft, points, velocities)
    if app not in _worlds:
        app.on("close", lambda: _worlds.pop(app, None))
    _worlds[app] = (geometry, world)
    return world


def _world_on(device: str) -> Callable[..., CastWorld]:
    if device == HOST:
        return CastWorld
    from sensors.device.world import DeviceWorld

    return partial(DeviceWorld.on, device)


def present_app(weak: weakref.ref[App]) -> App:
    """The App of a sensor or cast world that renders. Both belong to their App and refer to it weakly."""
    app = weak()
    assert app is not None, "what an App renders with outlives it only unused"
    return app


def surface_materials(app: App) -> np.ndarray:
    """The encoded non-visual material of every surface of the App's cast world, (n,) uint32."""
    world = cast_world(app)
    found: np.ndarray | None = world.cache.get("materials")
    if found is None:
        prefix = str(app.settings.get(PREFIX_SETTING) or PREFIX)
        numbers = [material_of(app.stage, surface.material, prefix) for surface in world.surfaces]
        found = world.cache["materials"] = np.array(numbers, np.uint32)
    return found


def surface_optics(app: App) -> Optics:
    """The optical properties of every surface of the App's cast world."""
    world = cast_world(app)
    found: Optics | None = world.cache.get("optics")
    if found is None:
        found = world.cache["optics"] = optics_of(surface_materials(app))
    return found


def surface_ids(app: App) -> np.ndarray:
    """The 128-bit id of every surface of the App's cast world, (n, 16) uint8, little-endian."""
    world = cast_world(app)
    found: np.ndarray | None = world.cache.get("ids")
    if found is None:
        data = b"".join(stable_id(surface.path) for surface in world.surfaces)
        found = world.cache["ids"] = np.frombuffer(data, np.uint8).reshape(-1, 16)
    return found


def surface_id_map(app: App) -> dict[int, str]:
    """128-bit id -> path of every surface of the App's cast world; prims come first (`sensors.surfaces.ids`)."""
    world = cast_world(app)
    found: dict[int, str] | None = world.cache.get("id map")
    if found is None:
        found = world.cache["id map"] = stable_id_map(surface.path for surface in world.surfaces)
    return found


def packed_id_map(app: App) -> np.ndarray:
    """The same as a StableIdMap buffer, (size,) uint8, read-only, shared by all frames."""
    world = cast_world(app)
    found: np.ndarray | None = world.cache.get("packed id map")
    if found is None:
        extended = app.settings.get(ID_MAP_EXTENSION)  # an entry of graph.sim.parity
        entries = {number: path for number, path in surface_id_map(app).items() if extended or has_prim(path)}
        found = world.cache["packed id map"] = pack_stable_id_map(entries)
        found.setflags(write=False)
    return found


def surface_classes(app: App) -> np.ndarray:
    """The number of the semantic class of every surface of the App's cast world, (n,) uint32; see `surface_labels`."""
    return _classes(app)[0]


def surface_labels(app: App) -> dict[int, Labels]:
    """The labels of the semantic class numbers: 0 no hit, 1 no label, then the existing labels."""
    return dict(_classes(app)[1])


def _classes(app: App) -> tuple[np.ndarray, dict[int, Labels]]:
    world = cast_world(app)
    found: tuple[np.ndarray, dict[int, Labels]] | None = world.cache.get("classes")
    if found is None:
        found = world.cache["classes"] = numbered([surface_label(app.stage, surface) for surface in world.surfaces])
    return found
