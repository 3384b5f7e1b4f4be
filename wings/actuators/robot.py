"""Actuators on the joints of robots: read from prims `NewtonActuator`, and stepped before physics steps."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from graph.sim.attributes import applied_schemas
from graph.sim.scene.mechanisms import freedoms
from graph.sim.usd import Usd, UsdPhysics

from .laws import (
    Clamping,
    ClampingDCMotor,
    ClampingMaxEffort,
    ClampingPositionBased,
    Controller,
    ControllerPD,
    ControllerPID,
    Delay,
    Floats,
    Joint,
)

PRIM_TYPE = "NewtonActuator"
_DC = {"saturationEffort": "saturation_effort", "velocityLimit": "velocity_limit", "maxMotorEffort": "max_motor_effort"}
_PARTS: dict[str, tuple[Any, dict[str, str], dict[str, float]]] = {
    "NewtonPDControlAPI": (ControllerPD, {"constEffort": "const_effort"}, {"kp": 0.0, "kd": 0.0}),
    "NewtonPIDControlAPI": (
        ControllerPID,
        {"constEffort": "const_effort", "integralMax": "integral_max"},
        {"kp": 0.0, "ki": 0.0, "kd": 0.0},
    ),
    "NewtonMaxEffortClampingAPI": (ClampingMaxEffort, {"maxEffort": "max_effort"}, {}),
    "NewtonDCMotorClampingAPI": (ClampingDCMotor, _DC, {}),
    "NewtonPositionBasedClampingAPI": (
        ClampingPositionBased,
        {"lookupPositions": "lookup_positions", "lookupEfforts": "lookup_efforts"},
        {},
    ),
    "NewtonActuatorDelayAPI": (Delay, {"delaySteps": "delay_steps"}, {}),
}
"""By API schema: what it stands for, its attributes after `newton:` by parameter, and parameters with a default."""


class Actuator:
    """One joint of n robots alike: a delay, a controller, and limits in their order."""

    def __init__(
        self, controller: Controller, clamping: Sequence[Clamping] | None = None, delay: Delay | None = None
    ) -> None:
        self.controller, self.clamping, self.delay = controller, list(clamping or ()), delay
        self._memory: Any = None
        self._past: Any = None

    def reset(self, count: int) -> None:
        """Forgets integrals and delayed commands."""
        self._memory = self.controller.memory(count)
        self._past = None if self.delay is None else self.delay.memory(count)

    def step(self, joint: Joint, dt: float) -> Floats:
        """(n,) efforts of this step [N m or N]."""
        if self.delay is not None:
            joint = self.delay.delayed(joint, self._past)
        efforts = self.controller.efforts(joint, self._memory, dt)
        for each in self.clamping:
            efforts = each.limited(efforts, joint)
        return efforts


def actuator_of(prim: Any) -> Actuator:
    """The actuator that a prim describes by its API schemas. Raises ValueError if they make none."""
    controllers: list[Controller] = []
    limits: list[Clamping] = []
    delay = None
    for schema in map(str, applied_schemas(prim)):
        if schema == "NewtonNeuralControlAPI":
            raise NotImplementedError(f"{prim.GetPath()}: neural networks do not run here; use PD or PID control")
        if schema not in _PARTS:
            continue
        kind, renamed, defaults = _PARTS[schema]
        given = {name: _authored(prim, name) for name in defaults}
        given = {name: defaults[name] if value is None else value for name, value in given.items()}
        given |= {name: value for each, name in renamed.items() if (value := _authored(prim, each)) is not None}
        try:
            made = kind(**given)
        except TypeError:
            lacking = ", ".join(f"newton:{each}" for each, name in renamed.items() if name not in given)
            raise ValueError(f"{prim.GetPath()}: {schema} needs {lacking}") from None
        except ValueError as error:
            raise ValueError(f"{prim.GetPath()}: {error}") from None
        if isinstance(made, Controller):
            controllers.append(made)
        elif isinstance(made, Clamping):
            limits.append(made)
        else:
            delay = made
    if len(controllers) != 1:
        raise ValueError(f"{prim.GetPath()} has {len(controllers)} controllers; apply one, such as NewtonPDControlAPI")
    return Actuator(controllers[0], limits, delay)


def _authored(prim: Any, name: str) -> Any:
    attribute = prim.GetAttribute(f"newton:{name}")
    return attribute.Get() if attribute and attribute.HasAuthoredValue() else None


def actuator_prims(root: Any) -> list[Any]:
    """The prims of actuators below a robot's root; none for an invalid prim."""
    return [prim for prim in Usd.PrimRange(root) if prim.GetTypeName() == PRIM_TYPE] if root else []


