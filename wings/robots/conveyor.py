"""Conveyor belts: a rigid body whose surface moves."""

from __future__ import annotations

from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at


@dataclass(slots=True)
class _Belt:
    """The last settings: prim, motion along its axes, whether it rotates; whether the texture warning was given."""

    set: tuple[str, tuple[float, ...], bool] | None = None
    told: bool = False


@node_type(
    "isaacsim.asset.gen.conveyor.IsaacConveyor",
    version=1,
    needs=(("conveyorPrim",),),
    inputs={
        "enabled": Attribute("bool", "if not, the node leaves the belt as it is", default=True),
        "conveyorPrim": Attribute("target", "a rigid body with colliders; a kinematic one stays where it is"),
        "velocity": Attribute(
            "float", "speed of the surface; of a curved belt its turn rate", default=0.0, unit="stage units/s or deg/s"
        ),
        "direction": Attribute(
            "float[3]",
            "where the surface moves, along the prim's axes; of a curved belt the axis that it turns about",
            default=[1.0, 0.0, 0.0],
        ),
        "curved": Attribute("bool", "the surface turns about the prim's origin", default=False),
        "animateTexture": Attribute("bool", "move the texture too: not drawn here, so only warned of", default=False),
        "animateScale": Attribute("float", "factor of the texture's motion", default=1.0),
        "animateDirection": Attribute("float[2]", "direction of the texture's motion", default=[1.0, 0.0]),
        "onStep": Attribute("execution", "sets the motion of the surface"),
        "delta": Attribute("float", "time step, for the texture", unit="s"),
    },
    memory=_Belt,
)
def conveyor(db: Database) -> bool:
    """Give a body's surface the velocity direction x velocity; friction carries what lies on it."""
    inputs, memory, app = db.inputs, db.memory, db.app
    if not inputs.enabled or app.timeline.is_stopped():
        return False
    if len(inputs.conveyorPrim) != 1:
        db.lack(f"input conveyorPrim names {len(inputs.conveyorPrim)} prims; give it the path of one rigid body")
    if inputs.animateTexture and not memory.told:
        memory.told = True
        db.warn("texture-not-animated", "the belt moves, its texture does not: textures are not drawn")
    path = str(inputs.conveyorPrim[0])
    motion = tuple(float(part) * inputs.velocity for part in inputs.direction)
    wanted = (path, motion, bool(inputs.curved))
    if wanted != memory.set:
        _set(db, path, motion, inputs.curved)
        memory.set = wanted
    return True


def _set(db: Database, path: str, motion: tuple[float, ...], curved: bool) -> None:
    import numpy as np

    from graph.sim.usd import Gf, UsdPhysics

    app = db.app
    prim = prim_at(app.stage, path)
    if not prim or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
        db.fail(f"{path} is not a rigid body; give it a RigidBodyAPI, kinematic for a belt that stays")
    _author(prim, *((Gf.Vec3f(0), Gf.Vec3f(*motion)) if curved else (Gf.Vec3f(*motion), Gf.Vec3f(0))))
    if app.physics is None:  # physics is not playing, so nothing is carried
        return
    still, vector = np.zeros(3), np.array(motion)
    velocity, turn = (still, np.radians(vector)) if curved else (vector * app.meters_per_unit, still)
    try:
        changed = app.physics.set_surface_velocity(path, app.fabric.rigid_matrices((path,))[0], velocity, turn)
    except ValueError as error:
        db.fail(f"{error}; give the belt a collider")
    if changed:
        db.warn("belt-integrator", "physics.integrator is implicitfast from now on: discrete cannot move surfaces")


def _author(prim: Any, velocity: Any, turn: Any) -> None:
    """Writes what the belt does on its prim, as Isaac Sim's node does; the stop takes it back."""
    from graph.sim.usd import Sdf

    with Sdf.ChangeBlock():
        prim.AddAppliedSchema("PhysxSurfaceVelocityAPI")
        for name, value in (("surfaceVelocity", velocity), ("surfaceAngularVelocity", turn)):
            prim.CreateAttribute(f"physxSurfaceVelocity:{name}", Sdf.ValueTypeNames.Vector3f).Set(value)
