"""Actuators and sensors of a playing model as attributes of their prims.

`mjc:ctrl` of an actuator is its control: a value written on the stage or in Fabric takes effect in the next physics
step. `mjc:force`, `mjc:length`, `mjc:velocity` of an actuator and `mjc:value` of a sensor are those of the last step.
All are in SI units, whatever units the model uses for angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim.physics.mujoco.engine import MujocoEngine
from graph.sim.usd import Tf, Usd

if TYPE_CHECKING:
    from graph.sim.phases import Phases
    from graph.sim.state.playing_world import PlayingWorld

    from .scene import MjcfScene

CONTROL, VALUE = "mjc:ctrl", "mjc:value"
OUTPUTS = ("mjc:force", "mjc:length", "mjc:velocity")


def _engine(world: PlayingWorld) -> MujocoEngine | None:
    """The engine that plays the model."""
    engine = world.physics
    assert engine is None or isinstance(engine, MujocoEngine)
    return engine


class Actuation:
    """An attribute of actuators, `ctrl`, `force`, `length` or `velocity`: a `state.attribute_values.Live`."""

    def __init__(self, world: PlayingWorld, names: Mapping[str, str], what: str) -> None:
        self._world, self._names, self._what = world, names, what

    def read(self, path: str) -> Any:
        """The present value; None while stopped and for a prim that is not an actuator."""
        engine = _engine(self._world)
        if engine is None or engine.motors is None or path not in self._names:
            return None
        return engine.motors.read(engine.data, self._names[path], self._what)

    def write(self, path: str, value: Any) -> None:
        """Sets a control. Raises RunError for a value that the actuator does not accept; other attributes ignore it."""
        engine = _engine(self._world)
        if self._what != "ctrl" or engine is None or engine.motors is None or path not in self._names:
            return
        try:
            engine.motors.write(engine.data, self._names[path], value)
        except (ValueError, TypeError) as error:
            raise RunError(f"{path}.{CONTROL}: {error}") from None


class Sensing:
    """`mjc:value` of sensors in Fabric: their measurements in the last step, in the units of the model's sensors."""

    def __init__(self, world: PlayingWorld, names: Mapping[str, str]) -> None:
        self._world, self._names = world, names

    def read(self, path: str) -> Any:
        """(n,) numbers; None while stopped and for a prim that is not a sensor."""
        engine = _engine(self._world)
        if engine is None or path not in self._names:
            return None
        sensor = engine.model.sensor(self._names[path])
        first = int(sensor.adr[0])
        return np.array(engine.data.sensordata[first : first + int(sensor.dim[0])])

    def write(self, path: str, value: Any) -> None:
        """Ignores the value."""


def serve(scene: MjcfScene, world: PlayingWorld, phases: Phases) -> None:
    """Connects a world's Fabric and stage to a scene's actuators and sensors, until the world closes."""
    model, paths = scene.model, scene.paths
    actuators = {path: model.actuator(number).name for number, path in enumerate(paths.actuators)}
    sensors = {path: model.sensor(number).name for number, path in enumerate(paths.sensors)}
    if actuators:
        control = Actuation(world, actuators, "ctrl")
        world.fabric.live[CONTROL] = control
        world.fabric.live.update({name: Actuation(world, actuators, name.partition(":")[2]) for name in OUTPUTS})

        def changed(notice: Any, sender: Any) -> None:
            for path in (*notice.GetChangedInfoOnlyPaths(), *notice.GetResyncedPaths()):
                if path.name == CONTROL and path.IsPropertyPath():
                    prim = str(path.GetPrimPath())
                    try:
                        control.write(prim, sender.GetAttributeAtPath(path).Get())
                    except RunError as error:  # USD swallows exceptions raised here
                        world.warn("mjcf-bad-control", prim, str(error))

        listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, changed, world.stage)
        scene.listeners.append(changed)

        def end() -> None:
            listener.Revoke()
            scene.listeners.remove(changed)

        phases.on("close", end)
    if sensors:
        world.fabric.live[VALUE] = Sensing(world, sensors)
