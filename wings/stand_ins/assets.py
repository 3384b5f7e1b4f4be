"""Stand-ins for the most used assets of Isaac Sim: floors, rooms, a warehouse, blocks, and the robots of examples.

Joints have the names, axes and limits of the originals; shapes are boxes and capsules, and sizes of rooms are ours.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any

from graph.sim.scene.assets import StandIn
from graph.sim.scene.lamps import LAMP_RADIUS
from graph.sim.usd import Usd, UsdGeom

from .legged import MODELS as LEGGED
from .legged import quadruped
from .parts import add_box, ground, make_body
from .robots import (
    CARTER,
    CREATE,
    FORKLIFT,
    JACKAL,
    JETBOT,
    NOVA_CARTER,
    TURTLEBOT,
    ant,
    articulation,
    cartpole,
    coloured_ant,
    crazyflie,
    franka,
    three_joints,
    vehicle,
)
from .universal_robots import MODELS, universal_robot
from .ycb import SIZES, ycb

ROOM, ROOM_HEIGHT = (8.0, 8.0), 3.0
HALL, HALL_HEIGHT = (20.0, 30.0), 9.0


def stand_in(tail: str) -> StandIn | None:
    """The stand-in for an asset by its path from `/Isaac/` on."""
    for pattern, make, what in KNOWN:
        if re.search(pattern, tail, re.IGNORECASE):
            stage = Usd.Stage.CreateInMemory(f"{tail.rpartition('/')[2].partition('.')[0]}.usda")
            UsdGeom.SetStageMetersPerUnit(stage, 1.0)
            UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
            stage.SetDefaultPrim(make(stage))
            return StandIn.of(stage, what)
    return None


def _room(stage: Any) -> Any:
    root = ground(stage, ROOM_HEIGHT - 2 * LAMP_RADIUS)
    _walls(stage, ROOM, ROOM_HEIGHT)
    add_box(stage, "/World/table", (1.2, 0.8, 0.05), (0, 0, 0.725))
    for number, (x, y) in enumerate(((0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3))):
        add_box(stage, f"/World/table_leg_{number}", (0.05, 0.05, 0.7), (x, y, 0.35))
    return root


def _hall(stage: Any) -> Any:
    root = ground(stage, HALL_HEIGHT - 2 * LAMP_RADIUS)
    _walls(stage, HALL, HALL_HEIGHT)
    for row, x in enumerate((-7.5, -2.5, 2.5, 7.5)):
        for level in range(4):
            add_box(stage, f"/World/rack_{row}_shelf_{level}", (1.2, 20, 0.1), (x, 0, 0.3 + 1.8 * level))
        for side, y in enumerate((-10.0, 0.0, 10.0)):
            add_box(stage, f"/World/rack_{row}_post_{side}", (1.2, 0.1, 6.0), (x, y, 3.0))
    return root


def _walls(stage: Any, size: tuple[float, float], height: float) -> None:
    width, length = size
    for name, x, y in (("east", 1, 0), ("west", -1, 0), ("north", 0, 1), ("south", 0, -1)):
        shape = (0.1, length, height) if x else (width, 0.1, height)
        add_box(stage, f"/World/wall_{name}", shape, (x * width / 2, y * length / 2, height / 2))


def _block(stage: Any) -> Any:
    root = UsdGeom.Xform.Define(stage, "/Root").GetPrim()
    add_box(stage, "/Root/Cube", (0.05, 0.05, 0.05), (0, 0, 0))
    make_body(stage.GetPrimAtPath("/Root/Cube"), 0.1)
    return root


WHEELED, ARM_OF_9 = "a box on its two driven wheels", "an arm with its 9 joints, links as boxes"
ROBOTS = "/Robots(_Multiphysics)?"
KNOWN: tuple[tuple[str, Callable[[Any], Any], str], ...] = (
    (r"/Environments/Grid/", ground, "an endless ground plane"),
    (r"/Environments/Simple_Room/", _room, "a room of 8 x 8 m with a table"),
    (r"/Environments/Simple_Warehouse/", _hall, "a hall of 20 x 30 m with four racks"),
    (r"/Props/Blocks/", _block, "a cube of 5 cm"),
    (rf"{ROBOTS}/(FrankaRobotics/FrankaPanda|Franka)/(franka/)?franka[^/]*$", franka, ARM_OF_9),
    (r"/(FrankaRobotics/FrankaFR3|Franka/FR3)/fr3[^/]*$", partial(franka, name="fr3"), ARM_OF_9),
    *(
        (rf"/{name}/{name}\.usd$", partial(quadruped, name), "a box on four legs with their 12 joints, as capsules")
        for name in LEGGED
    ),
    *(
        (rf"/YCB/{folder}/{number}_[^/]*$", partial(ycb, number, solid), "a box of its size")
        for number in SIZES
        for folder, solid in (("Axis_Aligned_Physics", True), ("Axis_Aligned", False))
    ),
    *(
        (rf"/UniversalRobots/{name}/{name}[^/]*$", partial(universal_robot, name), "an arm with its 6 joints, as boxes")
        for name in MODELS
    ),
    (rf"{ROBOTS}/(NVIDIA/)?Jetbot/jetbot[^/]*$", partial(vehicle, JETBOT), WHEELED),
    (r"/(nova_carter[^/]*|carter_v2[^/]*)\.usda?$", partial(vehicle, NOVA_CARTER), WHEELED),
    (r"/Carter/carter_v1[^/]*\.usd$", partial(vehicle, CARTER), WHEELED),
    (r"/Turtlebot[^/]*/.*turtlebot3_burger[^/]*$", partial(vehicle, TURTLEBOT), WHEELED),
    (r"/iRobot/.*create_3[^/]*$", partial(vehicle, CREATE), WHEELED),
    (r"/Clearpath/Jackal/jackal[^/]*$", partial(vehicle, JACKAL), "a box on its four driven wheels"),
    (r"/Crazyflie/cf2x[^/]*$", crazyflie, "a box with four propellers that turn freely"),
    (r"/ForkliftC/forklift_c[^/]*$", partial(vehicle, FORKLIFT), "a box on four driven wheels, two of which steer"),
    (r"/SimpleArticulation/simple_articulation[^/]*$", articulation, "an arm on a fixed pivot, and a slider on it"),
    (r"/SimpleArticulation/articulation_3_joints[^/]*$", three_joints, "the arm and slider, and a second arm on it"),
    (rf"{ROBOTS}/IsaacSim/Cartpole/cartpole[^/]*$", cartpole, "a cart on a rail with a pole"),
    (r"/Ant/ant_colored[^/]*$", coloured_ant, "a ball on four legs of two links each, and a ground plane"),
    (rf"{ROBOTS}/IsaacSim/Ant/ant[^/]*$", ant, "a ball on four legs of two links each, with their 8 joints"),
)
"""Patterns of asset paths, what makes their stand-ins, and these in words."""
