"""Inertial measurement units: the readings of a prim on a moving body, from the bodies' velocities at physics steps."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView

LONGEST = 1000
"""Most physics steps over which a reading can be averaged."""


@dataclass(frozen=True, slots=True)
class InertialReading:
    """Time [s]; acceleration [m/s2] and angular velocity [rad/s] along the sensor's axes; orientation x, y, z, w."""

    time: float
    acceleration: Floats
    angular_velocity: Floats
    orientation: Floats


class _Sample(NamedTuple):
    """One physics step, sensor axes: acceleration without gravity, gravity, angular velocity; orientation w, x, y,
    z.
    """

    time: Fraction
    acceleration: Floats
    weight: Floats
    angular_velocity: Floats
    orientation: Floats


class InertialUnit:
    """Follows a prim on a rigid body, step by step, from its creation until `close`.

    The acceleration of a step is the change of the prim's velocity in it, which is what the engine's integrator
    computed. widths: over how many steps acceleration, angular velocity and orientation are each averaged. Raises
    RunError if the prim is not on a rigid body.
    """

    def __init__(self, scene: WorldView, path: str, widths: tuple[int, int, int] = (1, 1, 1)) -> None:
        self._scene = scene
        self._path = path
        self._body = body_of(scene, path)
        self._gravity = gravity_of(scene)
        self._samples: deque[_Sample] = deque()
        self.average_over(widths)
        self._velocity, _, _ = self._motion()
        self._time = scene.times.time
        self.close = scene.on("physics_post_step", self._step)
        """Ends the following."""

    def average_over(self, widths: tuple[int, int, int]) -> None:
        """Sets over how many steps acceleration, angular velocity and orientation are each averaged from now on."""
        self._widths = [min(max(width, 1), LONGEST) for width in widths]
        if max(self._widths) != self._samples.maxlen:
            self._samples = deque(self._samples, maxlen=max(self._widths))

    def reading(self, gravity: bool = True) -> InertialReading | None:
        """The newest reading; at rest its acceleration is 9.81 m/s2 up, or 0 without gravity. None before a step."""
        if self._scene.times.time > self._time:  # within a step, before our own subscriber
            self._step()
        if not self._samples:
            return None
        felt, turned, stood = (list(self._samples)[-width:] for width in self._widths)
        acceleration = np.mean([one.acceleration - one.weight if gravity else one.acceleration for one in felt], axis=0)
        rate = np.mean([one.angular_velocity for one in turned], axis=0)
        w, x, y, z = mean_quaternion(np.array([one.orientation for one in stood]))
        return InertialReading(float(self._samples[-1].time), acceleration, rate, np.array([x, y, z, w]))

    def _step(self) -> None:
        if not self._scene.stage.GetPrimAtPath(self._path):  # removed while it plays
            self.close()
            self._samples.clear()
            return
        velocity, rate, rotation = self._motion()
        time = self._scene.times.time
        if time > self._time:
            change = (velocity - self._velocity) / float(time - self._time)
            orientation = transforms.quaternion(rotation)
            sample = _Sample(time, change @ rotation, self._gravity @ rotation, rate @ rotation, orientation)
            self._samples.append(sample)
        self._velocity, self._time = velocity, time

    def _motion(self) -> tuple[Floats, Floats, Floats]:
        """Velocity and angular velocity of the prim along world axes, and its rotation."""
        fabric = self._scene.fabric
        pose = fabric.rigid_matrices((self._path,))[0]
        if self._body is None:
            return np.zeros(3), np.zeros(3), pose[:3, :3]
        motion = fabric.velocities((self._body,))[0]
        arm = pose[:3, 3] - fabric.rigid_matrices((self._body,))[0][:3, 3]
        return motion[:3] + np.cross(motion[3:], arm), motion[3:], pose[:3, :3]


def mean_quaternion(quaternions: Floats) -> Floats:
    """(4,) mean of (n, 4) unit quaternions close to each other; q and -q count as the same."""
    signs = np.where(quaternions @ quaternions[-1] < 0, -1.0, 1.0)
    total = (quaternions * signs[:, None]).sum(axis=0)
    out: Floats = total / np.linalg.norm(total)
    return out


def body_of(scene: WorldView, path: str) -> str | None:
    """The moving body of a prim; None if its body cannot move. Raises RunError if it is not on a rigid body."""
    from graph.sim.usd import UsdPhysics

    prim = scene.stage.GetPrimAtPath(path) if path.startswith("/") else None
    if not prim:
        raise RunError(f"{path}: no such prim on the stage")
    while prim and not prim.IsPseudoRoot():
        if scene.fabric.is_body(str(prim.GetPath())):
            return str(prim.GetPath())
        if prim.HasAPI(UsdPhysics.RigidBodyAPI):
            return None
        prim = prim.GetParent()
    raise RunError(f"{path}: it is on no rigid body; put it on one, or below")


def may_be_on_body(prim: Any) -> bool:
    """Whether a prim is on a rigid body, or below a prim whose transform is animated, as far as the stage shows it."""
    from graph.sim.usd import UsdGeom, UsdPhysics

    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(UsdPhysics.RigidBodyAPI) or UsdGeom.Xformable(prim).TransformMightBeTimeVarying():
            return True
        prim = prim.GetParent()
    return False


def gravity_of(scene: WorldView) -> Floats:
    """Gravity, (3,) [m/s2], world axes."""
    if scene.physics is not None:
        return scene.physics.gravity
    from graph.sim.physics.read_world import read_gravity
    from graph.sim.scene.scan import scan_stage

    return read_gravity(scan_stage(scene.stage))


def attribute_of(prim: Any, name: str, default: Any) -> Any:
    """A sensor prim's attribute; the default if the prim does not have it or it is unset."""
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if attribute else None
    return default if value is None else value


def widths_of(prim: Any) -> tuple[int, int, int]:
    """The widths of an IsaacImuSensor prim's rolling averages [physics steps]."""
    names = ("linearAcceleration", "angularVelocity", "orientation")
    first, second, third = (int(attribute_of(prim, f"{name}FilterWidth", 1)) for name in names)
    return first, second, third
