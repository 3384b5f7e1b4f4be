"""The stage as geometry for rays: static geometry is built once, moving geometry only updated."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeGuard, TypeVar

import numpy as np

from graph.sim.geometry.surfaces import Mesh, Plane, Solid
from graph.sim.transforms import transformed

from .moving import MovingSurfaces
from .near import NEAR_ANCHOR_M, Moving
from .nearest import Nearest
from .rays import Hits, RayBundle
from .soft import PointsOf, SoftMeshes
from .standing import Standing, StandingScene
from .triangles import TriangleScene

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView

GRID_M = 1000.0
"""Scenes are built around the points of a grid with this spacing, and each sensor uses the nearest point: rays and
vertices are shifted in float64 before they are rounded to float32, so precision is the same everywhere in the
world.
"""


def anchor_of(places: np.ndarray) -> np.ndarray:
    """The points of the grid, (..., 3) float64 [m], that are nearest to places."""
    return np.asarray(np.rint(places / GRID_M) * GRID_M)


def bodies_of(geometry: Sequence[Mesh | Plane]) -> tuple[str, ...]:
    """The bodies that carry geometry, in order of first occurrence."""
    return tuple(dict.fromkeys(str(surface.body) for surface in geometry if surface.body is not None))


P = ParamSpec("P")
T = TypeVar("T")


def once_a_world(make: Callable[Concatenate[CastWorld, P], T]) -> Callable[Concatenate[CastWorld, P], T]:
    """A function whose results a cast world keeps, one for each combination of its further arguments."""

    @wraps(make)
    def kept(world: CastWorld, /, *args: P.args, **named: P.kwargs) -> T:
        key = (make, *args, *named.values())
        if key not in world.cache:
            world.cache[key] = make(world, *args, **named)
        found: T = world.cache[key]
        return found

    return kept


class CastWorld:
    """Casts against one collection of geometry.

    geometry: meshes, solids and infinite planes; those with a body move with it. poses: gives the bodies' poses,
    (b, 4, 4) float64 world [m] in the order of `bodies`, for a snapshot (None: now). threads: number of threads for
    casting (0: all cores). soft: prims that deform; points, velocities: of such a mesh's vertices [m, m/s]. formulas:
    whether rays meet solids by their closed forms, else by their triangles. `surfaces`
    lists the geometry in the order of their numbers.
    """

    device: Any = None
    """Where rays are cast (`graph.sim.devices.plugin_of`); None: on the processor."""
    scene: WorldView
    """Where its surfaces come from; None for bare geometry."""

    def __init__(
        self,
        geometry: Sequence[Mesh | Plane],
        poses: Callable[[Any], np.ndarray] | None = None,
        threads: Callable[[], int] = lambda: 0,
        soft: frozenset[str] = frozenset(),
        points: PointsOf | None = None,
        velocities: PointsOf | None = None,
        *,
        formulas: bool = True,
    ) -> None:
        self.surfaces = tuple(geometry)
        self.bodies = bodies_of(geometry)
        number = {body: index for index, body in enumerate(self.bodies)}
        self.body_of = np.array([number.get(str(s.body), -1) if s.body else -1 for s in geometry] or [-1], np.int32)
        self.cache: dict[Any, Any] = {}
        """Data that users of the world have computed about its surfaces; see `once_a_world`."""
        self._poses = poses
        self._threads = threads
        self._formulas = formulas
        rigid = [
            (index, one, int(self.body_of[index])) for index, one in enumerate(self.surfaces) if one.body is not None
        ]
        moving = [Moving(one, index, body) for index, one, body in rigid if self._is_mesh(one)]
        solids = [(one, index, body) for index, one, body in rigid if self.is_solid(one)]
        deforming = [
            (index, surface)
            for index, surface in enumerate(self.surfaces)
            if isinstance(surface, Mesh) and soft_prim(surface, soft) and len(surface.triangles)
        ]
        self.soft = soft
        self._points, self._velocities = points, velocities
        deforms = {index for index, _ in deforming}
        stands = [
            isinstance(one, Mesh) and one.body is None and index not in deforms
            for index, one in enumerate(self.surfaces)
        ]
        self.standing = Standing(self.surfaces, stands, formulas=formulas)
        """The surfaces that neither move nor deform."""
        self._made_of = deforming, moving, solids
        self.moving_surfaces = np.array([index for index, one, _ in rigid if isinstance(one, Mesh)], np.int32)
        self._planes = [(index, s) for index, s in enumerate(self.surfaces) if isinstance(s, Plane)]

    @cached_property
    def _soft(self) -> SoftMeshes | None:
        deforming, points = self._made_of[0], self._points
        return SoftMeshes(deforming, points) if deforming and points else None

    @cached_property
    def _moving(self) -> MovingSurfaces | None:
        _, moving, solids = self._made_of
        return MovingSurfaces(moving, solids) if moving or solids else None

    def is_solid(self, surface: Mesh | Plane) -> TypeGuard[Solid]:
        """Whether rays meet a surface by the formula of its solid."""
        return self._formulas and isinstance(surface, Solid)

    def _is_mesh(self, surface: Mesh | Plane) -> TypeGuard[Mesh]:
        return isinstance(surface, Mesh) and not self.is_solid(surface) and len(surface.triangles) > 0

    @cached_property
    def facets(self) -> CastWorld:
        """The same world with triangles for all solids, for those who go by flat faces."""
        solids = [surface for surface in self.surfaces if self.is_solid(surface)]
        if not solids:
            return self
        world = CastWorld(
            self.surfaces, self._poses, self._threads, self.soft, self._points, self._velocities, formulas=False
        )
        if all(solid.body is not None for solid in solids):
            world.standing = self.standing
        return world

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, spots: bool = False) -> Hits:
        """Nearest hits; see `RayCaster`. Normals follow the winding, in world axes."""
        anchor = anchor_of(rays.origin)
        scene = self.standing.scene(anchor, rays.exclude, rays.origin, rays.reach)
        threads = self.threads
        nearest = Nearest(
            len(rays.table), scene.surface_of, scene.starts, scene.triangles, normals=normals, spots=spots
        )
        if scene.static:
            start = (rays.origin - anchor).astype(np.float32)
            nearest.add_static(*scene.cast(scene.static, rays, start, threads, uv=spots))
        self._add_others(nearest, rays, scene, anchor, poses)
        return nearest.hits()

    def blocked(self, rays: RayBundle, lengths: np.ndarray, poses: Any) -> np.ndarray:
        """(n,) bool, which rays meet a surface other than the standing meshes within `lengths` (n,) float32 [m]."""
        anchor = anchor_of(rays.origin)
        scene = self.standing.scene(anchor, rays.exclude, rays.origin, rays.reach)
        nearest = Nearest(len(rays.table), scene.surface_of, scene.starts, scene.triangles, normals=False, spots=False)
        nearest.distance[:] = lengths
        self._add_others(nearest, rays, scene, anchor, poses)
        return np.asarray(nearest.distance < lengths)

    def _add_others(
        self, nearest: Nearest, rays: RayBundle, scene: StandingScene, anchor: np.ndarray, poses: Any
    ) -> None:
        """Adds hits of all but standing meshes."""
        states = poses if rays.spans else (poses,)
        looks = [
            (nearest.some(rows) if rays.spans else nearest, one, state, self.body_poses(state))
            for (rows, one), state in zip(rays.by_state(), states, strict=True)
        ]
        for index, _ in self._planes:
            if index not in scene.skip:
                for own, one, _, bodies in looks if self.body_of[index] >= 0 else [(nearest, rays, None, None)]:
                    origin, normal = self.plane(index, bodies)
                    own.add_plane(one, origin, normal, index)
        body_poses = [bodies for *_, bodies in looks if bodies is not None]
        if self._moving is not None and body_poses:
            skip = scene.left_out(self._moving.surfaces)
            self._moving.cast(rays, anchor, np.stack(body_poses), skip, self.threads, nearest)
        if self._soft is not None:
            for own, one, state, _ in looks:
                self._soft.cast(one, state, scene.skip, self.threads, own)

    def static_scene(self, origin: np.ndarray, exclude: frozenset[str]) -> tuple[np.ndarray, TriangleScene | None]:
        """For sensors near `origin` (3,) float64 [m]: the origin of a scene's coordinates, and the scene of static
        geometry.

        The scene is None without static geometry.
        """
        anchor = anchor_of(origin)
        return anchor, self.standing.scene(anchor, exclude, origin, math.inf).static

    @property
    def rays_go_everywhere(self) -> bool:
        """Whether the rays of several sensors may be cast together: nothing that moves needs rays of its own."""
        return self._soft is None and (self._moving is None or self._moving.few_meshes)

    def shares_frame(self, places: np.ndarray) -> bool:
        """Whether sensors at (n, 3) [m] from their anchor see moving meshes in one scene."""
        return self._moving is None or bool(np.abs(places).max() < NEAR_ANCHOR_M)

    @property
    def threads(self) -> int:
        """Number of threads for casting; 0: all cores."""
        return self._threads()

    def body_poses(self, state: Any = None) -> np.ndarray | None:
        """(b, 4, 4) float64 world [m], the bodies in a state (None: now); None if nothing moves."""
        return self._poses(state) if self.bodies and self._poses else None

    def plane(self, surface: int, body_poses: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """A point [m] of an infinite plane and its unit normal, world, (3,) float64."""
        plane, body = self.surfaces[surface], self.body_of[surface]
        assert isinstance(plane, Plane)
        origin, normal = np.asarray(plane.origin, np.float64), np.asarray(plane.normal, np.float64)
        if body >= 0 and body_poses is not None:
            pose = body_poses[body]
            origin, normal = pose[:3, :3] @ origin + pose[:3, 3], pose[:3, :3] @ normal
        return origin, normal

    def vertices(self, surface: int, body_poses: np.ndarray | None, state: Any = None) -> np.ndarray:
        """(n, 3) float64 [m], world, of a mesh."""
        mesh, body = self.surfaces[surface], self.body_of[surface]
        assert isinstance(mesh, Mesh)
        if mesh.source in self.soft and self._points is not None:
            return np.asarray(self._points(mesh, state), np.float64)
        points = np.asarray(mesh.vertices, np.float64)
        if body >= 0 and body_poses is not None:
            return transformed(body_poses[body], points)
        return points

    def vertex_velocities(self, surface: int, state: Any = None) -> np.ndarray:
        """(n, 3) float64 [m/s], world, of the vertices of a mesh that deforms; 0 where they are not known."""
        mesh = self.surfaces[surface]
        assert isinstance(mesh, Mesh)
        if self._velocities is None:
            return np.zeros((len(mesh.vertices), 3))
        return np.asarray(self._velocities(mesh, state), np.float64)

    @cached_property
    def deforming(self) -> np.ndarray:
        """Which surfaces deform, (s + 1,) bool; the last, which `NO_SURFACE` finds, does not."""
        found = [isinstance(one, Mesh) and soft_prim(one, self.soft) is not None for one in self.surfaces]
        return np.array([*found, False])


def soft_prim(surface: Mesh, soft: frozenset[str]) -> str | None:
    """The deforming prim of a surface (the prim itself, or that of a subset); None if it does not deform."""
    source = surface.source
    return next((path for path in (source, source.rpartition("/")[0]) if path in soft), None)
