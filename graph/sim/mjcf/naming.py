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

    bodies = [""]
    bodies += [place(ROOT, model.body(number).name) for number in range(1, model.nbody)]
    groups = [place(ROOT, name) if count else "" for name, count in _groups(model)]
    below = [ROOT, *bodies[1:]]
    free = int(mujoco.mjtJoint.mjJNT_FREE)
    points = _points(model)
    joints = [
        ""
        if model.jnt_type[number] == free or int(model.jnt_bodyid[number]) in points
        else place(below[model.jnt_bodyid[number]], model.joint(number).name)
        for number in range(model.njnt)
    ]
    geoms = [place(below[model.geom_bodyid[number]], model.geom(number).name) for number in range(model.ngeom)]
    sites = [place(below[model.site_bodyid[number]], model.site(number).name) for number in range(model.nsite)]
    cameras = [place(below[model.cam_bodyid[number]], model.camera(number).name) for number in range(model.ncam)]
    parts = (
        tuple(place(groups[0], model.actuator(number).name) for number in range(model.nu)),
        tuple(place(groups[1], model.sensor(number).name) for number in range(model.nsensor)),
        tuple(place(groups[2], model.material(number).name) for number in range(model.nmat)),
        tuple(place(ROOT, flex_name(model, number)) for number in range(model.nflex)),
    )
    scene = place(ROOT, "PhysicsScene")
    lights = tuple(place(below[model.light_bodyid[number]], model.light(number).name) for number in range(model.nlight))
    headlight = place(ROOT, "Headlight")
    fixed = [
        number for number in range(1, model.nbody) if model.body_parentid[number] and not model.body_jntnum[number]
    ]
    welds = {
        number: place(bodies[number], f"{model.body(number).name}_weld") for number in fixed if number not in points
    }
    return Paths(
        tuple(bodies),
        tuple(joints),
        tuple(geoms),
        tuple(sites),
        tuple(cameras),
        *parts,
        lights,
        scene,
        headlight,
        welds,
        points,
    )


def flex_name(model: Any, number: int) -> str:
    """What a flex is called."""
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_FLEX, number) or f"flex{number}"


def _groups(model: Any) -> tuple[tuple[str, int], ...]:
    return (ACTUATORS, model.nu), (SENSORS, model.nsensor), (LOOKS, model.nmat)


def _points(model: Any) -> frozenset[int]:
    if not model.nflex:
        return frozenset()
    soft = {int(body) for bodies in (model.flex_vertbodyid, model.flex_nodebodyid) for body in bodies}
    owners = model.geom_bodyid, model.site_bodyid, model.cam_bodyid, model.light_bodyid
    carrying = {int(body) for bodies in owners for body in bodies}
    return frozenset(soft - carrying - {0, -1})
