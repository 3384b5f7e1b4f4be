"""`isaacsim.core.experimental.actuators`: explicit actuators of articulations, from prims or from Python."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graph.isaac.managers.simulation_events import SimulationEvent
from graph.isaac.modules.articulation import Articulation
from graph.isaac.modules.managers import SimulationManager
from graph.isaac.results import numbers, rows
from graph.isaac.session import app
from graph.sim.usd import Sdf, Usd, UsdPhysics

from .laws import Controller
from .robot import Actuated, Actuator, actuators_below

__all__ = [
    "ActuatorConfig",
    "ArticulationActuators",
    "DCMotorClampingConfig",
    "DelayConfig",
    "MaxEffortClampingConfig",
    "NeuralControlConfig",
    "PDControlConfig",
    "PIDControlConfig",
    "PositionBasedClampingConfig",
    "add_actuator",
]


@dataclass
class ActuatorConfig:
    controller: Any
    clamping: list[Any] = field(default_factory=list)
    delay: Any = None


@dataclass
class PDControlConfig:
    kp: float
    kd: float
    const_effort: float = 0.0


@dataclass
class PIDControlConfig:
    kp: float
    ki: float
    kd: float
    integral_max: float = math.inf
    const_effort: float = 0.0


@dataclass
class NeuralControlConfig:
    model_path: str


@dataclass
class MaxEffortClampingConfig:
    max_effort: float


@dataclass
class DCMotorClampingConfig:
    saturation_effort: float
    velocity_limit: float
    max_motor_effort: float


@dataclass
class PositionBasedClampingConfig:
    lookup_positions: list[float]
    lookup_efforts: list[float]


@dataclass
class DelayConfig:
    delay_steps: int


_CONTROLS: Mapping[type, tuple[str, Sequence[str]]] = {
    PDControlConfig: ("NewtonPDControlAPI", ("kp", "kd", "constEffort")),
    PIDControlConfig: ("NewtonPIDControlAPI", ("kp", "ki", "kd", "integralMax", "constEffort")),
    NeuralControlConfig: ("NewtonNeuralControlAPI", ("modelPath",)),
}
_LIMITS: Mapping[type, tuple[str, Sequence[str]]] = {
    MaxEffortClampingConfig: ("NewtonMaxEffortClampingAPI", ("maxEffort",)),
    DCMotorClampingConfig: ("NewtonDCMotorClampingAPI", ("saturationEffort", "velocityLimit", "maxMotorEffort")),
    PositionBasedClampingConfig: ("NewtonPositionBasedClampingAPI", ("lookupPositions", "lookupEfforts")),
}
_DELAYS: Mapping[type, tuple[str, Sequence[str]]] = {DelayConfig: ("NewtonActuatorDelayAPI", ("delaySteps",))}
"""By class: the API schema, and its attributes after `newton:` in the order of the fields."""
_TYPES = {
    "modelPath": Sdf.ValueTypeNames.Asset,
    "delaySteps": Sdf.ValueTypeNames.Int,
    "lookupPositions": Sdf.ValueTypeNames.FloatArray,
    "lookupEfforts": Sdf.ValueTypeNames.FloatArray,
}


def add_actuator(
    articulation_root: Any,
    target_names: str | list[str],
    name: str,
    controller: Any,
    *,
    clamping: list[Any] | None = None,
    delay: DelayConfig | None = None,
    overwrite_existing: bool = False,
) -> Any:
    stage, root = app().stage, Sdf.Path(str(articulation_root))
    path = root.AppendPath(f"Actuators/{name}")
    if stage.GetPrimAtPath(path) and not overwrite_existing:
        raise ValueError(f"{path} exists; give overwrite_existing=True to replace it")
    limits = list(clamping or ())
    if len({type(one) for one in limits}) < len(limits):
        raise ValueError("clamping has two of the same class; give each at most once")
    wrong = next((one for one in limits if isinstance(one, PositionBasedClampingConfig) and not _fits(one)), None)
    if wrong is not None:
        raise ValueError(
            f"{len(wrong.lookup_positions)} lookup_positions and {len(wrong.lookup_efforts)} lookup_efforts; "
            "give one effort for each position, and at least one"
        )
    targets = [_joint(stage, root, one) for one in ([target_names] if isinstance(target_names, str) else target_names)]
    parts = [(controller, _CONTROLS), *((one, _LIMITS) for one in limits), *([(delay, _DELAYS)] if delay else ())]
    for config, kinds in parts:
        if type(config) not in kinds:
            raise TypeError(f"{config!r} is not one of {', '.join(one.__name__ for one in kinds)}")
    stage.RemovePrim(path)
    prim = stage.DefinePrim(path, "NewtonActuator")
    for config, kinds in parts:
        schema, attributes = kinds[type(config)]
        prim.AddAppliedSchema(schema)
        for attribute, value in zip(attributes, vars(config).values(), strict=True):
            prim.CreateAttribute(f"newton:{attribute}", _TYPES.get(attribute, Sdf.ValueTypeNames.Float)).Set(value)
    prim.CreateRelationship("newton:targets").SetTargets(targets)
    return prim


def _fits(table: PositionBasedClampingConfig) -> bool:
    return len(table.lookup_positions) == len(table.lookup_efforts) > 0


def _joint(stage: Any, root: Any, name: str) -> Any:
    below = stage.GetPrimAtPath(root)
    joints = [one for one in Usd.PrimRange(below) if one.IsA(UsdPhysics.Joint)] if below else []
    found = [one.GetPath() for one in joints if one.GetName() == name]
    if len(found) != 1:
        known = ", ".join(sorted({one.GetName() for one in joints})) or "none"
        raise ValueError(f"{len(found)} joints below {root} are called {name!r}; it has {known}")
    return found[0]


class ArticulationActuators:
    def __init__(
        self,
        paths: Any,
        *,
        auto_step_pre_physics: bool = True,
        device: str | None = None,
        _skip_discovery: bool = False,
    ) -> None:
        self._articulation = Articulation(paths)
        found = {}
        if not _skip_discovery and len(self._articulation):
            found = actuators_below(self._articulation.prims[0], self._articulation.dof_paths[0])
        self._auto_step_pre_physics = auto_step_pre_physics
        self._actuator_callback_id: int | None = None
        self._take(found)
        self._lifecycle_callback_ids = [
            SimulationManager.register_callback(self._on_physics_ready, SimulationEvent.SIMULATION_STARTED),
            SimulationManager.register_callback(self._on_stop, SimulationEvent.SIMULATION_STOPPED),
        ]
        if not _skip_discovery and app().physics is not None:
            self._on_physics_ready(None)

    @classmethod
    def from_actuators(
        cls, paths: Any, actuators: list[tuple[ActuatorConfig, str]], *, auto_step_pre_physics: bool = True
    ) -> ArticulationActuators:
        made = cls(paths, auto_step_pre_physics=auto_step_pre_physics, _skip_discovery=True)
        found: dict[int, Any] = {}
        for config, name in actuators:
            number = int(made._articulation.get_dof_indices(name).numpy()[0])
            if number in found:
                raise ValueError(f"the joint {name!r} has two actuators; give it one")
            if not isinstance(config.controller, Controller):
                raise TypeError(
                    f"{type(config.controller).__module__}.{type(config.controller).__name__} does not run here: "
                    "the installed package newton hides the controllers that come with TickGraph; remove it"
                )
            found[number] = Actuator(config.controller, config.clamping, config.delay)
        made._take(found)
        if app().physics is not None:
            made._on_physics_ready(None)
        return made

    def _take(self, found: Mapping[int, Any]) -> None:
        self._actuated = Actuated(app(), self._articulation.paths, found)

    def __enter__(self) -> ArticulationActuators:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def articulation(self) -> Articulation:
        return self._articulation

    @property
    def actuators(self) -> list[Any]:
        return list(self._actuated.actuators.values())

    @property
    def actuated_dof_indices(self) -> list[int]:
        return list(self._actuated.actuators)

    def close(self) -> None:
        self.disable_auto_step_pre_physics()
        for number in self._lifecycle_callback_ids:
            SimulationManager.deregister_callback(number)
        self._lifecycle_callback_ids = []

    def set_dof_feedforward_effort_targets(
        self, target_feedforward_efforts: Any, *, indices: Any = None, dof_indices: Any = None
    ) -> None:
        robots = numbers(indices, len(self._articulation))
        joints = numbers(dof_indices, self._articulation.num_dofs)
        given = rows(target_feedforward_efforts, len(robots), len(joints), "target_feedforward_efforts")
        if given is not None:
            self._actuated.feed(given, robots, joints)

    def enable_auto_step_pre_physics(self) -> None:
        self._auto_step_pre_physics = True
        if self._actuator_callback_id is None:
            self._actuator_callback_id = SimulationManager.register_callback(
                self.step_actuators, SimulationEvent.PHYSICS_PRE_STEP
            )

    def disable_auto_step_pre_physics(self) -> None:
        self._auto_step_pre_physics = False
        self._end_steps()

    def _end_steps(self) -> None:
        if self._actuator_callback_id is not None:
            SimulationManager.deregister_callback(self._actuator_callback_id)
            self._actuator_callback_id = None

    def reset(self) -> None:
        self._actuated.reset()

    def step_actuators(self, step_dt: float, context: Any = None) -> None:
        self._actuated.step(step_dt)

    def _on_physics_ready(self, event: Any) -> None:
        self._actuated.release_drives()
        if self._auto_step_pre_physics:
            self.enable_auto_step_pre_physics()
        self.reset()

    def _on_stop(self, event: Any) -> None:
        self._end_steps()
