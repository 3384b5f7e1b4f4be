"""Bodies far away, tiny, huge, slow, fast, light, heavy, stiff and spinning."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from graph.cli.extreme_cases import (
    GRAVITY,
    GROUND,
    OFFSETS,
    WEIGHTLESS,
    Case,
    alone,
    body,
    fall,
    playing,
    rest,
    worst,
)
from graph.sim import App
from graph.sim.usd import Gf
from tests.stability.extremes.worlds import mesh, told, unplayable

AREA = "bodies"
REST = 2e-5
"""A box at rest sinks 10 micrometres into the ground, whatever its mass; twice that is allowed [m]."""


def at_rest_on_mesh(offset: float) -> float:
    """A box on a block of 10 m that is a mesh, both at an offset whose sum with 0.3 no float32 is."""
    place = np.array([offset, offset, offset + 0.3])
    corners = 5.0 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    block = mesh(corners, faces, translate=[float(one) for one in place - [0, 0, 5.25]])
    return rest({"/Block": block, "/Box": body(0.5, place)}, place)


def by_step(hz: int) -> float:
    """The sinking as a share of g T^2, T half the time constant of contact: 10 ms, or a step if that is longer."""
    return alone(hz=hz, seconds=min(2.0, 20_000 / hz)) / (GRAVITY * max(0.01, 1 / hz) ** 2)


def pair(lower: float, upper: float) -> dict[str, Any]:
    """Two boxes, one on the other, of these masses [kg]."""
    boxes = {"/A": body(0.5, (0, 0, 0.25), mass=lower), "/B": body(0.5, (0, 0, 0.75), mass=upper)}
    return {**GROUND, **boxes}


def heavy_on_light(ratio: float) -> float:
    """How far the upper box sinks, divided by the ratio of the masses [m]."""
    return rest(pair(1.0, ratio), [[0, 0, 0.25], [0, 0, 0.75]]) / ratio


def light_on_heavy(ratio: float) -> float:
    """How far one of them moves [m]."""
    return rest(pair(ratio, 1.0), [[0, 0, 0.25], [0, 0, 0.75]])


def sinking(ratio: float) -> str:
    """The warning of a box on one that is too light to carry it."""
    with playing(pair(1.0, ratio), 60) as app:
        app.update(130)
        return told(app.warnings, "bodies-sink")


def explicit(integrator: str) -> str:
    """The warning of a stiff drive that an explicit integrator cannot hold."""
    with playing(drive(1e6), 60, physics_integrator=integrator) as app:
        return told(app.warnings, "drive-unstable")


def tumbling(degrees: float) -> str:
    """The warning of a body of three inertias."""
    inertia = {"physics:diagonalInertia": [1 / 128, 1 / 64, 3 / 128]}
    keys = {"angular_velocity": [0.1 * degrees, degrees, 0.1 * degrees], "attributes": inertia}
    with playing(spinning(0.0, **keys)) as app:
        app.update()
        return told(app.warnings, "spin-too-fast")


def orientation(length: float) -> float:
    """A quarter turn about z, authored as a quaternion of this length: how far the body's quaternion is from it."""
    with playing({**WEIGHTLESS, "/Box": body(0.5, (0, 0, 0), orient=[length, 0, 0, length])}) as app:
        return worst(app.simulation.tensors.orientations[0], np.array([1, 0, 0, 1]) / math.sqrt(2))


def turned_later(timeline: str) -> float:
    """A quarter turn about z as a quaternion of length 2.8 that is set on the stage: how far the body's is from it."""
    with App(physics_hz=60, loop_hz=60) as app:
        app.add_prims({**WEIGHTLESS, "/Box": body(0.5, (0, 0, 0), orient=[1, 0, 0, 0])})
        if timeline == "playing":
            app.play()
            app.update()
        app.stage.GetAttributeAtPath("/Box.xformOp:orient").Set(Gf.Quatd(2, 0, 0, 2))
        if timeline == "stopped":
            app.play()
        app.update()
        return worst(app.simulation.tensors.orientations[0], np.array([1, 0, 0, 1]) / math.sqrt(2))


