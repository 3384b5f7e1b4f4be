"""Colliders as geoms of a MuJoCo model, and their volumes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.base.silence import silenced
from graph.sim import transforms
from graph.sim.physics.world_model import Collider, Volume
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .contacts import FIRM, SMOOTH
from .library import mujoco

GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "plane": mujoco.mjtGeom.mjGEOM_PLANE,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}

FAR = 16.0
"""From this coordinate on [m], float32 is coarser than 1e-6 m, and a mesh is centred."""


@dataclass(frozen=True)
class Grip:
    """How a geom takes part in contacts: sliding friction, priority, (contype, conaffinity)."""

    friction: float
    priority: int = 0
    bits: tuple[int, int] = (1, 1)


def new_spec() -> Any:
    """An empty specification of a model, in radians."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.balanceinertia = True
    spec.compiler.autolimits = False
    return spec


def compiled(spec: Any) -> Any:
    """The model of a specification. Raises UserError with MuJoCo's text if MuJoCo refuses it."""
    try:
        with silenced():  # Qhull prints pages about meshes that have no hull
            return spec.compile()
    except ValueError as error:
        raise UserError(f"the scene's physics cannot be built: {' '.join(str(error).split())}") from error


class Meshes:
    """Mesh assets of a spec; colliders with equal points share one."""

    def __init__(self, spec: Any) -> None:
        self.spec = spec
        self.names: dict[bytes, str] = {}

    def name(self, vertices: Floats) -> str:
        """The asset that is the convex hull of (n, 3) points."""
        points = np.ascontiguousarray(vertices, dtype=np.float64)
        key = points.tobytes()
        if key not in self.names:
            self.names[key] = f"#mesh{len(self.names)}"
            asset = self.spec.add_mesh(name=self.names[key])
            asset.uservert = points.ravel()
            asset.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        return self.names[key]


def add_geom(parent: Any, collider: Collider, meshes: Meshes, name: str, grip: Grip, density: float = 0.0) -> Any:
    """A collider on a body of a spec."""
    size = np.zeros(3)
    size[: len(collider.size)] = collider.size
    if collider.kind == "plane":
        size[:] = (0, 0, 1)
    geom = parent.add_geom(name=name, type=GEOMS[collider.kind], size=size, density=density)
    geom.pos = collider.pose[:3, 3]
    geom.quat = transforms.quaternion(collider.pose[:3, :3])
    geom.friction = [grip.friction, collider.material.torsion, collider.material.rolling]
    geom.priority = grip.priority
    geom.condim = 3 if grip.friction > SMOOTH else 1
    geom.contype, geom.conaffinity = grip.bits
    geom.solimp = FIRM
    if collider.kind == "mesh":
        assert collider.vertices is not None
        centre = _centre(collider.vertices)
        geom.pos = collider.pose[:3, :3] @ centre + collider.pose[:3, 3]
        geom.meshname = meshes.name(collider.vertices - centre)
    return geom


def _centre(vertices: Floats) -> Floats:
    """What (n, 3) vertices are taken from before MuJoCo rounds them to float32: (3,) their middle if it is far, or 0.

    Those near their origin stay as they are, so that equal meshes at several places are one asset.
    """
    centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return centre if np.abs(centre).max() > FAR else np.zeros(3)


Shape = tuple[Any, ...]
"""The data that determines a collider's volume."""


def measured(
    colliders: Iterable[Collider], warn: Warn, known: dict[Shape, Volume] | None = None
) -> list[tuple[Collider, Volume]]:
    """The colliders that MuJoCo can build, each with its volume: measured in a model of it alone, at density 1.

    known: volumes measured before; afterwards, those of these colliders.
    """
    out = []
    before, now = {} if known is None else known, dict[Shape, Volume]()
    for collider in colliders:
        if collider.kind == "plane":
            out.append((collider, Volume(0.0, np.zeros(3), np.zeros((3, 3)))))
            continue
        if collider.volume is not None:
            out.append((collider, collider.volume))
            continue
        points = b"" if collider.vertices is None else collider.vertices.tobytes()
        key = (collider.kind, collider.size, collider.pose.tobytes(), points)
        volume = now.get(key) or before.get(key) or _volume(collider, warn)
        if volume is not None:
            now[key] = volume
            out.append((collider, volume))
    if known is not None:
        known.clear()
        known.update(now)
    return out


def _volume(collider: Collider, warn: Warn) -> Volume | None:
    spec = new_spec()
    try:
        add_geom(spec.worldbody.add_body(), collider, Meshes(spec), "only", Grip(1.0), density=1.0)
        with silenced():
            model = spec.compile()
    except ValueError as error:
        words = " ".join(str(error).partition("Element name")[0].split()).removeprefix("Error: ")
        warn("bad-collider", collider.path, f"nothing hits it: {words}")
        return None
    axes = transforms.rotation_matrices(model.body_iquat[1])
    with np.errstate(over="ignore", invalid="ignore"):  # body_inertia reports the result
        tensor = axes @ np.diag(model.body_inertia[1]) @ axes.T
    return Volume(float(model.body_mass[1]), model.body_ipos[1].copy(), tensor)


def still(colliders: Iterable[Collider], roots: dict[str, str | None]) -> NDArray[np.bool_]:
    """(n,) colliders that forces cannot move; roots: for each body, the body to which it is welded (None: the
    world).
    """
    return np.array([c.body is None or roots.get(c.body, c.body) is None for c in colliders], dtype=np.bool_)
