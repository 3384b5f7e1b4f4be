"""Physics attributes that take effect while playing: targets of drives, velocities of free bodies, forces, belts, the
gravity and the rate of the physics scene.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.scene_attributes import RATE_ATTRIBUTES, scene_prims
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdPhysics

if TYPE_CHECKING:
    from graph.sim.state.playing_world import PlayingWorld
    from graph.sim.state.tensors import Tensors

_TARGETS = {"physics:targetPosition": "positions", "physics:targetVelocity": "velocities"}
_GRAVITY = ("physics:gravityDirection", "physics:gravityMagnitude", "newton:gravityEnabled")
_VELOCITIES = ("physics:velocity", "physics:angularVelocity")


def apply_live(world: PlayingWorld, tensors: Tensors, path: str, name: str) -> bool:
    """Applies a new value of a prim's attribute to the running physics; False if that is not possible."""
    prim = world.stage.GetPrimAtPath(path)
    if prim and prim.IsA(UsdPhysics.Scene):
        return _scene(world, prim, name)
    try:
        if name in _VELOCITIES:
            return _velocity(world, path)
        if name.startswith(("physxForce:", "physxSurfaceVelocity:")):
            return _force(world, path) if name.startswith("physxForce:") else _surface(world, path)
        if name.startswith("drive:"):
            _, axis, attribute = name.split(":", 2)
            return attribute in _TARGETS and _target(world, tensors, path, axis, _TARGETS[attribute], name)
    except RunError:  # no such joint, or a body that is held
        return False
    return False


def _scene(world: PlayingWorld, scene: Any, name: str) -> bool:
    """The gravity and the rate of the active scene; of another one nothing counts, now or later."""
    from graph.sim.physics.read_world import gravity_of
    from graph.sim.scene.physics_settings import SIMULATED

    if name not in SIMULATED or next(scene_prims(world.stage), None) != scene:
        return True
    if name in _GRAVITY and world.physics is not None:
        world.physics.set_gravity(gravity_of(scene, world.meters_per_unit, world.warn))
    elif name in RATE_ATTRIBUTES:
        world.take_rate()
    return name in _GRAVITY or name in RATE_ATTRIBUTES


def _target(world: PlayingWorld, tensors: Tensors, path: str, axis: str, what: str, name: str) -> bool:
    """The target of a drive: angular drives are authored in degrees, linear ones in stage units."""
    joint = path if path in tensors.joint_paths else f"{path}:{axis}"
    value = float(world.stage.GetPrimAtPath(path).GetAttribute(name).Get(EARLIEST))
    unit = np.pi / 180 if axis == "angular" or axis.startswith("rot") else world.meters_per_unit
    tensors.set_joint_targets(**{what: [value * unit]}, joints=[joint])
    return True


def _velocity(world: PlayingWorld, path: str) -> bool:
    """Both velocities, of the centre of mass, in the space in which the prim has them: its parent's."""
    physics = world.physics
    if physics is None or path not in physics.body_paths:
        return False
    prim = world.stage.GetPrimAtPath(path)
    body = UsdPhysics.RigidBodyAPI(prim)
    turn = _parent_rotation(prim)
    linear = turn @ _vector(body.GetVelocityAttr()) * world.meters_per_unit
    angular = turn @ np.radians(_vector(body.GetAngularVelocityAttr()))
    row = physics.body_paths.index(path)
    arm = physics.centers_of_mass[row] - physics.positions[row]
    physics.set_velocities((path,), np.concatenate([linear - np.cross(angular, arm), angular])[None])
    world.fabric.touched()
    return True


def _force(world: PlayingWorld, path: str) -> bool:
    from graph.sim.physics.read_forces import force_of

    physics = world.physics
    if physics is None or path not in physics.body_paths or path in physics.kinematic:
        return False
    others = [force for force in physics.world.forces if force.path != path]
    force = force_of(world.stage.GetPrimAtPath(path), world.warn)
    physics.set_authored_forces([*others, *([force] if force else [])])
    return True


def _surface(world: PlayingWorld, path: str) -> bool:
    from graph.sim.physics.read_forces import surface_of

    physics = world.physics
    if physics is None or path not in physics.body_paths:
        return False
    row = physics.body_paths.index(path)
    pose = transforms.rigid(physics.rotations[row], physics.positions[row])
    surface = surface_of(world.stage.GetPrimAtPath(path), pose, world.warn)
    if surface is None:
        return False
    physics.set_surface_velocity(path, pose, surface.velocity, surface.turn)
    return True


def _vector(attribute: Any) -> Floats:
    value = attribute.Get(EARLIEST)
    return np.zeros(3) if value is None else np.array(value, dtype=np.float64)


def _parent_rotation(prim: Any) -> Floats:
    parent = prim.GetParent()
    if parent.IsPseudoRoot() or UsdGeom.Xformable(prim).GetResetXformStack():
        return np.eye(3)
    world = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(parent))
    return transforms.rigid_part(world)[:3, :3]
