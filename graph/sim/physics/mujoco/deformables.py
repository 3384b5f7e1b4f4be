"""Cloth, soft bodies and particles as MuJoCo's flexes, of the stage and of a model: their points at any time.

Of the stage, each point is a body of the model with three sliding joints, after all bodies of the stage; so its
position follows from the coordinates alone. Triangles and tetrahedra are elastic finite elements, which the integrator
`discrete` evaluates at the end of the step: stable at any stiffness.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.physics.world_model import Soft
from graph.sim.transforms import Floats

from .contacts import FIRM
from .library import mujoco, state_of

if TYPE_CHECKING:
    from .engine import MujocoEngine


def add_soft(spec: Any, soft: Soft, handles: Mapping[str, Any]) -> None:
    """Writes a soft prim into a spec that already contains all other bodies."""
    names, local = [], np.zeros((len(soft.places), 3))
    for number, (place, mass) in enumerate(zip(soft.places, soft.masses, strict=True)):
        holder, spot = soft.held.get(number, (None, place))
        if number in soft.held and holder is None:
            local[number] = place
            names.append("world")
            continue
        name = point_name(soft.path, number)
        names.append(name)
        inertia = 0.4 * mass * soft.radius**2
        body = spec.worldbody.add_body(name=name, pos=place, mass=mass, explicitinertial=True, inertia=[inertia] * 3)
        if holder is not None:
            tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY)
            tie.name, tie.name1, tie.name2 = f"{name}#held", handles[holder].name, name
            tie.data[:3] = spot
            tie.solimp = (0.99, 0.999, 0.001, 0.5, 2)
        for axis in np.eye(3):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        if soft.elements is None:
            friction = [soft.material.sliding, soft.material.torsion, soft.material.rolling]
            size = [soft.radius, 0, 0]
            geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, friction=friction, density=0)
            geom.solimp = FIRM
    if soft.elements is None:
        return
    flex = spec.add_flex(name=soft.path, dim=soft.elements.shape[1] - 1)
    flex.vertbody = names
    if soft.held:
        flex.vert = local.ravel()
    flex.elem = soft.elements.astype(np.int32).ravel()
    flex.radius, flex.young, flex.poisson, flex.damping = soft.radius, soft.young, soft.poisson, soft.damping
    if soft.elements.shape[1] == 3:
        flex.thickness = soft.thickness
        flex.elastic2d = 3
    flex.friction = [soft.material.sliding, soft.material.torsion, soft.material.rolling]
    flex.solimp = FIRM
    kinds = mujoco.mjtFlexSelf
    flex.selfcollide = kinds.mjFLEXSELF_AUTO if soft.self_collides else kinds.mjFLEXSELF_NONE


def point_name(path: str, number: int) -> str:
    """The name of a point's body in the model."""
    return f"{path}#{number}"


class Deformables:
    """The soft prims of a model, by path."""

    def __init__(self, model: Any, softs: Sequence[Soft]) -> None:
        self._softs = {soft.path: soft for soft in softs}
        self._moving: dict[str, NDArray[np.intp]] = {}
        self._addresses: dict[str, NDArray[np.intp]] = {}
        self._speeds: dict[str, NDArray[np.intp]] = {}
        for path, soft in self._softs.items():
            fixed = {number for number, (body, _) in soft.held.items() if body is None}
            free = [number for number in range(len(soft.places)) if number not in fixed]
            first = np.array([int(model.body(point_name(path, number)).jntadr[0]) for number in free], dtype=np.intp)
            self._moving[path] = np.array(free, dtype=np.intp)
            three = np.arange(3)
            self._addresses[path] = np.add.outer(model.jnt_qposadr[first], three).reshape(-1, 3)
            self._speeds[path] = np.add.outer(model.jnt_dofadr[first], three).reshape(-1, 3)

    @property
    def paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return tuple(self._softs)

    def start_points(self, path: str) -> Floats:
        """(p, 3) initial positions of a prim's points, in the world [m]."""
        soft = self._softs[path]
        out: Floats = np.einsum("pk,pkj->pj", soft.weights, soft.places[soft.corners])
        return out

    def start(self, data: Any) -> None:
        """Sets the initial velocities of the prims."""
        for path, soft in self._softs.items():
            if soft.velocity.any():
                data.qvel[self._speeds[path]] = soft.velocity

    def take_over(self, old: Deformables, old_data: Any, data: Any) -> None:
        """Takes over the state of another model's deformables that have the same points."""
        for path in self._softs:
            before = old._addresses.get(path)
            if before is not None and before.shape == self._addresses[path].shape:
                data.qpos[self._addresses[path]] = old_data.qpos[before]
                data.qvel[self._speeds[path]] = old_data.qvel[old._speeds[path]]

    def points(self, path: str, coordinates: Floats) -> Floats:
        """(p, 3) the points of a prim in the world [m], in its order; coordinates: (nq,) of the model's state."""
        soft = self._softs[path]
        places = soft.places.copy()
        places[self._moving[path]] += coordinates[self._addresses[path]]
        out: Floats = np.einsum("pk,pkj->pj", soft.weights, places[soft.corners])
        return out


class Flexes:
    """A model's flexes by the path of the mesh that mirrors each, beside the soft prims of the stage.

    Bodies, and nodes inside them, carry the vertices; they are computed with a second set of MuJoCo's data, which does
    not affect the motion. Vertices on bodies that users move follow the present poses of those bodies.
    """

    def __init__(self, physics: MujocoEngine, starts: Mapping[str, tuple[str, Floats]], others: Deformables) -> None:
        self._physics, self._starts, self._others = physics, starts, others
        self._model = physics.model
        self._aside = state_of(self._model)
        kind = mujoco.mjtObj.mjOBJ_FLEX
        self._numbers = {path: mujoco.mj_name2id(self._model, kind, name) for path, (name, _) in starts.items()}

    @property
    def paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return (*self._others.paths, *self._starts)

    def start_points(self, path: str) -> Floats:
        """(p, 3) initial positions of a prim's points, in the world [m]."""
        return self._starts[path][1] if path in self._starts else self._others.start_points(path)

    def start(self, data: mujoco.MjData) -> None:
        """Sets the initial velocities of the stage's prims."""
        self._others.start(data)

    def points(self, path: str, coordinates: Floats) -> Floats:
        """(p, 3) the points of a prim in the world [m], in its order; coordinates: (nq,) of the model's state."""
        if path not in self._starts:
            return self._others.points(path, coordinates)
        model, aside = self._model, self._aside
        aside.qpos[:] = coordinates
        if not self._physics.closed:
            aside.mocap_pos[:], aside.mocap_quat[:] = self._physics.data.mocap_pos, self._physics.data.mocap_quat
        mujoco.mj_kinematics(model, aside)
        mujoco.mj_comPos(model, aside)
        mujoco.mj_flex(model, aside)
        first, count = model.flex_vertadr[self._numbers[path]], model.flex_vertnum[self._numbers[path]]
        return np.array(aside.flexvert_xpos[first : first + count])