def reread(turn: str) -> str:
    """The warning about a scene's quaternion that USD takes for another rotation than it says."""
    text = (
        '#usda 1.0\n(metersPerUnit = 1\n upAxis = "Z")\n'
        f'def Cube "Box" {{\n quatd xformOp:orient = {turn}\n'
        ' uniform token[] xformOpOrder = ["xformOp:orient"]\n}\n'
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.usda"
        file.write_text(text, encoding="utf8")
        with App(file) as app:
            return told(app.warnings, "orient-not-unit")


def shell(turned_out: bool) -> float:
    """The mass of a cube of 0.5 m and 1,000 kg/m3 that is a mesh, whichever way its faces turn: relative error."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.5
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = faces if turned_out else [face[::-1] for face in faces]
    keys = {"type": "Mesh", "points": corners.tolist(), "faces": faces, "rigid_body": True}
    with playing({**WEIGHTLESS, "/Shell": keys}) as app:
        assert app.physics is not None
        return abs(float(app.physics.masses[0]) / 125 - 1)


def unweighable(size: float) -> str:
    """The line about a cube of this size and 1,000 kg/m3."""
    return unplayable({"/Box": body(size, (0, 0, 0))})


def drive(stiffness: float, integrator: str = "implicitfast") -> dict[str, Any]:
    """A mass of 1 kg on a rail with a critically damped drive to 1 m."""
    gains = {"stiffness": stiffness, "damping": 2 * math.sqrt(stiffness), "targetPosition": 1.0}
    ends = {"physics:body1": "/Mass", "physics:axis": "X"}
    attributes = {**ends, **{f"drive:linear:physics:{name}": value for name, value in gains.items()}}
    rail = {"type": "PhysicsPrismaticJoint", "schemas": "PhysicsDriveAPI:linear", "attributes": attributes}
    return {**WEIGHTLESS, "/Mass": body(0.1, (0, 0, 0), mass=1.0), "/Rail": rail}


def holds(stiffness: float) -> float:
    """How far a drive is from its target after 2 s at 60 Hz [m]."""
    with playing(drive(stiffness), 60) as app:
        app.update(120)
        return abs(float(app.simulation.tensors.positions[0, 0]) - 1)


def spinning(degrees: float, **keys: Any) -> dict[str, Any]:
    """A ball that spins about z, float32 [deg/s]."""
    ball = {"type": "Sphere", "radius": 0.1, "rigid_body": True, "mass": 1.0, "angular_velocity": [0, 0, degrees]}
    return {**WEIGHTLESS, "/Ball": {**ball, **keys}}


def turned(degrees: float) -> float:
    """How far a ball's angle is from w t after 1 s at 240 Hz [rad]."""
    with playing(spinning(degrees)) as app:
        app.update(60)
        w, _, _, z = app.simulation.tensors.orientations[0]
        return abs(math.remainder(2 * math.atan2(z, w) - math.radians(degrees), 2 * math.pi))


def no_rotation(value: float) -> str:
    """The line about a quaternion without direction."""
    return unplayable({"/Box": body(0.5, (0, 0, 0), orient=[value] * 4)})


RATES = (1, 10, 60, 1000, 100_000)
MASSES = tuple(10.0**power for power in (-6, -3, 0, 3, 6, 9))

CASES = (
    Case(AREA, "a drive of 1e3 to 1e12 N/m on 1 kg at 60 Hz", 1e-9, "m", "drives are implicit", holds,
         (1e3, 1e6, 1e9, 1e12)),
    Case(AREA, "a ball at 10 to 1e4 rad/s, 240 steps", 1e-6, "rad", "its rate is exact in float32, its turn exact",
         turned, (573.0, 57_300.0, 573_000.0)),
    Case(AREA, "a quaternion of zeros", "is not a rotation", "", "it has no direction", no_rotation, (0.0,)),
    Case(AREA, "a box on a mesh, 0 to 1e8 m from the origin", REST, "m", "meshes are centred before they are float32",
         at_rest_on_mesh, OFFSETS),
    Case(AREA, "a fall where a unit is 1e-6 to 1e6 m", 1e-9, "m", "positions are float64",
         lambda metre: fall(240, [0, 0, 100], metre), (1e-6, 1e-3, 1.0, 1e3, 1e6)),
    Case(AREA, "boxes of 1e-2 to 1e2 m at rest", REST, "m", "sinking depends on gravity alone",
         lambda size: alone(size=size), (1e-2, 1.0, 1e2)),
    Case(AREA, "a box of 1e-4 m, 1,000 kg/m3", "is too little for the engine", "", "MuJoCo ignores less than 1e-15",
         unweighable, (1e-4,)),
    Case(AREA, "boxes of 1e4 to 1e6 m, 1,000 kg/m3", "is too much for the engine", "", "its squares overflow",
         unweighable, (1e4, 1e6)),
    Case(AREA, "20 steps of a fall at 1 Hz to 100 kHz", 1e-9, "m", "exact for the method, g dt^2 n (n + 1) / 2",
         lambda hz: fall(hz, [0, 0, 0], steps=20), RATES),
    Case(AREA, "a box at rest at 1 Hz to 100 kHz", 0.011, "g T^2", "stiffness of contact; T is a step, at least 10 ms",
         by_step, RATES),
    Case(AREA, "1 kg on 1 to 1e6 kg", 5e-3, "m", "the pair settles as equal boxes do", light_on_heavy,
         (1.0, 1e3, 1e6)),
    Case(AREA, "1 to 1e3 kg on 1 kg, over the ratio", 4e-5, "m", "a load presses in proportion to it: 10 mm at 1e3",
         heavy_on_light, (1.0, 10.0, 100.0, 1000.0)),
    Case(AREA, "1e4 to 1e6 kg on 1 kg", "times its mass", "", "contact is scaled by the lighter body; warning",
         sinking, (1e4, 1e6)),
    Case(AREA, "a drive of 1e6 N/m, rk4 or euler", "integrates drives explicitly", "", "no explicit step is stable",
         explicit, ("rk4", "euler")),
    Case(AREA, "a tumble at 1e4 rad/s, 240 Hz", "spin-too-fast", "", "41 rad a step", tumbling, (573_000.0,)),
    Case(AREA, "quaternions of length 1e-30 to 1e200", 1e-12, "", "normalised when they are read", orientation,
         (1e-30, 1e-6, 1.0, 1e6, 1e200)),
    Case(AREA, "a scene's quaternion of length 2.8, 0, NaN", "orient-not-unit", "",
         "normalised; USD would take it for another turn", reread, ("(2, 0, 0, 2)", "(0, 0, 0, 0)", "(nan, 0, 0, 0)")),
    Case(AREA, "a quaternion of length 2.8, set before and while playing", 1e-12, "", "normalised when it is set",
         turned_later, ("stopped", "playing")),
    Case(AREA, "a closed mesh, also inside out", 1e-6, "", "its volume has no sign", shell, (True, False)),
)  # fmt: skip
