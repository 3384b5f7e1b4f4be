"""Sensors without a render product: each is measured when a node reads it, at most once for each moment."""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.base.suggesting import Suggesting

from .frame import Frame
from .sensor_types import sensor_types

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.sensor import Sensor

_sensors: weakref.WeakKeyDictionary[App, dict[str, PolledSensor]] = weakref.WeakKeyDictionary()


class PolledSensor(Suggesting):
    """A sensor that its readers share: the first one that reads at a moment triggers the measurement.

    sensor: the sensor itself. frame: its newest frame; None before the first.
    """

    def __init__(self, app: App, sensor: Sensor) -> None:
        self.sensor = sensor
        self.frame: Frame | None = None
        self._app = weakref.ref(app)

    def require(self, owner: object, channels: Iterable[str]) -> None:
        """Requests channels for an owner; see `Sensor.require`."""
        self.sensor.require(owner, channels)

    def release(self, owner: object) -> None:
        """Withdraws what an owner asked for."""
        self.sensor.release(owner)

    def read(self) -> Frame | None:
        """The newest frame, measured now if the time has moved since the last reading; None before the first."""
        app = self._app()
        tick = self.sensor.schedule.advance(app.rendering.time) if app is not None else None
        if tick is not None and isinstance(frame := self.sensor.render(tick), Frame):
            self.frame = frame
        return self.frame


def polled_sensor(app: App, prim_path: str, prim_type: str) -> PolledSensor:
    """The polled sensor of a prim, one for all its readers until the timeline stops.

    Raises UserError for a prim of another type, or an invalid sensor prim.
    """
    shared = _sensors.get(app)
    if shared is None:
        shared = _sensors[app] = _shared(app)
    found = shared.get(prim_path)
    if found is None:
        kind = str(app.stage.GetPrimAtPath(prim_path).GetTypeName())
        if kind != prim_type:
            raise UserError(f"{prim_path} is a {kind or 'typeless prim'}; give the path of a {prim_type} prim")
        found = shared[prim_path] = PolledSensor(app, sensor_types()[kind].runtime(app, prim_path, (1, 1)))
        app.rendering.polled.add(prim_path)
    return found


def _shared(app: App) -> dict[str, PolledSensor]:
    """The polled sensors of an App; they take over edits of their prims, and end with a stop."""
    shared: dict[str, PolledSensor] = {}
    paths = app.rendering.polled

    def refresh() -> None:
        for path, one in shared.items():
            if app.stage.GetPrimAtPath(path) and one.sensor.refresh():
                one.frame = None

    def end() -> None:
        shared.clear()
        paths.clear()

    app.on("sensors_edited", refresh)
    app.on("stop", end)
    app.on("stage_closing", end)
    app.on("close", end)
    return shared
