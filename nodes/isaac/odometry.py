"""Odometry of a robot's chassis: its motion since play, from the simulated truth."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.scene.mechanisms import mechanisms_of
from graph.sim.scene.prim_paths import prim_at
from graph.sim.settings import ODOMETRY_WORLD_TURN

from .poses import IDENTITY, ZERO

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(slots=True)
class _Start:
    """The body, its pose at the first compute, and the velocities (4, 3) and time of the previous one."""

    body: str = ""
    pose: NDArray[np.float64] | None = None
    velocities: NDArray[np.float64] | None = None
    time: Fraction = Fraction(0)


def _vector(doc: str, unit: str) -> Attribute:
    return Attribute("vectord[3]", doc, default=ZERO, unit=unit)


@node_type(
    "isaacsim.core.nodes.IsaacComputeOdometry",
    version=1,
    needs=(("chassisPrim",),),
    inputs={
        "execIn": Attribute("execution", "reads the chassis"),
        "chassisPrim": Attribute("target", "the chassis: a rigid body, or the root of an articulation (its root link)"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every reading"),
        "position": _vector("position in the frame that the chassis had at the first reading after play", "m"),
        "orientation": Attribute("quatd[4]", "orientation in that frame, quaternion x, y, z, w", default=IDENTITY),
        "linearVelocity": _vector("velocity along the chassis' axes", "m/s"),
        "angularVelocity": _vector("turn rate about the chassis' axes (the product's profile: the world's)", "rad/s"),
        "linearAcceleration": _vector("change of linearVelocity over simulation time", "m/s^2"),
        "angularAcceleration": _vector("change of angularVelocity over simulation time", "rad/s^2"),
        "globalLinearVelocity": _vector("velocity along the world's axes", "m/s"),
        "globalLinearAcceleration": _vector("change of globalLinearVelocity over simulation time", "m/s^2"),
    },
    memory=_Start,
)
def compute_odometry(db: Database) -> bool:
    """Read the chassis' motion.

    Accelerations are backward differences; without simulation time passed they keep their values.
    """
    app, memory = db.app, db.memory
    if app.timeline.is_stopped():
        return False
    if not memory.body:
        memory.body = _body(db)
    pose = app.fabric.rigid_matrices((memory.body,))[0]
    if memory.pose is None:
        memory.pose = pose
    motion = app.fabric.capture().velocities((memory.body,))[0]
    velocities = body_velocities(pose, motion, world_turn=bool(app.settings.get(ODOMETRY_WORLD_TURN)))
    from graph.sim.transforms import quaternion, to_xyzw

    outputs, turned = db.outputs, memory.pose[:3, :3].T
    outputs.position = turned @ (pose[:3, 3] - memory.pose[:3, 3])
    outputs.orientation = to_xyzw(quaternion(turned @ pose[:3, :3]))
    outputs.linearVelocity, outputs.angularVelocity, outputs.globalLinearVelocity = velocities
    time = app.simulation.time
    if memory.velocities is None:
        memory.velocities, memory.time = velocities, time
    elif time > memory.time:
        change = (velocities - memory.velocities) / float(time - memory.time)
        outputs.linearAcceleration, outputs.angularAcceleration, outputs.globalLinearAcceleration = change
        memory.velocities, memory.time = velocities, time
    db.fire("execOut")
    return True


def body_velocities(pose: NDArray[np.float64], motion: NDArray[np.float64], *, world_turn: bool) -> NDArray[np.float64]:
    """Rows: linear and angular velocity along the body's axes, and linear velocity along the world's.

    pose: (4, 4) rigid, column vectors; motion: (6,) linear [m/s] and angular [rad/s] along the world's axes.
    world_turn: whether the angular velocity stays along the world's axes.
    """
    import numpy as np

    turn = pose[:3, :3]
    return np.stack([motion[:3] @ turn, motion[3:] if world_turn else motion[3:] @ turn, motion[:3]])


def _body(db: Database) -> str:
    """The path of the rigid body of chassisPrim. Fails the node if it does not exist."""
    app, targets = db.app, db.inputs.chassisPrim
    if len(targets) != 1:
        db.lack(f"input chassisPrim names {len(targets)} prims; give it one prim path")
    if not prim_at(app.stage, targets[0]):
        db.lack(f"there is no prim {targets[0]} on the stage; correct the path")
    bodies = () if app.physics is None else app.physics.body_paths
    for link in mechanisms_of(app.stage).standing_for(targets[0]) or targets:
        if link in bodies:
            return str(link)
    db.lack(f"{targets[0]} is not a rigid body that can move; give chassisPrim a body or an articulation")
