"""The physics of an MJCF scene: the model unchanged, or with inline prims added to it."""

from __future__ import annotations

import copy
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim import transforms
from graph.sim.physics.mujoco.compile import Base, Compiled, compile_world, write_options
from graph.sim.physics.mujoco.geoms import Shape
from graph.sim.physics.mujoco.library import mujoco, state_of
from graph.sim.physics.solver import SolverOptions
from graph.sim.physics.world_model import Volume, WorldModel
from graph.sim.scene.stage import Warn

if TYPE_CHECKING:
    from .scene import MjcfScene

_FRESH = ("geom", "joint", "equality", "mesh", "actuator", "flex")
_NOT_OF_DEFAULTS = frozenset(
    ("alt", "classname", "compiler", "frame", "id", "info", "name", "parent", "plugin", "signature", "userdata")
)
"""Attributes of an element in a tree, not of a default; reading some of them from a default ends the process."""
_NUMBERS = (bool, int, float, np.ndarray)


def compile_scene(
    scene: MjcfScene,
    world: WorldModel,
    dt: Fraction,
    options: SolverOptions,
    warn: Warn,
    volumes: dict[Shape, Volume] | None = None,
) -> Compiled:
    """The model of a scene with time step `dt` [s] and the additions of `world`.

    options: None keeps the model's own. volumes: see `measured`.
    """
    given = {body.path: body for body in world.given}
    bodies = tuple(given.get(body.path, body) for body in scene.bodies())
    if world.bodies or world.colliders or world.joints or world.grippers:
        base = Base(_grown(scene), bodies, scene.joints(), scene.start)
        compiled = compile_world(world, dt, options, warn, base, volumes)
    else:
        model = copy.copy(scene.model)
        model.opt.timestep = float(dt)
        write_options(model.opt, options)
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        kinematic = tuple(body.path for body in bodies if body.kinematic)
        compiled = Compiled(model, bodies, scene.joints(), kinematic, (), scene.start)
    _place_roots(scene, compiled.model)
    return replace(compiled, flexes=scene.flexes, geom_paths=_geom_paths(scene, compiled.model))


def _geom_paths(scene: MjcfScene, model: Any) -> dict[int, str]:
    """The prims of the scene's geoms by their numbers in a model; added bodies and geoms come after them."""
    own, paths = scene.model, dict[int, str]()
    for body in range(own.nbody):
        first, there = int(own.body_geomadr[body]), int(model.body_geomadr[body])
        paths |= {there + number: scene.paths.geoms[first + number] for number in range(int(own.body_geomnum[body]))}
    return paths


def _place_roots(scene: MjcfScene, model: Any) -> None:
    """Moves bodies to the places that users gave them, and derives again what MuJoCo derived from their places."""
    if not scene.moved:
        return
    for number, pose in scene.moved.items():
        body = model.body(scene.model.body(number).name).id
        model.body_pos[body], model.body_quat[body] = pose[:3, 3], transforms.quaternion(pose[:3, :3])
        joint = int(model.body_jntadr[body])
        if joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            first = int(model.jnt_qposadr[joint])
            model.qpos0[first : first + 3] = pose[:3, 3]
            model.qpos0[first + 3 : first + 7] = transforms.quaternion(pose[:3, :3])
    mujoco.mj_setConst(model, state_of(model))


def _grown(scene: MjcfScene) -> Any:
    """A copy of the specification to add to.

    Masses are as compiled, so that additions do not change them; the model's defaults are removed, so that they do not
    change additions.
    """
    spec, model = scene.spec.copy(), scene.model
    while spec.keys:
        spec.delete(spec.keys[0])
    fresh = mujoco.MjSpec()
    for kind in _FRESH:
        mine, plain = getattr(spec.default, kind), getattr(fresh.default, kind)
        for name in _numbers(plain):
            setattr(mine, name, getattr(plain, name))
    compiler = spec.compiler
    if compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE or compiler.settotalmass > 0:
        for body in spec.bodies[1:]:
            _fix_mass(body, model)
        compiler.inertiafromgeom, compiler.settotalmass = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE, -1
    compiler.boundmass = compiler.boundinertia = 0
    compiler.balanceinertia = True
    return spec


def _fix_mass(body: Any, model: Any) -> None:
    number = model.body(body.name).id
    body.explicitinertial = True
    body.mass, body.ipos, body.iquat = model.body_mass[number], model.body_ipos[number], model.body_iquat[number]
    body.inertia = model.body_inertia[number]
    body.fullinertia = np.full(6, np.nan)


def _numbers(element: Any) -> list[str]:
    """Names of an element's attributes that are numbers, arrays of numbers or choices."""
    out = []
    for name in dir(type(element)):
        if name.startswith("_") or name in _NOT_OF_DEFAULTS:
            continue
        value = getattr(element, name)
        if isinstance(value, _NUMBERS) or type(value).__module__ == "mujoco._enums":
            out.append(name)
    return out