def actuators_below(root: Any, joints: Sequence[str]) -> dict[int, Actuator]:
    """The actuators of the prims below a robot's root, by the numbers of their joints.

    joints: paths of the robot's joints. Raises ValueError for another target, and for two actuators of a joint.
    """
    found: dict[int, Actuator] = {}
    owners: dict[str, Any] = {}
    for prim in actuator_prims(root):
        relationship = prim.GetRelationship("newton:targets")
        targets = [str(path) for path in relationship.GetTargets()] if relationship else []
        if not targets:
            raise ValueError(f"{prim.GetPath()} has no newton:targets; name its joint, or deactivate the prim")
        if len(targets) > 1:
            warnings.warn(f"{prim.GetPath()} has {len(targets)} targets; only {targets[0]} is moved", stacklevel=2)
        if targets[0] not in joints:
            raise ValueError(f"{prim.GetPath()} targets {targets[0]}, which is not a joint of {root.GetPath()}")
        if targets[0] in owners:
            raise ValueError(f"{targets[0]} has two actuators: {owners[targets[0]]} and {prim.GetPath()}")
        owners[targets[0]] = prim.GetPath()
        found[joints.index(targets[0])] = actuator_of(prim)
    return dict(sorted(found.items()))


class Actuated:
    """Robots alike with actuators on some of their joints, by the joints' numbers."""

    def __init__(self, app: Any, roots: Sequence[str], actuators: Mapping[int, Actuator]) -> None:
        self.app, self.roots = app, list(roots)
        self.actuators = dict(sorted(actuators.items()))
        self._count = len(freedoms(app.stage, self.roots[0])) if self.roots else 0
        self._feedforward: Floats = np.zeros((len(self.roots), self._count))
        self.reset()

    @property
    def robots(self) -> list[Any]:
        """The articulations; none while physics does not play."""
        physics = self.app.physics
        return [] if physics is None else [physics.articulation(root) for root in self.roots]

    def feed(self, efforts: Any, robots: Sequence[int], joints: Sequence[int]) -> None:
        """Sets the efforts of some joints of some robots that are added to those of the controllers [N m or N]."""
        self._feedforward[np.ix_(robots, joints)] = efforts

    def reset(self) -> None:
        """Forgets integrals and delayed commands."""
        for actuator in self.actuators.values():
            actuator.reset(len(self.roots))

    def release_drives(self) -> None:
        """Takes stiffness and damping from the drives of the joints: only their actuators move them."""
        stage = self.app.stage
        drives = [drive for root in self.roots for drive in _drives(stage, root, self.actuators)]
        if any(attribute.Get() for drive in drives for attribute in drive):
            with self.app.edit(when_playing="recompile"):
                for drive in drives:
                    for attribute in drive:
                        attribute.Set(0.0)

    def step(self, dt: float) -> None:
        """Computes the efforts of all actuators from the present state, and applies them."""
        robots = self.robots
        if not robots or not self.actuators:
            return
        names = ("positions", "velocities")
        seen = [np.array([getattr(robot, name) for robot in robots]) for name in names]
        seen += [np.array([robot.commanded(name) for robot in robots]) for name in names]
        seen.append(self._feedforward)
        efforts = np.array(
            [
                np.broadcast_to(actuator.step(Joint(*(each[:, number] for each in seen)), dt), len(robots))
                for number, actuator in self.actuators.items()
            ]
        )
        for row, robot in enumerate(robots):
            robot.set_targets(efforts=efforts[:, row], joints=list(self.actuators))


def _drives(stage: Any, root: str, numbers: Mapping[int, Any]) -> Iterator[list[Any]]:
    """The gains of the drives of the joints with these numbers."""
    for path in [freedoms(stage, root)[number] for number in numbers]:
        prim = stage.GetPrimAtPath(path)
        api = UsdPhysics.DriveAPI(prim, "linear" if prim.IsA(UsdPhysics.PrismaticJoint) else "angular")
        yield [attribute for attribute in (api.GetStiffnessAttr(), api.GetDampingAttr()) if attribute]
