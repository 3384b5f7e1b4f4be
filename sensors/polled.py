"""Sensors without a render product: each is measured when a node reads it, at most once for each moment."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.base.suggesting import Suggesting

from .frame import Frame
from .sensor_types import sensor_types

if TYPE_CHECKING:
    from graph.sim.renderer.sensor import Sensor
    from graph.sim.renderer.view import WorldView


class PolledSensor(Suggesting):
    """A sensor that its readers share: the first one that reads at a moment triggers the measurement.

    sensor: the sensor itself. frame: its newest frame; None before the first.
    """

    def __init__(self, scene: WorldView, sensor: Sensor) -> None:
        self.sensor = sensor
        self.frame: Frame | None = None
        self._scene = scene

    def require(self, owner: object, channels: Iterable[str]) -> None:
        """Requests channels for an owner; see `Sensor.require`."""
        self.sensor.require(owner, channels)

    def release(self, owner: object) -> None:
        """Withdraws what an owner asked for."""
        self.sensor.release(owner)

    def read(self) -> Frame | None:
        """The newest frame, measured now if the time has moved since the last reading; None before the first."""
        tick = self.sensor.schedule.advance(self._scene.rendering.time)
        if tick is not None:
            tick.scene = self._scene
            if isinstance(frame := self.sensor.render(tick), Frame):
                self.frame = frame
        return self.frame


def polled_sensor(scene: WorldView, prim_path: str, prim_type: str) -> PolledSensor:
    """The polled sensor of a prim, one for all its readers until the timeline stops.

    Raises UserError for a prim of another type, or an invalid sensor prim.
    """
    shared: dict[str, PolledSensor] | None = scene.rendering.polled
    if shared is None:
        shared = scene.rendering.polled = {}
        _follow(scene, shared)
    found = shared.get(prim_path)
    if found is None:
        kind = str(scene.stage.GetPrimAtPath(prim_path).GetTypeName())
        if kind != prim_type:
            raise UserError(f"{prim_path} is a {kind or 'typeless prim'}; give the path of a {prim_type} prim")
        found = shared[prim_path] = PolledSensor(scene, sensor_types()[kind].runtime(scene, prim_path, (1, 1)))
    return found


def _follow(scene: WorldView, shared: dict[str, PolledSensor]) -> None:
    """Lets the polled sensors of a world take over edits of their prims, and end with a stop."""

    def refresh() -> None:
        for path, one in shared.items():
            if scene.stage.GetPrimAtPath(path) and one.sensor.refresh():
                one.frame = None

    scene.on("sensors_edited", refresh)
    for event in ("stop", "stage_closing", "close"):
        scene.on(event, shared.clear)
