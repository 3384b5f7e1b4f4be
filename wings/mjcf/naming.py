"""The prim path of each element of a model."""

from __future__ import annotations

import re
from typing import Any

from graph.base.records import dataclass
from graph.sim.physics.mujoco.library import mujoco

ROOT = "/World"
ACTUATORS, SENSORS, LOOKS = "Actuators", "Sensors", "Looks"


def identifier(name: str) -> str:
    """A valid prim name: letters, digits and _."""
    out = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{out}" if not out or out[0].isdigit() else out


@dataclass(frozen=True)
class Paths:
    """Prim paths by number in the model; "" for an element without a prim (the world body, free joints)."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    geoms: tuple[str, ...]
    sites: tuple[str, ...]
    cameras: tuple[str, ...]
    actuators: tuple[str, ...]
    sensors: tuple[str, ...]
    materials: tuple[str, ...]
    flexes: tuple[str, ...]
    lights: tuple[str, ...]
    scene: str
    headlight: str
    welds: dict[int, str]
    """Joints that fix bodies without a joint to their parent bodies, by the number of the body."""
    points: frozenset[int]
    """Bodies that are only points of a soft part; they have no prims."""


def prim_paths(model: Any) -> Paths:
    """Paths: bodies are siblings below /World, their elements below them, elements of the world below /World.

    Names are those of the model as far as they are valid for prims. If two elements have one name, bodies come before
    joints, geoms, sites, cameras and lights in this order; a later one gets _1, _2 ... at the end.
    """
    taken: set[str] = {ROOT}

    def place(parent: str, name: str) -> str:
        path = base = f"{parent}/{identifier(name)}"
        number = 0
        while path in taken:
            number += 1
            path = f"{base}_{number}"
        taken.add(path)
        return path

    bodies = ("", *(place(ROOT, model.body(number).name) for number in range(1, model.nbody)))
    groups = (ACTUATORS, model.nu), (SENSORS, model.nsensor), (LOOKS, model.nmat)
    actuators, sensors, looks = (place(ROOT, name) if count else "" for name, count in groups)
    below = [ROOT, *bodies[1:]]
    free = int(mujoco.mjtJoint.mjJNT_FREE)
    points = _points(model)

    def placed(parents: Any, named: Any) -> tuple[str, ...]:
        """The prims of elements whose bodies have these numbers."""
        return tuple(place(below[body], named(number).name) for number, body in enumerate(parents))

    def members(parent: str, named: Any, count: int) -> tuple[str, ...]:
        return tuple(place(parent, named(number).name) for number in range(count))

    fixed = (n for n in range(1, model.nbody) if model.body_parentid[n] and not model.body_jntnum[n])
    return Paths(  # in the order in which names are taken
        bodies=bodies,
        joints=tuple(
            "" if kind == free or int(body) in points else place(below[body], model.joint(number).name)
            for number, (kind, body) in enumerate(zip(model.jnt_type, model.jnt_bodyid, strict=True))
        ),
        geoms=placed(model.geom_bodyid, model.geom),
        sites=placed(model.site_bodyid, model.site),
        cameras=placed(model.cam_bodyid, model.camera),
        actuators=members(actuators, model.actuator, model.nu),
        sensors=members(sensors, model.sensor, model.nsensor),
        materials=members(looks, model.material, model.nmat),
        flexes=tuple(place(ROOT, flex_name(model, number)) for number in range(model.nflex)),
        scene=place(ROOT, "PhysicsScene"),
        lights=placed(model.light_bodyid, model.light),
        headlight=place(ROOT, "Headlight"),
        welds={n: place(bodies[n], f"{model.body(n).name}_weld") for n in fixed if n not in points},
        points=points,
    )


def flex_name(model: Any, number: int) -> str:
    """What a flex is called."""
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_FLEX, number) or f"flex{number}"


def _points(model: Any) -> frozenset[int]:
    if not model.nflex:
        return frozenset()
    soft = {int(body) for bodies in (model.flex_vertbodyid, model.flex_nodebodyid) for body in bodies}
    owners = model.geom_bodyid, model.site_bodyid, model.cam_bodyid, model.light_bodyid
    carrying = {int(body) for bodies in owners for body in bodies}
    return frozenset(soft - carrying - {0, -1})
